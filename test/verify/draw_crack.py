# SPDX-License-Identifier: BSD-3-Clause
"""Draw doc/theory/figures/crack_load.png: load of a bar against its displacement for four sizes of cells.

    python test/verify/draw_crack.py --scree build/bin/scree --work FOLDER
"""


import matplotlib
import numpy as np
from matplotlib import pyplot

import _support
import bars
import case

matplotlib.use("Agg")


def main():
    """Two pictures side by side."""
    options = case.arguments()
    pyplot.rcParams.update({"font.size": 8, "axes.grid": True, "grid.alpha": 0.3, "legend.fontsize": 7,
                            "lines.linewidth": 1.1})
    figure, both = pyplot.subplots(1, 2, figsize=(7.0, 2.7), sharey=True)
    way = np.linspace(0.0, 1.4e-4, 400)
    for axes, method in zip(both, ("mpm", "ddmp")):
        for cells in (8, 16, 32, 64):
            result = bars.pull(options, f"draw_{method}_{cells}", cells=cells, method=method)
            place, load = bars.load(result)
            axes.plot(place * 1e6, load / 1e6, label=f"{cells} cells: {result['energy']:.0f} J/m$^2$")
        axes.plot(way * 1e6, np.array(bars.exact(way)) / 1e6, "k--", linewidth=0.8, label="exact: 100 J/m$^2$")
        axes.set_xlabel("displacement of the end [um]")
        axes.set_title(method)
        axes.legend()
    both[0].set_ylabel("load per area [MPa]")
    _support.save(figure, "crack_load")


if __name__ == "__main__":
    main()
