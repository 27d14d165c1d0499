# SPDX-License-Identifier: BSD-3-Clause
"""Plates that collide, separate, and break; waves at a jump of the impedance.

Would catch: stress or velocity that does not agree with the impedances, a free surface that absorbs part of a wave, a
plate that does not support tension or supports it beyond its strength, failed material that still transmits tension,
bodies that stick together, an interface of light and heavy material that moves with the wrong one.

All waves are acoustic: strains are below a thousandth, so stress and velocity jump as rho c. A flyer of
thickness h meets a target of 2 h with the speed V: stress rho c V/2; the free surface of the target has the velocity V
from 2 h/c on for 2 h/c, then 0 again, unless the middle of the last h breaks. With a strength s below rho c V/2 the
velocity of the surface decreases only to V - 2 s/(rho c) (the pull-back; G. I. Kanel, Int. J. Fract. 163 (2010) 173),
provided that the cells resolve the pulse. Bars of impedances Z1, Z2: a wave is reflected by R = (Z2 - Z1)/(Z1 + Z2).

Limits. Stress, plateau and the state after the pulse: target 1 %. Arrival and length of the pulse: half of the six
cells that a shock may be wide, of the 80 that it crosses. Tension: at least that of the formula. Pull-back and depth of
the first break: two cells, because a node gives its tension to both of its cells; the peak of the tension changes by 2
s0/h per cell, the break by a cell of s h/(2 s0). After the break the velocity of the surface must increase by at least
half of the pull-back. R: 1 % (H-13 in hard_cases.md).

Tier long: the pull-back with 40, 60, 88 and 132 cells; order 0.8 for an error of first order.
"""
# tiers: full, long

import numpy as np
import pytest

import case
import convergence
import measured

DENSITY, SOUND, THICK = 2703.0, 6400.0, 2.0e-3     # kg/m3, m/s, m
DECK = """
&run  dimension='1d'  method='{method}' /
&grid  lo=0,0,0  hi={box!r},1,1  dx={size!r} /
&time  t_end={end!r} /
&method  {words} /
&effects  strength=.false.  damage={damage} /
{matter}
&output  name='p'  kind='particles'  count={count}  precision='double'
  fields='identity','velocity','stress','volume','mass'{more} /
&output  name='h'  kind='history'  every=10 /
&checkpoint  at_end=.false. /
"""
PLATE = """
&material  name='{name}'  density={density!r}  bulk={bulk!r}  {law} /
&region  name='{name}'  shape='box'  lo={lo!r},0,0  hi={hi!r},1,1 /
&body  name='{name}'  region='{name}'  material='{name}'  ppc={ppc},1,1  velocity={velocity!r},0,0 /
"""


def plate(name, low, high, velocity=0.0, density=DENSITY, sound=SOUND, law="", ppc=4):
    """A body of acoustic material."""
    return PLATE.format(name=name, density=density, bulk=density * sound ** 2, lo=low, hi=high, velocity=velocity,
                        law=law, ppc=ppc)


def launch(options, name, matter, box, size, end, count=100, method="ddmp", words="", damage=False):
    """Run; times, and fields of the particles in their initial order, (time, particle)."""
    deck = DECK.format(box=box, size=size, end=end, count=count, method=method, words=words, matter=matter,
                       damage=".true." if damage else ".false.", more=",'failed'" if damage else "")
    run = case.Case(options, name, deck).run("-q")
    begin = run.snapshots()[0][1]
    row = np.argsort(begin.points[:, 0])
    names = begin.fields["identity"][row]
    table = {"time": [], "place": [], "velocity": [], "stress": [], "failed": []}
    for time, snap in run.snapshots():
        where = np.argsort(snap.fields["identity"])[np.searchsorted(np.sort(names), names)]
        table["time"].append(time)
        table["place"].append(snap.points[where, 0])
        table["velocity"].append(snap.fields["velocity"][where, 0])
        table["stress"].append(snap.fields["stress"][where, 0])
        table["failed"].append(snap.fields["failed"][where] if damage else np.zeros(len(where)))
    return {key: np.array(values) for key, values in table.items()}, run.summary


def flyer(options, cells, speed=20.0, strength=None, method="ddmp", words=""):
    """A flyer meets a target, both of the same material; figures of target and free surface."""
    size = THICK / cells
    law = f"spall={strength!r}" if strength else ""
    low = round(16 * size, 12)
    matter = (plate("flyer", low, low + THICK, speed, law=law)
              + plate("target", low + THICK, low + 3.0 * THICK, law=law))
    travel = THICK / SOUND
    table, summary = launch(options, f"flyer_{cells}_{method}_{bool(strength)}", matter, low + 3.0 * THICK + 16 * size,
                            size, 6.0 * travel, 120, method, words, bool(strength))
    time, surface = table["time"] / travel, table["velocity"][:, -4:].mean(axis=1) / speed
    impulse = 0.5 * DENSITY * SOUND * speed
    result = {"table": table, "time": time, "surface": surface, "summary": summary}
    near = 4 * cells + 2 * cells     # a quarter of the target
    at = np.argmin(abs(time - 1.4))
    result["stress"] = -table["stress"][at, near:near + 4].mean() / impulse - 1.0
    result["plateau"] = surface[(time > 2.4) & (time < 3.6)].mean() - 1.0
    half = np.flatnonzero(surface > 0.5)
    result["arrival"] = np.interp(0.5, surface[half[0] - 1:half[0] + 1], time[half[0] - 1:half[0] + 1]) / 2.0 - 1.0
    fall = half[0] + np.flatnonzero(surface[half[0]:] < 0.5)
    result["pulse"] = (time[fall[0]] - time[half[0]]) / 2.0 - 1.0 if len(fall) else float("nan")
    result["tension"] = table["stress"].max() / impulse
    result["after"] = surface[(time > 4.5) & (time < 5.5)].mean()
    result["books"] = summary["ledger"]
    return result


def show(name, result, keys):
    """Print one line."""
    measured.show(name, {key: result[key] for key in keys})


def spall(options, cells, share, method="ddmp", words=""):
    """A pulse that rises over h/4 and falls over h meets a free surface; figures of the break.

    It is made by a layer with these velocities between a backing and a target of 2 h at rest: the half that propagates
    forward compresses, the other one pulls at layer and backing, which do not break. With the peak s0 the tension at a
    depth d below the surface reaches 2 s0 d/h, so the target breaks at s h/(2 s0).
    """
    speed, size, travel = 20.0, THICK / cells, THICK / SOUND
    impulse = 0.5 * DENSITY * SOUND * speed
    strength = share * impulse
    law = f"spall={strength!r}"
    low = round(8 * size, 12)
    start = low + 3.0 * THICK
    front = start + 1.25 * THICK
    matter = plate("backing", low, start) + plate("target", front, front + 2.0 * THICK, law=law)
    for layer in range(cells + cells // 4):
        place = (layer + 0.5) / cells
        share_of_speed = min(place, 4.0 * (1.25 - place))
        matter += (f"&region  name='r{layer}'  shape='box'  lo={start + layer * size!r},0,0  "
                   f"hi={start + (layer + 1) * size!r},1,1 /\n&body  name='r{layer}'  region='r{layer}'  "
                   f"material='backing'  ppc=4,1,1  velocity={speed * share_of_speed!r},0,0 /\n")
    table, summary = launch(options, f"spall_{cells}_{method}_{round(100 * share)}", matter,
                            front + 2.0 * THICK + 16 * size, size, 4.0 * travel, 100, method, words, True)
    time, surface = table["time"] / travel, table["velocity"][:, -2:].mean(axis=1) / speed
    begin = table["place"][0]
    peak = surface.max()
    window = (time > 2.25) & (time < 2.35 + 1.5 * share)
    least = surface[window].min()
    first = np.flatnonzero(table["failed"].any(axis=1))
    failed = table["failed"][first[0]] > 0.0 if len(first) else np.zeros(len(begin), bool)
    depth = (begin[-1] + 0.125 * size - begin[failed].max()) / THICK if failed.any() else float("nan")
    return {"table": table, "time": time, "surface": surface, "books": summary["ledger"], "peak": peak,
            "pull-back": (peak - least) / share - 1.0, "rise": surface[time > 2.3 + share].max() - least,
            "depth": depth / (0.5 * share) - 1.0, "broken": (table["failed"][-1] > 0.0).sum() / 4.0}


def contrast(options, ratio, cells=100, method="ddmp", words=""):
    """A wave propagates from one bar into another whose impedance is `ratio` times as large; the measured R."""
    length, speed = 1.0e-2, 5.0
    size = length / cells
    # the left bar moves into its own end at rest: half of the wave propagates into the other half
    matter = (plate("push", 0.0, 0.5 * length, 2.0 * speed) + plate("first", 0.5 * length, length)
              + plate("second", length, 2.0 * length, density=DENSITY * ratio))
    end = 0.5 * length / SOUND * 1.8      # the reflected wave has covered 0.8 of its path back
    table, summary = launch(options, f"contrast_{ratio:g}_{cells}_{method}", matter, 2.0 * length + 8.0 * size, size,
                            end, 9, method, words)
    wave = DENSITY * SOUND * speed
    at = np.argmin(abs(table["time"] - 0.5 * length / SOUND * 0.8))
    here = slice(int(4 * 0.70 * cells), int(4 * 0.95 * cells))
    incoming = -table["stress"][at, int(4 * 0.60 * cells):int(4 * 0.80 * cells)].mean() / wave - 1.0
    total = -table["stress"][-1, here].mean() / wave
    velocity = table["velocity"][-1, here].mean() / speed
    exact = (ratio - 1.0) / (ratio + 1.0)
    beyond = slice(4 * cells + 4 * 5, 4 * cells + 4 * int(0.25 * cells))
    through = -table["stress"][-1, beyond].mean() / wave
    return {"incoming": incoming, "R": total - 1.0 - exact, "R by velocity": 1.0 - velocity - exact,
            "T": through / (2.0 * ratio / (1.0 + ratio)) - 1.0, "books": summary["ledger"]}


def test_flyer(options, sheet):
    result = flyer(options, 40)
    show("flyer", result, ("stress", "plateau", "arrival", "pulse", "tension", "after"))
    for key, limit in (("stress", 0.01), ("plateau", 0.01), ("after", 0.01), ("arrival", 3.0 / 80),
                       ("pulse", 3.0 / 80)):
        sheet.below(f"flyer: {key}", result[key], limit)
    sheet.above("flyer: greatest tension", result["tension"], 0.99)
    sheet.below("flyer: momentum", result["books"]["momentum_error"], 1.0e-13)


def test_spall(options, sheet):
    result = spall(options, 80, 0.6)
    show("spall", result, ("peak", "pull-back", "rise", "depth", "broken"))
    sheet.below("spall: pull-back", result["pull-back"], 2.0 * 2.0 / 80 / 0.6)
    sheet.below("spall: depth of the first break", result["depth"], 2.0 / 80 / (0.5 * 0.6))
    sheet.above("spall: rise when the break is seen", result["rise"], 0.5 * 0.6)
    sheet.below("spall: momentum", result["books"]["momentum_error"], 1.0e-13)


@pytest.mark.tiers("long")
def test_spall_cells(options, sheet):
    """The pull-back approaches the closed value as the cells resolve the pulse."""
    errors, grids = [], (40, 60, 88, 132)
    for cells in grids:
        result = spall(options, cells, 0.6)
        show(f"spall {cells}", result, ("pull-back", "depth"))
        errors.append(abs(result["pull-back"]))
    sheet.above("spall: order of the pull-back", convergence.order(grids, errors), 0.8)


@pytest.mark.parametrize("ratio", [1.0e6, 1.0e-6, 10.0])
def test_contrast(options, sheet, ratio):
    result = contrast(options, ratio)
    show(f"contrast {ratio:g}", result, ("incoming", "R", "R by velocity", "T"))
    for key, limit in (("incoming", 0.01), ("R", 0.01), ("R by velocity", 0.01), ("T", 0.01)):
        sheet.below(f"contrast {ratio:g}: {key}", result[key], limit)
    sheet.below(f"contrast {ratio:g}: momentum", result["books"]["momentum_error"], 1.0e-12)
