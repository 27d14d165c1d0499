# SPDX-License-Identifier: BSD-3-Clause
"""A plane detonation of TNT that starts at a wall, and the wave of G. I. Taylor behind it.

Would catch: a front that does not propagate at the detonation speed, a burn that does not end in the Chapman-Jouguet
state, products that do not expand along their isentrope, chemical energy that is lost or counted twice, burn times that
depend on ranks or are lost in a restart.

The flow is self-similar in x/t (G. I. Taylor, Proc. R. Soc. A 200 (1950) 235); the reference of
test/support/detonation.py uses the constants alone. The front is where the pressure first exceeds half of that of the
Chapman-Jouguet state, its speed from two times. Errors are means over the tube of the difference from Taylor's wave.

Limits: speed 0.1 %. Pressure of the products at rest behind the wave 0.5 %. Errors of pressure and velocity 3 % of the
state behind the front with 200 cells; their order at least that of 0.65 for each doubling of the cells, 0.62, as the
front is spread over cells (order 1). Greatest pressure: at least 85 and 90 % of the Chapman-Jouguet pressure, never
above it by more than 1 %: directly behind the front of 2.5 cells the pressure decreases by about its own value over the
length of the tube. Energy: rounding.
"""
# tiers: smoke, full

import numpy as np

import case
import convergence
import detonation
import measured

DECK = """
&run  dimension='1d' /
&units  system='si' /
&grid  lo=0,0,0  hi=0.1,1,1  dx={spacing} /
&time  t_end=12e-6 /
&effects  strength=.false. /
&material  name='tnt'  preset='tnt' /
&region  name='tube'  shape='box'  lo=0,0,0  hi=0.1,1,1 /
&body  name='tube'  region='tube'  material='tnt'  ppc=4,1,1 /
&boundary  face='all'  type='symmetry' /
&detonation  shape='plane'  point=0,0,0  normal=1,0,0 /
&output  name='p'  kind='particles'  count=2  precision='double'
  fields='pressure','velocity','burn_time','energy','mass' /
"""
SPEED = 6930.0  # detonation_speed of the preset


def front(snapshot, pressure):
    """Position at which the pressure exceeds half of a value, searched from the front inwards."""
    order = np.argsort(snapshot.points[:, 0])
    place, found = snapshot.points[order, 0], snapshot.fields["pressure"][order]
    last = np.flatnonzero(found > 0.5 * pressure)[-1]
    share = (found[last] - 0.5 * pressure) / (found[last] - found[last + 1])
    return place[last] + share * (place[last + 1] - place[last])


def burn(options, cells):
    """Speed of the front, errors against Taylor's wave, state at rest and energy."""
    run = case.Case(options, f"plane_{cells}", DECK.format(spacing=0.1 / cells)).run("-q")
    (_, first), (early, middle), (late, last) = run.snapshots()
    _, pressure, volume = detonation.TNT.detonation()
    behind = SPEED * (1.0 - volume)
    place, along, velocity = detonation.TNT.taylor_wave()
    ratio = last.points[:, 0] / late
    burnt = ratio < SPEED
    expected = np.where(burnt, np.interp(ratio, place, along), 0.0)
    flow = np.where(burnt, np.interp(ratio, place, velocity), 0.0)
    rest = ratio < 0.25 * SPEED
    result = {
        "speed": (front(last, pressure) - front(middle, pressure)) / (late - early),
        "pressure": abs(last.fields["pressure"] - expected).mean() / pressure,
        "velocity": abs(last.fields["velocity"][:, 0] - flow).mean() / behind,
        "rest": last.fields["pressure"][rest].mean() / along[0],
        "peak": last.fields["pressure"].max() / pressure,
        "times": abs(first.fields["burn_time"] - first.points[:, 0] / SPEED).max() * SPEED,
        "chemical": (first.fields["energy"] * first.fields["mass"]).sum() / (7.0e9 * 0.1),
        "still": abs(first.fields["pressure"]).max(), "energy": abs(run.summary["ledger"]["energy_error"]),
        "digest": run.summary["digest"]}
    measured.show(f"{cells} cells", {key: value for key, value in result.items() if key != "digest"})
    return result


def test_update(options, sheet):
    """Would catch a stress update before the forces that burns with the clock of another time: the front is where it is
    with the usual order, within a cell, and what it has not reached is without pressure."""
    for update in ("usl", "usf"):
        deck = DECK.format(spacing=0.001) + f"&method  stress_update='{update}' /\n"
        run = case.Case(options, f"update_{update}", deck).run("-q")
        (late, last) = run.snapshots()[-1]
        _, pressure, _ = detonation.TNT.detonation()
        sheet.below(f"{update}: distance of the front in cells", abs(front(last, pressure) - SPEED * late) / 0.001, 2.0)
        beyond = last.points[:, 0] > SPEED * late + 0.002
        sheet.require(beyond.sum() > 20, f"{update}: there is explosive beyond the front")
        sheet.below(f"{update}: pressure beyond the front", abs(last.fields["pressure"][beyond]).max() / pressure, 0.01)


def slowest(options):
    """Least shock speed in the output of `--point`: the detonation speed of the constants."""
    deck = """&effects  strength=.false. /
&material  name='tnt'  preset='tnt' /
&point  path='hugoniot'  speed=4000  steps=400 /
"""
    run = case.Case(options, "states", deck).run("--point", "-q")
    table = np.genfromtxt(run.path("_point.csv"), delimiter=",", names=True)
    return table["shock_speed"].min()


def test_plane_burn(options, sheet):
    """Four resolutions, and the same bits on two ranks and after a restart."""
    runs = {cells: burn(options, cells) for cells in (140, 200, 270, 370)}
    coarse, fine = runs[200], runs[370]
    for cells, result, peak in ((200, coarse, 0.85), (370, fine, 0.90)):
        sheet.near(f"speed of the front, {cells} cells", result["speed"], SPEED, 1.0e-3)
        sheet.near(f"pressure at rest, {cells} cells", result["rest"], 1.0, 5.0e-3)
        sheet.above(f"greatest pressure, {cells} cells", result["peak"], peak)
        sheet.below(f"greatest pressure, {cells} cells", result["peak"], 1.01)
        sheet.below(f"energy, {cells} cells", result["energy"], 1.0e-12)
        sheet.below(f"burn times in metres, {cells} cells", result["times"], 1.0e-12)
    sheet.near("least speed of shocks of one point", slowest(options), detonation.TNT.detonation()[0], 1.0e-5)
    sheet.near("chemical energy at the start", fine["chemical"], 1.0, 1.0e-12)
    sheet.require(fine["still"] == 0.0, "the explosive has no pressure before the burn")
    for name in ("pressure", "velocity"):
        sheet.below(f"error of {name}, 200 cells", coarse[name], 0.03)
        order = convergence.order(runs, [result[name] for result in runs.values()])
        sheet.above(f"order of the error of {name}", order, -np.log2(0.65))
    same = case.Case(options, "plane_ranks", DECK.format(spacing=0.1 / 200), ranks=2).run("-q")
    sheet.require(same.summary["digest"] == coarse["digest"], "two ranks give the same bits")
    again = case.Case(options, "plane_again", DECK.format(spacing=0.1 / 200))
    again.run("-q", "--set", "time.max_steps=150")
    sheet.require(again.summary["digest"] != coarse["digest"], "the middle of the run is not its end")
    again.run("-q", "--restart")
    sheet.require(again.summary["digest"] == coarse["digest"], "a restart gives the same bits")
