# SPDX-License-Identifier: BSD-3-Clause
"""Adds the folders of the test modules to the search path of scripts in this folder that are not tests; they import
this module first.

For tests test/pytest.ini does the same.
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TEST = HERE.parent

sys.path[:0] = [str(place) for place in (TEST / "support", HERE / "crack", HERE / "shocks", HERE / "taylor",
                                         TEST.parent / "scripts", TEST.parent / "python/src",
                                         TEST.parent / "input/debris_cloud")]

FIGURES = TEST.parent / "doc/theory/figures"
WIDTH = 1800.0                           # of a figure [pixels]


def save(figure, name):
    """Write a figure of the theory pages."""
    from matplotlib import pyplot
    FIGURES.mkdir(parents=True, exist_ok=True)
    path = FIGURES / f"{name}.png"
    figure.tight_layout()
    figure.savefig(path, dpi=WIDTH / figure.get_figwidth())
    pyplot.close(figure)
    print(f"{path.name} {path.stat().st_size // 1000} kB", flush=True)
