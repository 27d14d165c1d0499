# SPDX-License-Identifier: BSD-3-Clause
"""Progress of long work with the time left, on a terminal only."""
import sys
import time

EVERY = 0.2              # between two writings [s]
WIDTH = 30               # of the bar [letters]


def clock(seconds):
    """Hours, minutes and seconds."""
    whole = int(round(seconds))
    return f"{whole // 3600}:{whole // 60 % 60:02d}:{whole % 60:02d}"


class Progress:
    """A bar that is drawn over itself; silent where standard error is no terminal."""

    def __init__(self, total, what, stream=None):
        self.total, self.what, self.done = total, what, 0
        self.stream = stream or sys.stderr
        self.loud = self.stream.isatty()
        self.begin, self.last = time.monotonic(), None

    def __enter__(self):
        self.show()
        return self

    def __exit__(self, *_):
        self.clear()

    def step(self, count=1):
        """Some more of the work is done."""
        self.done += count
        self.show()

    def text(self):
        """The line: bar, share, and the time left from the pace so far."""
        share = self.done / self.total if self.total else 1.0
        bar = "#" * int(WIDTH * share)
        left = ""
        if self.done:
            left = f"  {clock((time.monotonic() - self.begin) * (1.0 / share - 1.0))} left"
        return f"{self.what} [{bar:<{WIDTH}}] {self.done}/{self.total}{left}"

    def show(self):
        """Draw the line, not too often."""
        now = time.monotonic()
        if not self.loud or self.last and now - self.last < EVERY and self.done < self.total:
            return
        self.last = now
        self.stream.write("\r\033[K" + self.text())
        self.stream.flush()

    def clear(self):
        """Remove the line, so that what is printed next stands alone."""
        if self.loud:
            self.stream.write("\r\033[K")
            self.stream.flush()
