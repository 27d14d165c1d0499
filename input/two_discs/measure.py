# SPDX-License-Identifier: BSD-3-Clause
"""Rebound of two elastic discs: contact, energies and momentum by size of cells; energy by method and update.

    python input/two_discs/measure.py --scree build/bin/scree
"""
import math
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree.drawing import look   # noqa: E402
from scree_post import panel   # noqa: E402
from scree_scene import Study, Table  # noqa: E402

RADIUS, OFFSET, SPEED, DENSITY = 0.2, 0.3, 0.1, 1000.0         # of the deck: [m], [m], [m/s], [kg/m3]
TOUCH = (OFFSET - RADIUS / math.sqrt(2.0)) / SPEED             # of circles with these places and speeds [s]
KINETIC = 2.0 * math.pi * RADIUS ** 2 * DENSITY * SPEED ** 2   # of full discs [J]
CELLS = {"coarse": 0.025, "ddmp_usavg": 0.0125, "fine": 0.00625}
METHODS = {"ddmp": ("DDMP", {"run.method": "ddmp"}), "mpm": ("plain", {"run.method": "mpm"}),
           "gimp": ("GIMP", {"run.method": "mpm", "method.basis": "gimp"}),
           "quadratic": ("quadratic", {"run.method": "mpm", "method.basis": "quadratic"})}
UPDATES = ("usavg", "usl", "musl", "usf")
OFTEN = {"output[energy].every": 2}                            # so that the moment of contact can be told


def energies(run):
    """Times [s], kinetic and total energy over the kinetic energy at the start."""
    table = run.history
    return table["time"], table["kinetic"] / table["kinetic"][0], table["total"] / table["kinetic"][0]


def felt(run):
    """When a thousandth of the kinetic energy has gone [s]."""
    time, kinetic, _ = energies(run)
    after = np.flatnonzero(kinetic < 0.999)[0]
    return np.interp(-0.999, -kinetic[after - 1:after + 1], time[after - 1:after + 1])


def rebound(run):
    """Least kinetic energy, when that is [s], the greatest after it, and that at the end."""
    time, kinetic, _ = energies(run)
    least = kinetic.argmin()
    return kinetic[least], time[least], kinetic[least:].max(), kinetic[-1]


def by_cells(runs):
    """What the default finds, by the size of cells."""
    chosen = [runs[name] for name in CELLS if name in runs]
    table = Table(["DDMP, cells across a disc", "exact",
                   *(f"{2.0 * RADIUS / size:.0f}" for name, size in CELLS.items() if name in runs)])
    back = [rebound(run) for run in chosen]
    off = [100.0 * energies(run)[2] - 100.0 for run in chosen]
    for title, exact, values, form in (
            ("kinetic energy at the start [J]", f"{KINETIC:.4f}", [run.history["kinetic"][0] for run in chosen], ".4f"),
            ("first contact [s]", f"{TOUCH:.3f}", [felt(run) for run in chosen], ".3f"),
            ("greatest compression at [s]", "", [one[1] for one in back], ".2f"),
            ("kinetic energy at that time, over the initial one", "", [one[0] for one in back], ".3f"),
            ("greatest kinetic energy afterwards, over the initial one", "", [one[2] for one in back], ".3f"),
            ("kinetic energy at the end, over the initial one", "", [one[3] for one in back], ".3f"),
            ("least total energy, change from the start [%]", "0", [one.min() for one in off], ".2f"),
            ("total energy at the end, change from the start [%]", "0", [one[-1] for one in off], ".2f"),
            ("momentum", "0", [run.error("momentum_error") for run in chosen], ".0e")):
        table.rows.append([title, exact, *(f"{value:{form}}" for value in values)])
    return table


def ending(run):
    """Error of the energy at the end, or how the run failed."""
    if run.code:
        return f"fails at {run.summary['time']:.2f} s, exit code {run.code}"
    return f"{100.0 * run.error('energy_error'):.2f} %"


def tables(runs):
    """By cells, and by method and update."""
    table = Table(["method", *(f"`{update}`" for update in UPDATES)])
    for name, (title, _) in METHODS.items():
        table.rows.append([title, *(ending(runs[f"{name}_{update}"]) if f"{name}_{update}" in runs else ""
                                    for update in UPDATES)])
    return [by_cells(runs), table]


def first_steps(runs):
    """What the page for beginners says of the deck, and of its coarse run."""
    usual, coarse = runs["ddmp_usavg"], runs["coarse"]
    _, moment, greatest, _ = rebound(usual)
    lost, lost_coarse = (-100.0 * run.error("energy_error") for run in (usual, coarse))
    pressed = 100.0 - 100.0 * energies(usual)[2].min()
    return {"felt": f"{felt(usual):.1f}", "rest": f"{moment:.2f}", "rebound": f"{100.0 * greatest:.0f}",
            "lost": f"{lost:.2f}", "pressed": f"{pressed:.1f}", "lost_coarse": f"{lost_coarse:.2f}"}


def draw(runs, plot):
    """The discs at four times by pressure, and the energies over time."""
    if not {"ddmp_usavg", "mpm_musl", "mpm_usl"} <= set(runs):
        return None
    figure, panels = plot.subplot_mosaic("abe;cde", figsize=(10.0, 5.0), width_ratios=(1, 1, 2.0),
                                         layout="constrained")
    panels = [panels[name] for name in "abcde"]
    for axes, moment in zip(panels, (1.5, 1.75, 2.0, 2.5)):
        snap = runs["ddmp_usavg"].near(moment)
        shown = panel.particles(axes, snap, snap.fields["pressure"], low=-100.0, high=100.0, colours=look.SIGNED,
                                factor=1.0)
        panel.window(axes, (-0.48, 0.48, -0.48, 0.48), title=f"{snap.time:.2f} s")
        axes.set(xticks=[], yticks=[])
    figure.colorbar(shown, ax=panels[:4], label="pressure [Pa]", shrink=0.7, extend="both")
    last = panels[-1]
    for name, label, colour in (("ddmp_usavg", "DDMP", "#0072b2"), ("mpm_musl", "plain, musl", "#e69f00"),
                                ("mpm_usl", "plain, usl", "#d55e00")):
        time, kinetic, total = energies(runs[name])
        last.plot(time, total, color=colour, label=f"total, {label}")
        if name != "mpm_usl":
            last.plot(time, kinetic, "--", color=colour, label=f"kinetic, {label}")
    last.axvline(TOUCH, color="k", lw=0.8, ls=":")
    last.set(xlabel="time [s]", ylabel="energy over the first", xlim=(1.2, 3.5), ylim=(0.0, 1.25))
    last.legend(fontsize=9, loc="lower right")
    return figure


CASES = {f"{name}_{update}": ("scene.nml", {**method, "method.stress_update": update})
         for name, (_, method) in METHODS.items() for update in UPDATES}
CASES.update({name: ("scene.nml", {"grid.dx": size, **OFTEN}) for name, size in CELLS.items()})

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw},
          numbers={"../../doc/learn/first_deck.md": first_steps},
          may_fail={"mpm_usl": 4}, as_it_stands="ddmp_usavg").main()
