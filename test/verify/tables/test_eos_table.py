# SPDX-License-Identifier: BSD-3-Clause
"""Tabulated equations of state, in whole runs, against the closed ones from which the tables are made.

Would catch: an interpolation in a wrong cell, an initial energy that is not that of its temperature, a sound speed or
temperature of another state, a table that only one rank has, a state outside of the table with some pressure, a wrong
table that is accepted, one error that hides the next.

* Shock tube of Sod with the table of an ideal gas, in which pressure and energy are linear in density and
  temperature: the run agrees with that of the closed equation of state to rounding amplified by the steps, 1e-9, with
  the defaults of gases, so that the table is known to be one.
* Mie-Grueneisen: states behind shocks (`--point`) of tables with 21, 29, 45 and 65 nodes in each direction approach p =
  rho0 Us u with order 2, limit 1.8; a bar that hits a wall at 1000 m/s has the plateau of Rankine and Hugoniot to the 1
  % of pressure and 0.3 % of density that apply to the closed equation. Energy: rounding.
* Temperature: that of e = e_c(rho) + c_v (T - T0), to the error of the table, 1 %.
* Any ranks and threads, and restart: the same bits.
"""
# tiers: smoke, full
# timeout: 240

import subprocess

import numpy as np

import case
import convergence
from scree_post import state_table

GAMMA = 1.4
METAL = state_table.Solid(2785.0, 5328.0, 1.338, 2.0, 900.0)
METAL_WORDS = "density=2785  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2"

TUBE = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.01 /
&time  t_end=0.2 /
&effects  strength=.false. /
&material  name='dense'  density=1      {gas} /
&material  name='thin'   density=0.125  {gas} /
&region  name='left'   shape='box'  lo=0,0,0    hi=0.5,1,1 /
&region  name='right'  shape='box'  lo=0.5,0,0  hi=1,1,1 /
&body  name='left'   region='left'   material='dense'  ppc=4,1,1  specific_energy=2.5 /
&body  name='right'  region='right'  material='thin'   ppc=4,1,1  specific_energy=2.0 /
&boundary  face='all'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','pressure','density','velocity','energy' /
"""

BAR = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=0.022,1e-3,1e-3  dx=0.0001 /
&time  t_end=2.0e-6 /
&method  bulk_q1=0.5 /
&effects  strength=.false.  thermal=.true. /
&material  name='al'  {material}  specific_heat=900 /
&region  name='bar'  shape='box'  lo=0,0,0  hi=0.02,1e-3,1e-3 /
&body  name='bar'  region='bar'  material='al'  ppc=4,1,1  velocity={velocity},0,0 /
&boundary  face='xlo'  type='slip' /
&output  name='p'  kind='particles'  times=2.0e-6  precision='double'
  fields='velocity','stress','volume','mass','energy','temperature' /
"""

POINT = """
&effects  eos=.true. /
&material  name='al'  {material}  elastic='none' /
&point  path='hugoniot'  speed=2000  steps=100 /
"""

BLOCKS = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.08,1,0.04  dx=0.001 /
&time  t_end=1  max_steps=60 /
&effects  thermal=.true. /
&material  name='al'  density=2785  eos_model='table'  eos_table='al.txt'  specific_heat=900
  shear=27.6e9  strength_model='von_mises'  yield=0.3e9 /
&region  name='a'  shape='box'  lo=0.01,0,0.01  hi=0.04,1,0.03 /
&region  name='b'  shape='sphere'  centre=0.047,0,0.02  radius=0.007 /
&body  name='a'  region='a'  material='al'  ppc=2,1,2  temperature=400 /
&body  name='b'  region='b'  material='al'  ppc=2,1,2  velocity=-500,0,0 /
&parallel  balance='auto'  balance_every=7  imbalance=1.01 /
"""

FAULTS = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1 /
&effects  strength=.false. /
&material  name='a'  density=2785  eos_model='table'  eos_table='short.txt' /
&material  name='b'  density=2785  eos_model='table'  eos_table='nan.txt' /
&material  name='c'  density=2785  eos_model='table'  eos_table='none.txt' /
&material  name='d'  density=2785  eos_model='table'  eos_table='cold.txt' /
&material  name='e'  density=9999  eos_model='table'  eos_table='al.txt' /
&material  name='f'  density=2785  eos_model='table'  eos_table='al.txt'  table_temperature=1 /
&material  name='g'  density=2785  eos_model='table' /
&material  name='h'  density=2785  eos_model='table'  eos_table='al.txt'  mg_s=1 /
&material  name='i'  density=2785  eos_model='table'  eos_table='odd.txt' /
&material  name='j'  density=2785  eos_model='table'  eos_table='turned.txt' /
&region  name='r'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='r'  region='r'  material='a' /
"""
SAID = (
    "5: error: &material 'a': eos_table: cannot use the table '{}short.txt': line 7: expected four numbers",
    "6: error: &material 'b': eos_table: cannot use the table '{}nan.txt': line 9: expected four numbers",
    "7: error: &material 'c': eos_table: cannot read '{}none.txt': No such file or directory",
    "8: error: &material 'd': eos_table: cannot use the table '{}cold.txt': line 6: the energy must increase",
    "9: error: &material 'e': eos_table: density = 9999 kg/m3 lies outside of the table '{}al.txt'",
    "10: error: &material 'f': eos_table: table_temperature = 1 K lies outside of the table '{}al.txt'",
    "11: error: &material 'g': eos_table must be given",
    "12: error: &material 'h': mg_s given but eos_model = 'table' does not use it",
    "13: warning: &material 'i': eos_table: pressure and energy of the table '{}odd.txt' are inconsistent",
    "14: error: &material 'j': eos_table: cannot use the table '{}turned.txt': line 37: densities must ascend",
)


def write_metal(folder, quarter, greatest=5000.0):
    """A table of aluminium with 4 `quarter` + 1 nodes in each direction, of which one is the state at rest."""
    densities = np.concatenate((state_table.axis(2150.0, METAL.density, quarter + 1)[:-1],
                                state_table.axis(METAL.density, greatest, 3 * quarter + 1)))
    temperatures = np.concatenate((state_table.axis(60.0, METAL.zero, quarter + 1)[:-1],
                                   state_table.axis(METAL.zero, 20000.0, 3 * quarter + 1)))
    pressure, energy = state_table.mie_gruneisen(densities, temperatures, METAL)
    # the zero of energies is arbitrary, and pressures of fluids are relaxed only where they are positive
    state_table.write(folder / "al.txt", densities, temperatures, pressure, energy + 5.0e5, "aluminium")


def test_tube(options, sheet):
    """Both runs end in the same states."""
    states = {}
    for name, gas in (("closed", f"eos_model='ideal_gas'  ig_gamma={GAMMA}"),
                      ("table", "eos_model='table'  eos_table='gas.txt'  table_temperature=1")):
        run = case.Case(options, f"tube_{name}", TUBE.format(gas=gas))
        axes = state_table.axis(0.01, 5.0, 30), state_table.axis(0.5, 20.0, 30)
        state_table.write(run.folder / "gas.txt", *axes, *state_table.ideal_gas(*axes, GAMMA, 1.0), "gas")
        last = run.run("-q").snapshots()[-1][1]
        order = np.argsort(last.fields["identity"])
        states[name] = {key: last.fields[key][order] for key in ("pressure", "density", "energy", "velocity")}
        sheet.below(f"tube, {name}: energy", run.summary["ledger"]["energy_error"], 1.0e-12)
    for key, values in states["closed"].items():
        sheet.below(f"tube: {key}, table and closed", abs(states["table"][key] - values).max() / abs(values).max(),
                    1.0e-9)


def test_hugoniot(options, sheet):
    """Order of the pressure behind shocks."""
    errors, grids = [], (5, 7, 11, 16)
    for quarter in grids:
        run = case.Case(options, f"point_{quarter}", POINT.format(
            material="density=2785  eos_model='table'  eos_table='al.txt'"))
        write_metal(run.folder, quarter)
        run.run("--point")
        rows = np.loadtxt(run.path("_point.csv"), delimiter=",", skiprows=1)
        exact = METAL.density * (METAL.sound + METAL.slope * rows[:, 0]) * rows[:, 0]
        errors.append(np.sqrt(np.mean((rows[:, 2] - exact) ** 2)) / exact[-1])
    order = convergence.order(grids, errors)
    print("         Hugoniot, errors of the pressure:", *[f"{error:.2e}" for error in errors], f" order: {order:.2f}")
    sheet.above("Hugoniot: order", order, 1.8)
    sheet.below("Hugoniot: error with 65 nodes", errors[-1], 1.0e-3)


def test_bar(options, sheet):
    """Plateau behind the shock at a wall."""
    speed = 1000.0
    front = METAL.sound + METAL.slope * speed
    exact = {"pressure": METAL.density * front * speed, "density": METAL.density * front / (front - speed)}
    cold = state_table.cold_energies([exact["density"]], METAL)[0]
    exact["temperature"] = METAL.zero + (0.5 * speed ** 2 - cold) / METAL.heat
    run = case.Case(options, "bar", BAR.format(
        material="density=2785  eos_model='table'  eos_table='al.txt'", velocity=-speed))
    write_metal(run.folder, 30)
    last = run.run("-q").snapshots()[-1][1]
    here = (last.points[:, 0] > 0.002) & (last.points[:, 0] < 0.008)
    fields = last.fields
    sheet.near("bar: pressure", -fields["stress"][here, 0].mean(), exact["pressure"], 0.01)
    sheet.near("bar: density", fields["mass"][here].sum() / fields["volume"][here].sum(), exact["density"], 0.003)
    sheet.near("bar: temperature", fields["temperature"][here].mean(), exact["temperature"], 0.01)
    sheet.below("bar: energy", run.summary["ledger"]["energy_error"], 1.0e-12)
    ahead = last.points[:, 0] > 0.0175
    sheet.below("bar: temperature ahead of the shock", abs(fields["temperature"][ahead] - METAL.zero).max(), 0.1)
    version = subprocess.run([options.scree, "--version"], stdout=subprocess.PIPE, text=True, check=True).stdout
    if " Debug " in version:
        sheet.skipped("a run that leaves its table", "a build that traps bad numbers stops before the message")
        return
    outside = case.Case(options, "outside", BAR.format(
        material="density=2785  eos_model='table'  eos_table='al.txt'", velocity=-speed))
    write_metal(outside.folder, 8, greatest=3100.0)
    outside.run("-q", expect=4)
    sheet.require("its stress is not a finite number; it left its eos_table: density" in outside.output,
                  f"a run that leaves its table says so: {outside.output[-600:]}")


def test_layouts(options, sheet):
    """The same bits for any ranks and threads."""
    digests = {}
    for ranks, threads in ((1, 1), (2, 1), (1, 2)):
        run = case.Case(options, f"blocks_{ranks}_{threads}", BLOCKS, ranks, threads)
        write_metal(run.folder, 10)
        digests[ranks, threads] = run.run("-q").summary["digest"]
    sheet.below("blocks: energy", run.summary["ledger"]["energy_error"], 1.0e-12)
    stopped = case.Case(options, "blocks_restart", BLOCKS, 2)
    write_metal(stopped.folder, 10)
    stopped.run("-q", "-s", "time.max_steps=25")
    sheet.require(stopped.summary["digest"] != digests[1, 1], "the middle is not the end")
    stopped.ranks = 1
    digests["restart"] = stopped.run("-q", "--restart").summary["digest"]
    sheet.require(len(set(digests.values())) == 1, f"same bits: {digests}")


def test_faults(options, sheet):
    """All errors in one pass, each with its line."""
    run = case.Case(options, "faults", FAULTS.lstrip())
    write_metal(run.folder, 8)
    good = (run.folder / "al.txt").read_text(encoding="ascii").splitlines()

    def change(name, line, words):
        lines = list(good)
        lines[line - 1] = words(lines[line - 1].split())
        (run.folder / name).write_text("\n".join(lines) + "\n", encoding="ascii")

    change("short.txt", 7, lambda words: " ".join(words[:3]))
    change("nan.txt", 9, lambda words: " ".join([*words[:2], "NaN", words[3]]))
    change("cold.txt", 6, lambda words: " ".join([*words[:3], "-1e9"]))
    rows = [line.split() for line in good[3:]]
    odd = [" ".join([*row[:2], repr(float(row[2]) + 5.0e9), row[3]]) for row in rows]
    (run.folder / "odd.txt").write_text("\n".join(odd) + "\n", encoding="ascii")
    (run.folder / "turned.txt").write_text("\n".join(good[:3] + good[36:69] + good[3:36]) + "\n", encoding="ascii")
    run.run("--check", expect=2)
    place = f"{run.folder}/"
    for line in SAID:
        sheet.require(f"{run.deck}:{line.format(place)}" in run.output, f"faults: {line}\n{run.output}")
