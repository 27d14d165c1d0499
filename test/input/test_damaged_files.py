# SPDX-License-Identifier: BSD-3-Clause
"""Damaged checkpoints: a restart continues from an older one or refuses to start, and never uses a damaged one.

Would catch a damaged file that is used, that crashes the program or the HDF5 library, or whose digest is that of
another state; and a restart that fails after it has changed earlier results.
"""

import random
import shutil
import subprocess

import pytest

import case
import confine

SEED = 5
FLIPS, CUTS = 150, 40           # runs of --digest
RESTARTS = 12                   # runs of --restart, which start MPI
DECK = """
&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1  max_steps = 20 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&material name = 'soft'  density = 1000  young = 1e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.3  radius = 0.2 /
&region name = 'cube'  shape = 'box'  lo = 0.3 0 0.6  hi = 0.7 1 0.9 /
&body name = 'one'  region = 'ball'  material = 'metal'  velocity = 0 0 10 /
&body name = 'two'  region = 'cube'  material = 'soft' /
&checkpoint dt = 5e-5  keep = 0 /
"""
TITLE = b"scree-checkpoint-4"


def digest(options, path):
    """Exit code and output of --digest for a file."""
    answer = subprocess.run([options.scree, "--digest", path], stdout=subprocess.PIPE, timeout=60,
                            stderr=subprocess.STDOUT, check=False)
    return answer.returncode, answer.stdout.decode(errors="replace").strip()


def contents(folder):
    """All files of a folder with their contents."""
    return {path.name: path.read_bytes() for path in folder.iterdir()}


class TestDamage:
    """One run with several checkpoints, which are then damaged."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.run_ = case.Case(file_options, "whole", DECK).run("-q")
        cls.paths = sorted(cls.run_.folder.glob("whole_chk_*.h5"))
        assert len(cls.paths) > 1, "there are checkpoints to fall back to"
        cls.bytes_ = cls.paths[-1].read_bytes()
        cls.chance = random.Random(SEED)

    def flipped(self):
        """The newest checkpoint with one to five flipped bits at random positions."""
        data = bytearray(self.bytes_)
        for place in self.chance.sample(range(len(data)), self.chance.choice([1, 1, 1, 2, 5])):
            data[place] ^= 1 << self.chance.randrange(8)
        return bytes(data)

    def cut(self):
        """The newest checkpoint without its end, or with bytes appended."""
        if self.chance.random() < 0.1:
            return self.bytes_ + b"\n"
        return self.bytes_[:self.chance.randrange(len(self.bytes_))]

    def test_whole_file(self, options):
        """Would catch a digest that is not that of the state, or damage reported for undamaged files."""
        assert digest(options, self.paths[-1]) == (0, self.run_.summary["digest"])
        assert digest(options, self.paths[0])[0] == 0

    def test_digest(self, options):
        """Would catch damage that is not found: each file must lead to exit code 3 and a message."""
        path = options.work / "damaged.h5"
        for data in [self.flipped() for _ in range(FLIPS)] + [self.cut() for _ in range(CUTS)]:
            path.write_bytes(data)
            code, said = digest(options, path)
            assert code == 3, said
            assert "'" + str(path) + "' is " in said

    def test_what_is_no_checkpoint(self, options):
        """Would catch other files and other versions that are read as checkpoints."""
        path = options.work / "other.h5"
        old = self.bytes_.replace(TITLE, b"scree-checkpoint-7")
        for data, said in ((b"", "truncated"), (b"x" * 4096, "not a checkpoint of this program"),
                           (self.run_.path("_p_000000.hdf").read_bytes(), "not a checkpoint of this"),
                           (old, "of another version: it is 'scree-checkpoint-7'")):
            path.write_bytes(data)
            code, text = digest(options, path)
            assert code == 3, text
            assert said in text
        assert digest(options, options.work / "nobody.h5")[0] == 3
        assert digest(options, options.work)[0] == 3

    def again(self, options, name, deck=DECK, keep=None):
        """A copy of the run, optionally with the newest checkpoints only."""
        copy = case.Case(options, name, deck)
        for number, path in enumerate(self.paths[-(keep or 0):], start=1):
            shutil.copyfile(path, copy.folder / f"{name}_chk_{number:04d}.h5")
        for ending in ("_history.csv", ".log", ".summary.json", ".echo.nml"):
            shutil.copyfile(self.run_.path(ending), copy.path(ending))
        return copy

    def test_older_one_is_used(self, options):
        """Would catch a restart from a damaged file, or one from an older file that is not reported."""
        copy = self.again(options, "older", keep=2)
        older, newest = sorted(copy.folder.glob("*.h5"))
        for number in range(RESTARTS):
            newest.write_bytes(self.flipped() if number % 2 else self.cut())
            copy.run("--restart")
            assert "restart from " + str(older) in copy.output
            assert f"'{newest}' is " in copy.output
            assert copy.summary["digest"] == self.run_.summary["digest"]
            for path in set(copy.folder.glob("*.h5")) - {older, newest}:
                path.unlink()

    def test_without_permission(self, options):
        """Would catch a checkpoint without read permission that stops a restart, or is skipped without a message or
        with a wrong reason; and a digest of it."""
        with confine.user(options) as somebody:
            if somebody.why:
                pytest.skip(somebody.why)
            copy = self.again(somebody.options, "older", keep=2)
            older, newest = sorted(copy.folder.glob("*.h5"))
            newest.chmod(0)
            somebody.give(copy.folder)
            said = f"cannot read '{newest}': Permission denied"
            copy.run("--restart", **somebody.identity)
            assert "restart from " + str(older) in copy.output
            assert said in copy.output
            assert copy.summary["digest"] == self.run_.summary["digest"]
            answer = subprocess.run([copy.scree, "--digest", newest], stdout=subprocess.PIPE, timeout=60,
                                    stderr=subprocess.STDOUT, text=True, check=False, **somebody.identity)
            assert (answer.returncode, answer.stdout.splitlines()[0]) == (3, f"{said} [F106]")

    def test_none_is_left(self, options):
        """Would catch a run that starts from the beginning, or changes files, when no checkpoint can be used."""
        copy = self.again(options, "none", keep=2)
        for path in copy.folder.glob("*.h5"):
            path.write_bytes(self.flipped())
        before = contents(copy.folder)
        for flags in (["--restart"], ["--restart", str(path)], ["--restart", "nobody.h5"]):
            copy.run(*flags, expect=3)
            assert before == contents(copy.folder), "a file was changed"

    def test_other_decks(self, options, sheet):
        """Would catch a state that is read into a run with other materials or fields."""
        for name, old, new, said in (
                ("spatial", "plane_strain", "3d", "&run dimension = '3d', was 'plane_strain'"),
                ("renamed", "soft", "gel", "&material 'soft' is gone"),
                ("heated", "poisson = 0.3 /", "poisson = 0.3  specific_heat = 900 /",
                 "&effects thermal = .true., was .false.")):
            deck = DECK.replace(old, new)
            if name == "heated":
                deck += "&effects thermal = .true. /\n"
            with sheet.part(name):
                copy = self.again(options, name, deck, keep=1)
                before = contents(copy.folder)
                copy.run("--restart", expect=3)
                assert said in copy.output
                assert before == contents(copy.folder), "a file was changed"
