# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/verification_metals.md.

    python test/verify/draw_metals.py --scree build/bin/scree --work FOLDER [--only WORD]

runs the problems of test/support/taylor.py and of the tests of shocks, and writes doc/theory/figures/metals_*.png.
"""

import argparse
import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot      # noqa: E402

HERE = Path(__file__).resolve().parent
for place in (HERE.parent / "support", HERE / "taylor", HERE / "shocks"):
    sys.path.insert(0, str(place))
import case               # noqa: E402
import taylor             # noqa: E402
import test_taylor_fine   # noqa: E402

FOLDER = HERE.parents[1] / "doc" / "theory" / "figures"
STYLE = {"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "lines.linewidth": 1.2, "figure.dpi": 100,
         "legend.fontsize": 7, "axes.axisbelow": True}


def save(figure, name):
    """Write one figure."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    figure.tight_layout()
    path = FOLDER / f"metals_{name}.png"
    figure.savefig(path)
    pyplot.close(figure)
    print(f"{path.name} {path.stat().st_size // 1000} kB", flush=True)


def bars(options):
    """The measured bar at five times with its plastic strain; sizes of the classic bar by cells."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.5, 2.9), width_ratios=(2.2, 1.0))
    result = taylor.strike(options, "picture", taylor.MEASURED)
    for number, snap in enumerate(result["snapshots"]):
        r, z = 1e3 * snap.points[:, 0], 1e3 * snap.points[:, 2]
        for sign in (-1.0, 1.0):
            shown = left.scatter(17.0 * number + sign * r, z, c=snap.fields["plastic_strain"], s=1.2, vmin=0.0,
                                 vmax=1.2, cmap="viridis", linewidths=0)
        left.text(17.0 * number, z.max() + 0.7, f"{20 * number} us", ha="center")
    edge = 17.0 * 4
    left.plot([edge - 6.75, edge - 6.75, edge + 6.75, edge + 6.75], [0.6, 0.0, 0.0, 0.6], "r-", lw=1.5)
    left.plot([edge - 5.05, edge + 5.05], [5.08, 5.08], "r|", ms=8, mew=1.5)
    left.plot([edge - 4.0, edge + 4.0], [16.2, 16.2], "r-", lw=1.5, label="measured length, foot and waist")
    left.set_aspect("equal")
    left.set(ylim=(-0.5, 28.5), ylabel="z [mm]", xticks=[])
    left.legend(loc="upper right", fontsize=6)
    figure.colorbar(shown, ax=left, label="plastic strain", shrink=0.55)
    for name in test_taylor_fine.METHODS:
        method, words = test_taylor_fine.METHODS[name]
        cells = (0.8, 0.4, 0.2)
        found = [taylor.strike(options, "curve", taylor.CLASSIC, h, words, method, timeout=600) for h in cells]
        right.plot(cells, [1e3 * run["foot"] for run in found], "o-", ms=3, label=name)
    right.axhspan(7.167, 7.200, color="k", alpha=0.2, label="finite elements")
    right.set(xlabel="cells [mm]", ylabel="radius of the foot, classic bar [mm]", xscale="log",
              xticks=(0.2, 0.4, 0.8), xticklabels=("0.2", "0.4", "0.8"))
    right.minorticks_off()
    right.legend()
    save(figure, "bars")


def main():
    """All figures, or those with a word in their names."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", default="")
    only, rest = parser.parse_known_args()
    sys.argv[1:] = rest
    options = case.arguments()
    np.seterr(all="ignore")
    pyplot.rcParams.update(STYLE)
    for name, draw in (("bars", bars),):
        if only.only in name:
            draw(options)


if __name__ == "__main__":
    main()
