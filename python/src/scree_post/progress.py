# SPDX-License-Identifier: BSD-3-Clause
"""Progress of long operations with the remaining time, on a terminal only."""
from __future__ import annotations

import sys


class Progress:
    """A bar of tqdm that disappears at the end; nothing without a terminal or without tqdm."""

    def __init__(self, total: int, what: str) -> None:
        self.bar = None
        if sys.stderr.isatty():
            try:                                         # scree-bench needs the standard library only
                from tqdm import tqdm
                self.bar = tqdm(total=total, desc=what, leave=False)
            except ImportError:
                pass

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()

    def step(self, count: int = 1) -> None:
        """A further part of the work is done."""
        if self.bar is not None:
            self.bar.update(count)

    def clear(self) -> None:
        """Remove the line, so that following output is not mixed with it."""
        if self.bar is not None:
            self.bar.clear()
