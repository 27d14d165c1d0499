# SPDX-License-Identifier: BSD-3-Clause
"""Scenes in a periodic cell that deforms, &cell and &stage, and the table of the cell.

    import cells
    one = cells.run(options, "shear", cells.granular(0.7))
    one["stress_xz"]                  # columns of CASE_cell.csv and of CASE_history.csv as arrays
"""

import csv

import numpy as np

import case

SCENE = """&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,0  hi=1,{thick!r},1  dx={dx!r} /
&time  t_end={end!r}  cfl={cfl} /
&method  {words} /
&boundary  face='all'  type='periodic' /
&effects  artificial_viscosity=.false. {effects} /
&material  name='m'  {material} /
&region  name='all'  shape='box'  lo=0,0,0  hi=1,{thick!r},1 /
&body  name='b'  region='all'  material='m'  {body} /
{cell}
&output  name='cell'  kind='cell'  every={every} /
&output  name='balance'  kind='history'  every={every} /
"""


def scene(material, stages, end, **more):
    """A unit cell filled with one material; `stages` are the groups &stage, or None for a scene without a cell."""
    values = {"dimension": "plane_strain", "method": "ddmp", "thick": 1.0, "dx": 0.125, "cfl": 0.5, "words": "flip=1",
              "effects": "", "body": "", "every": 1, "tilt": 0, **more}
    values.update(material=material, end=end)
    values["cell"] = "" if stages is None else f"&cell  tilt={values['tilt']} /\n{stages}"
    text = SCENE.format(**values)
    if stages is None:
        text = text.replace(f"&output  name='cell'  kind='cell'  every={values['every']} /\n", "")
    return text


def granular(relaxation, rate=2.0, strain=6.0, dimension="plane_strain"):
    """Granular material with relaxing contacts, G = 3 Pa, in steady shear that starts from rest."""
    rates = f"0,0,0,{rate},0,0" if dimension == "3d" else f"0,0,0,0,{rate},0"
    return scene(f"density=0.1  bulk=5  shear=3  strength_model='granular'  gr_tau={relaxation}",
                 f"&stage  rate={rates}  strain={strain} /", strain / rate, dx=0.25, dimension=dimension)


def kelvin(cells, method="ddmp", transfer="flip", strain=1.0, viscosity=0.02, speed=0.1):
    """A wave across the plane of shear in a viscous fluid, with its initial wave vector along x."""
    dx = 1.0 / cells
    return scene(f"density=1  bulk=25  strength_model='newtonian'  viscosity={viscosity}",
                 f"&stage  rate=0,0,0,0,1,0  strain={strain} /", strain, method=method,
                 words="flip=1" if transfer == "flip" else f"transfer='{transfer}'", dimension="3d", dx=dx,
                 thick=4.0 * dx, body=f"velocity_formula='0','{speed}*cos(2*pi*x)','0'")


def table(path):
    """The columns of a table as arrays, without their units."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.reader(file))
    return {name.split(" [")[0]: np.array([float(row[n]) for row in rows[1:]]) for n, name in enumerate(rows[0])}


def run(options, name, deck, ranks=1, threads=1):
    """Run a deck; the columns of both tables, and the case."""
    one = case.Case(options, name, deck, ranks, threads)
    one.run("--quiet")
    columns = table(one.path("_history.csv"))
    if one.path("_cell.csv").exists():
        columns.update(table(one.path("_cell.csv")))
    columns["case"] = one
    return columns
