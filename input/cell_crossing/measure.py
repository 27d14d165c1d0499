# SPDX-License-Identifier: BSD-3-Clause
"""Stress behind a wave while particles cross cells: plain method, GIMP, B-splines and DDMP.

    python input/cell_crossing/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table  # noqa: E402

METHODS = {"mpm": ("plain", "mpm", "linear"), "gimp": ("GIMP", "mpm", "gimp"),
           "quadratic": ("quadratic", "mpm", "quadratic"), "ddmp": ("DDMP", "ddmp", "linear")}
CELLS = {"coarse": 0.025, "fine": 0.0125}
DENSITY, BULK, SHEAR, SPEED = 1000.0, 66666.667, 25000.0, 1.5      # of the deck


def cauchy(stretch):
    """Stress along the axis of compression of the Neo-Hookean law [Pa]."""
    lame = BULK - 2.0 * SHEAR / 3.0
    return (lame * np.log(stretch) + SHEAR * (stretch ** 2 - 1.0)) / stretch


def exact():
    """Stress and stretch behind the shock: rho v**2 = -stress (1 - stretch), by bisection [Pa, 1]."""
    low, high = 0.5, 1.0 - 1.0e-9
    for _ in range(100):
        middle = 0.5 * (low + high)
        if -cauchy(middle) * (1.0 - middle) > DENSITY * SPEED ** 2:
            low = middle
        else:
            high = middle
    return cauchy(low), low


def plateau(run):
    """Height [m] and stress [Pa] of the particles behind the wave at the end."""
    snap = run.last_snapshot()
    height, stress = snap.points[:, 2], snap.fields["stress"][:, 2]
    chosen = (height > 0.1) & (height < 0.5)
    return height[chosen], stress[chosen]


def tables(runs):
    """Mean and scatter of the stress behind the wave."""
    right = exact()[0]
    table = Table(["method", "cell [m]", "mean stress / exact", "scatter (rms) / exact",
                   "greatest error / exact"])
    for size, width in CELLS.items():
        for name, (title, _, _) in METHODS.items():
            stress = plateau(runs[f"{name}_{size}"])[1]
            table.rows.append([title, width, f"{stress.mean() / right:.3f}",
                               f"{stress.std() / abs(right):.3f}",
                               f"{np.abs(stress - right).max() / abs(right):.3f}"])
    return [table]


def numbers(_):
    """By how much matter is compressed behind the shock, which no run tells."""
    return {"compressed": f"{100.0 * (1.0 - exact()[1]):.0f}"}


def draw(runs, plot):
    """Blocks coloured by stress, and profiles."""
    right = exact()[0]
    figure, panels = plot.subplots(1, 5, figsize=(9.6, 4.4), width_ratios=(1, 1, 1, 1, 3.2),
                                   layout="constrained")
    colours = {"mpm": "#d55e00", "gimp": "#e69f00", "quadratic": "#009e73", "ddmp": "#0072b2"}
    for axes, (name, (title, _, _)) in zip(panels, METHODS.items()):
        snap = runs[f"{name}_coarse"].last_snapshot()
        shown = panel.particles(axes, snap, snap.fields["stress"][:, 2] / right, low=0.0, high=1.5, factor=1.0)
        panel.window(axes, (0, 0.4, 0, 1.0), title=title)
        axes.set_xticks([])
        if name == "mpm":
            axes.set_ylabel("height [m]")
        else:
            axes.set_yticks([])
        order = np.argsort(snap.points[:, 2], kind="stable")
        panels[-1].plot(snap.points[order, 2], snap.fields["stress"][order, 2] / right, ".", ms=2.5,
                        color=colours[name], label=title)
    figure.colorbar(shown, ax=panels[:4], label="stress / exact", location="bottom", shrink=0.6, pad=0.02)
    panels[-1].axhline(1.0, color="k", lw=0.8)
    panels[-1].set(xlabel="height [m]", ylabel="stress / exact", xlim=(0, 1), ylim=(-0.2, 1.6))
    panels[-1].legend(markerscale=4)
    return figure


CASES = {f"{name}_{size}": ("scene.nml", {"run.method": method, "method.basis": basis, "grid.dx": width})
         for size, width in CELLS.items() for name, (_, method, basis) in METHODS.items()}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw}, numbers={"README.md": numbers},
          as_it_stands="ddmp_coarse").main()
