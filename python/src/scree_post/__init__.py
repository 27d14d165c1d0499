# SPDX-License-Identifier: BSD-3-Clause
"""Readers of the files of Scree: snapshot series, snapshots and time histories.

    import scree_post
    for time, file in scree_post.series("out/case/case_p.hdf.series"):
        snap = scree_post.snapshot(file)
        print(time, snap.points.shape, snap.fields["mass"].sum(), snap.units["mass"])
    table = scree_post.history("out/case/case_history.csv")
    table["kinetic"], table.units["kinetic"]

All values are in SI, for files in any units. Reading needs h5py and numpy only; the command scree-post, which draws and
compares, is in scree_post.commands.
"""
from scree import __version__
from scree.drawing.look import make_small, pyplot, save, scaled
from scree.errors import EXIT_FILE, EXIT_USAGE, ScreeError, modules, readable
from scree.files import DIMENSIONS, History, Snapshot, history, series, series_file, snapshot, snapshot_time, text

from .errors import run

__all__ = ["DIMENSIONS", "EXIT_FILE", "EXIT_USAGE", "History", "ScreeError", "Snapshot", "__version__", "history",
           "make_small", "modules", "pyplot", "readable", "run", "save", "scaled", "series", "series_file", "snapshot",
           "snapshot_time", "text"]
