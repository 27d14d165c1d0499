# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Bodies that share nodes at the start: `--check` names them, because they are joined without contact.

Would catch bodies that touch, and are therefore joined, without a word; a line about bodies that are apart or that
contact separates; and distances that are measured from boxes around bodies instead of their particles.
"""

import pytest

import case

DECK = """
&run  dimension='{dimension}'  method='{method}' /
&grid  lo=0,0,-3  hi=1,1,3  dx=0.1 /
&time  t_end=1.0e-3 /
&effects  artificial_viscosity=.false.  {effects} /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='u'  shape='box'  lo=0.3,0.2,{low!r}  hi=0.7,0.8,{top!r} /
&region  name='d'  shape='box'  lo=0.3,0.2,-0.4  hi=0.7,0.8,0 /
&body  name='u'  region='u'  material='m'  {packing} /
&body  name='d'  region='d'  material='m'  {packing} /
{more}
"""
SHARE = "joined     bodies 'u' and 'd' share nodes"


def check(options, name, rows, method="ddmp", dimension="plane_strain", effects="", more="", packing=""):
    """Output of --check for two blocks with some empty rows of cells between them."""
    low = 0.1 * rows
    deck = DECK.format(low=low, top=low + 0.4, method=method, dimension=dimension, effects=effects, more=more,
                       packing=packing)
    return case.Case(options, name, deck).run("--check", "--no-estimate").output


@pytest.mark.parametrize("dimension", ["plane_strain", "3d"])
def test_blocks(options, sheet, dimension):
    """Touching, one row apart, two rows apart."""
    for method in ("ddmp", "mpm"):
        lines = [check(options, f"{method}_{rows}", rows, method, dimension) for rows in (0, 1, 2)]
        sheet.require(SHARE in lines[0], f"{method}: blocks that touch share nodes")
        for rows in (1, 2):
            sheet.require("joined     " not in lines[rows], f"{method}: {rows} rows apart")


def test_other_packings(options, sheet):
    """Particles that are not on the lattice."""
    for packing in ("cut", "jitter", "poisson_disk"):
        sheet.require(SHARE in check(options, packing, 0, packing=f"packing='{packing}'"), f"{packing}: share nodes")
        sheet.require("joined     " not in check(options, f"{packing}_apart", 2, packing=f"packing='{packing}'"),
                      f"{packing}: apart")


def test_contact(options, sheet):
    """Contact separates bodies of different fields only."""
    contact = "&contact  bodies='*','*'  friction=0.1 /"
    sheet.require("joined     " not in check(options, "contact", 0, effects="contact=.true.", more=contact), "contact")
    same = "field=1"
    three = contact + ("\n&region name='w' shape='box' lo=0.3,0.2,1.5 hi=0.7,0.8,2 /\n"
                       "&body name='w' region='w' material='m' /")
    sheet.require(SHARE in check(options, "field", 0, effects="contact=.true.", more=three, packing=same),
                  "the same field")


def test_shapes(options, sheet):
    """Bodies whose boxes overlap although their particles are apart, and the log of a run."""
    deck = DECK.format(low=0.0, top=0.4, method="mpm", dimension="plane_strain", effects="", packing="", more="")
    deck = deck.replace("shape='box'  lo=0.3,0.2,0.0  hi=0.7,0.8,0.4", "shape='cylinder' axis=0,1,0 radius=0.15 "
                        "height=2 centre=0.2,0.5,-0.2")
    deck = deck.replace("shape='box'  lo=0.3,0.2,-0.4  hi=0.7,0.8,0", "shape='difference'  of='all','hole'")
    deck += ("&region name='all' shape='box' lo=0,0,-3 hi=1,1,3 /\n&region name='hole' shape='box' lo=-1,-1,-1 "
             "hi=0.8,2,1 /\n")
    sheet.require("joined     " not in case.Case(options, "inside", deck).run("--check", "--no-estimate").output,
                  "a disc in a hole")
    run = case.Case(options, "touches", deck.replace("centre=0.2,", "centre=0.7,")).run("-q")
    sheet.require(SHARE in run.path(".log").read_text(encoding="utf-8"), "the log of a run has the line")
