# SPDX-License-Identifier: BSD-3-Clause
"""Gravity from a table of time: impulse and work are those of the piecewise linear function of the table.

Would catch gravity that is evaluated at the start of a step or at one of its ends, a table in wrong units, impulse or
work that the balance does not record, a restart that continues with another gravity, and bits that depend on ranks.
"""

import numpy as np

import case

# times, gx and gz; no step ends at one of these times
TABLE = np.array([[0.0, 0.0, 0.0], [0.1, 30.0, 4.0], [0.17, -20.0, 4.0], [0.31, 5.0, -8.0]])
DECK = """&run dimension = 'plane_strain'  {method} /
&units system = '{units}' /
&grid lo = 0 0 0  hi = 4 m, 1 m, 4 m  dx = 0.25 m /
&time t_end = 0.4 s  {more} /
&effects gravity = .true.  gravity_vector = 1 m/s2, 0, -2 m/s2  gravity_table = '{file}' /
&material name = 'al'  density = 2700 kg/m3  young = 1e7 Pa  poisson = 0.3 /
&region name = 'a'  shape = 'box'  lo = 1 m, 0, 1.5 m  hi = 2 m, 1 m, 2.5 m /
&body name = 'a'  region = 'a'  material = 'al'  velocity = 0.5 m/s, 0, 0 /
&checkpoint at_end = .true. /
&output name = 'h'  kind = 'history'  every = 1 /
"""


def velocity(time):
    """Velocity of a free body: the integral of the piecewise linear function, which is constant beyond its ends. In the
    output velocities are half a step behind the time (leapfrog)."""
    knots = np.unique(np.concatenate([TABLE[:, 0], time]))
    found = []
    for column, steady, start in ((1, 1.0, 0.5), (2, -2.0, 0.0)):
        g = np.interp(knots, TABLE[:, 0], TABLE[:, column]) + steady
        way = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(knots) * (g[1:] + g[:-1]))])
        found.append(start + np.interp(time, knots, way))
    return np.array(found)


class TestGravity:
    """A free block in a box."""

    def run_of(self, options, name, *flags, ranks=1, expect=0, table=None, keep=False, **scene):
        """A run in the folder of its table."""
        scene = {"method": "", "units": "si", "more": "", "file": "g.csv", **scene}
        run = case.Case(options, name, DECK.format(**scene), ranks, keep=keep)
        # a second in ms, and a metre per second squared in mm/ms2
        second, unit = (1e3, 1e-3) if scene["units"] == "mm-ms-kg" else (1.0, 1.0)
        rows = [f"{second * t!r}, {unit * x!r}, {table or 0}, {unit * z!r}" for t, x, z in TABLE.tolist()]
        (run.folder / "g.csv").write_text("t, gx, gy, gz\n" + "\n".join(rows) + "\n", encoding="utf-8")
        return run.run("--quiet", *flags, expect=expect)

    def test_impulse_and_work(self, options, sheet):
        """Momentum is that of the integral to rounding, and the balances close."""
        for method in ("method = 'ddmp'", "/\n&method transfer = 'apic'"):
            with sheet.part(method):
                history = self.run_of(options, "free", method=method).history
                wanted = history["mass"][0] * velocity(history["time"] - 0.5 * history["dt"])
                assert np.ptp(wanted[0]) > 1000.0
                assert len(history["time"]) > 30
                for name, row in zip(("momentum_x", "momentum_z"), wanted):
                    assert np.abs(history[name] - row).max() < 1e-11 * np.abs(wanted).max()
                gain = history["kinetic"] - history["kinetic"][0]
                assert np.abs(gain).max() > 1000.0
                assert np.abs(gain - history["external_work"]).max() < 2e-3 * np.abs(gain).max()

    def test_units(self, options):
        """A table in mm and ms."""
        history = self.run_of(options, "units", units="mm-ms-kg").history
        wanted = history["mass"][0] * velocity(history["time"] - 0.5 * history["dt"])
        assert np.abs(history["momentum_x"] - wanted[0]).max() < 1e-11 * np.abs(wanted).max()

    def test_same_bits(self, options):
        """On two ranks, and after a restart between the entries of the table."""
        whole = self.run_of(options, "whole")
        assert whole.summary["digest"] == self.run_of(options, "ranks", ranks=2).summary["digest"]
        self.run_of(options, "parts", "--set", "time.max_steps=20")
        parts = self.run_of(options, "parts", "--restart", keep=True)
        assert whole.summary["digest"] == parts.summary["digest"]

    def test_faults(self, options):
        """A table that does not exist, or that acts along a direction that the scene lacks."""
        assert "cannot " in self.run_of(options, "none", file="h.csv", expect=2).output
        told = self.run_of(options, "across", table=1.0, expect=2).output
        assert "the table must be 0 in y, as the scene does not have this direction" in told
