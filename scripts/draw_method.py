# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/learn/what.md: the four parts of a step, and the gradients of MPM and DDMP.

    build/venv/bin/python scripts/draw_method.py [--out FOLDER]
"""
import argparse
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402

ROOT = Path(__file__).resolve().parents[1]
BODY, NODE, MPM, DDMP = "#d55e00", "#0072b2", "#888888", "#0072b2"


def shape(x):
    """Linear shape function of the node 0 on a grid of spacing 1."""
    return np.maximum(0.0, 1.0 - np.abs(x))


def slope(x):
    """Gradient of the linear shape function."""
    return np.where((x >= -1.0) & (x < 0.0), 1.0, 0.0) - np.where((x >= 0.0) & (x < 1.0), 1.0, 0.0)


def alpha(x):
    """Weight of the gradient at the particle, equation (M.8) with alpha_0 = 1."""
    place = x - np.floor(x)
    return 4.0 * place * (1.0 - place)


def dual_gradient(x):
    """Modified gradient, equation (M.2), on a line of full cells, where the node gradients are central differences."""
    place = x - np.floor(x)
    smooth = np.floor(x) + 3.0 * place**2 - 2.0 * place**3          # equation (M.11)
    nodes = 0.5 * (shape(smooth + 1.0) - shape(smooth - 1.0))
    return alpha(x) * slope(x) + (1.0 - alpha(x)) * nodes


def particles():
    """Particles of a disc, two in each direction of a cell."""
    line = np.arange(0.25, 4.0, 0.5)
    x, y = (part.ravel() for part in np.meshgrid(line, line))
    inside = (x - 2.0)**2 + (y - 2.0)**2 < 1.3**2
    return x[inside], y[inside]


def grid(panel, moved):
    """Lines and nodes of a grid of four cells, undeformed or moved."""
    line = np.linspace(0.0, 4.0, 5)
    fine = np.linspace(0.0, 4.0, 41)

    def place(x, y):
        near = moved * np.exp(-((x - 2.0)**2 + (y - 2.0)**2) / 2.0)
        return x + 0.35 * near, y + 0.20 * near * (x - 1.0)

    for at in line:
        panel.plot(*place(fine, np.full_like(fine, at)), color="0.75", lw=0.8, zorder=0)
        panel.plot(*place(np.full_like(fine, at), fine), color="0.75", lw=0.8, zorder=0)
    return place


def draw_step():
    """Draw the four parts of a step."""
    figure, panels = pyplot.subplots(1, 4, figsize=(11.0, 3.1), layout="constrained")
    x, y = particles()
    titles = ("1  particles carry the material", "2  mass, momentum, stress to nodes", "3  nodes move, strain follows",
              "4  particles move, the grid is reset")
    for number, (panel, title) in enumerate(zip(panels, titles)):
        place = grid(panel, 1.0 if number == 2 else 0.0)
        shown = (x, y) if number < 2 else place(x, y) if number == 2 else (x + 0.35 * np.exp(
            -((x - 2.0)**2 + (y - 2.0)**2) / 2.0), y + 0.2 * (x - 1.0) * np.exp(-((x - 2.0)**2 + (y - 2.0)**2) / 2.0))
        panel.scatter(*shown, s=22, color=BODY, lw=0, alpha=0.35 if number in (1, 2) else 1.0)
        if number in (1, 2):
            nodes = [(i, j) for i in range(1, 4) for j in range(1, 4)]
            panel.scatter(*zip(*(place(*map(float, node)) for node in nodes)), s=55, marker="s", color=NODE, zorder=3)
        if number == 1:
            for px, py in zip(x, y):
                for i in (np.floor(px), np.floor(px) + 1):
                    for j in (np.floor(py), np.floor(py) + 1):
                        if 1 <= i <= 3 and 1 <= j <= 3:
                            panel.plot((px, i), (py, j), color=NODE, lw=0.3, alpha=0.5)
        panel.set(title=title, aspect="equal", xticks=[], yticks=[], xlim=(-0.2, 4.4), ylim=(-0.2, 4.4))
        panel.title.set_fontsize(9)
        panel.axis("off")
    return figure


def draw_gradient():
    """Draw the shape function, the gradients, and the sum of the nodal forces of a particle that moves."""
    figure, panels = pyplot.subplots(1, 3, figsize=(11.0, 3.0), layout="constrained")
    x = np.linspace(-2.4, 2.4, 4801)
    panels[0].plot(x, shape(x), color="k")
    panels[0].set_title("shape function of a node", fontsize=9)
    jumps = np.where(np.isclose(np.abs(np.diff(slope(x), append=0.0)), 0.0), slope(x), np.nan)
    panels[1].plot(x, jumps, color=MPM, lw=2.0, label="MPM: jumps at cell faces")
    panels[1].plot(x, dual_gradient(x), color=DDMP, lw=2.0, label="DDMP: continuous")
    panels[1].set_title("its gradient, by which stress acts on the node", fontsize=9)
    panels[1].set_ylim(-1.1, 1.6)
    panels[1].legend(fontsize=8, loc="upper right", frameon=False)
    panels[2].plot(x, alpha(x), color=DDMP)
    panels[2].set_title("weight alpha of the gradient at the particle", fontsize=9)
    for panel in panels:
        for node in range(-2, 3):
            panel.axvline(node, color="0.85", lw=0.8, zorder=0)
        panel.set(xlabel="distance from the node [cells]", xlim=(-2.4, 2.4))
    return figure


def main():
    """Write the pictures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "doc/learn/figures", help="folder for the pictures")
    folder = parser.parse_args().out
    folder.mkdir(parents=True, exist_ok=True)
    for name, draw in (("step", draw_step), ("gradient", draw_gradient)):
        draw().savefig(folder / f"{name}.png", dpi=1800.0 / 11.0, metadata={"Software": None})


if __name__ == "__main__":
    main()
