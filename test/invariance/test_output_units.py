# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""`output_units`: the numbers of all files in the units of the deck, or of another system, and back to SI.

Would catch a field, a column or a time that keeps its old unit or gets a wrong label, a number that is converted
twice, and an echo with other output units than those of the deck.
"""

import csv
import re
import shutil

import h5py
import numpy as np
import pytest

import case

DECK = """&run dimension = 'plane_strain' /
&units system = 'mm-us-mg'  output_units = '{units}' /
&grid lo = 0 0 0  hi = 20 1 10  dx = 1 /
&time t_end = 1 /
&material name = 'metal'  density = 2.7  young = 70  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 5 0 5  radius = 3 /
&region name = 'wall'  shape = 'box'  lo = 8 0 0  hi = 12 1 10 /
&body name = 'one'  region = 'ball'  material = 'metal'  velocity = 1 0 0 /
&body name = 'two'  region = 'wall'  material = 'metal' /
&output name = 'h'  kind = 'history'  count = 2 /
&output name = 'p'  kind = 'particles'  count = 2  precision = 'double'  fields = 'default' 'stress' 'density' /
&output name = 'g'  kind = 'grid'  count = 2  precision = 'double' /
&output name = 'f'  kind = 'profile'  count = 2  bins = 10 /
&output name = 'b'  kind = 'fragments'  count = 2 /
"""
# Units of SI, their names in mm, us and mg, and the values of the latter in SI.
NAMES = {"m": ("mm", 1e-3), "s": ("us", 1e-6), "kg": ("mg", 1e-6), "m3": ("mm3", 1e-9), "m/s": ("mm/us", 1e3),
         "kg/m3": ("mg/mm3", 1e3), "Pa": ("mg/(mm us2)", 1e9), "J": ("mg mm2/us2", 1.0),
         "kg m/s": ("mg mm/us", 1e-3), "kg m2/s": ("mg mm2/us", 1e-6), "N s": ("mg mm/us", 1e-3),
         "N m s": ("mg mm2/us", 1e-6), "1": ("1", 1.0), "K": ("K", 1.0), "1/s": ("1/us", 1e6)}
CLOSE = 1e-15               # two roundings


def heading_and_rows(path):
    """Names, units and numbers of a table."""
    with open(path, newline="", encoding="utf-8") as lines:
        heading, *rows = csv.reader(lines)
    parts = [re.fullmatch(r"(\w+)(?: \[(.*)\])?", column).groups() for column in heading]
    return [name for name, _ in parts], [unit for _, unit in parts], np.array(rows, dtype=float)


class TestOutputUnits:
    """The same run twice."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.si, cls.deck = (case.Case(file_options, name, DECK.format(units=units)).run("--quiet")
                            for name, units in (("in_si", "si"), ("in_deck", "deck")))

    def close(self, found, wanted):
        assert np.all(np.abs(found - wanted) <= CLOSE * np.abs(wanted)), (found, wanted)

    def test_same_run(self):
        """Units of outputs change no bit of the run."""
        assert self.si.summary["digest"] == self.deck.summary["digest"]

    def test_tables(self, sheet):
        for ending in ("_history.csv", "_profile.csv", "_fragments.csv"):
            names, units, wanted = heading_and_rows(self.si.path(ending))
            same, other, found = heading_and_rows(self.deck.path(ending))
            assert names == same
            assert len(wanted) > 2
            for k, unit in enumerate(units):
                with sheet.part(ending, column=names[k]):
                    label, factor = NAMES[unit] if unit else (None, 1.0)
                    assert other[k] == label
                    self.close(found[:, k] * factor, wanted[:, k])

    def test_snapshots_and_grids(self, sheet):
        for stream, fields in (("p", 10), ("g", 4)):
            for number in range(3):
                ending = f"_{stream}_{number:06d}.hdf"
                with h5py.File(self.si.path(ending)) as one, h5py.File(self.deck.path(ending)) as two:
                    assert len(one["VTKHDF/PointData"]) >= fields
                    sets = [f"VTKHDF/PointData/{name}" for name in one["VTKHDF/PointData"]]
                    if stream == "p":
                        sets += ["VTKHDF/Points", "VTKHDF/FieldData/TimeValue"]
                    else:
                        self.close(two["VTKHDF"].attrs["Time"] * 1e-6, one["VTKHDF"].attrs["Time"])
                        self.close(two["VTKHDF"].attrs["Spacing"] * 1e-3, one["VTKHDF"].attrs["Spacing"])
                        self.close(two["VTKHDF"].attrs["Origin"] * 1e-3, one["VTKHDF"].attrs["Origin"])
                    for name in sets:
                        with sheet.part(name):
                            label, factor = NAMES[one[name].attrs["units"].decode()]
                            assert two[name].attrs["units"].decode() == label
                            assert abs(two[name].attrs["unitSI"] / factor - 1.0) <= 0.5e-14
                            assert one[name].attrs["unitSI"] == 1.0
                            self.close(two[name][...] * factor, one[name][...])

    def test_post_processing(self):
        """Readers of scripts/ return SI values for both."""
        for (time, one), (other, two) in zip(self.si.snapshots(), self.deck.snapshots()):
            self.close(np.array(other), np.array(time))
            self.close(two.points, one.points)
            assert one.units == two.units
            for name in one.fields:
                self.close(two.fields[name], one.fields[name])

    def test_echo(self, options):
        """The echo is in SI, and its outputs are the same bytes nevertheless."""
        echo = self.deck.path(".echo.nml").read_text(encoding="utf-8")
        assert "output_units = 'mm-us-mg'" in echo
        shutil.rmtree(options.work / "echo", ignore_errors=True)
        again = case.Case(options, "echo", echo)
        again.name = "in_deck"
        again.run("--quiet")
        for ending in ("_history.csv", "_profile.csv", "_fragments.csv", "_p.hdf.series", "_g.hdf.series"):
            assert again.path(ending).read_bytes() == self.deck.path(ending).read_bytes()
