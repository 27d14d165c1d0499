# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Results of a run are replaced on request only.

Would catch: a repeated command that empties the history or replaces snapshots or checkpoints; a request that leaves
snapshots of later times, or removes files of the user or of another case; a checkpoint of another run that is replaced
or removed because a restart reads a file in another folder; a check that does not report existing results.
"""

import shutil

import case

DECK = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps=20  dt_fixed=1e-5 /
&material  name='metal'  density=2700  young=70e9  poisson=0.3 /
&region  name='bar'   shape='box'  lo=0.1,0,0  hi=0.5,1,1 /
&body  name='one'   region='bar'   material='metal'  velocity=1,0,0 /
&output  name='one'  kind='history'  bodies='one'  every=10 /
&output  name='h'  kind='history'    every=10 /
&output  name='p'  kind='particles'  every=10 /
&output  name='further'  kind='particles'  every=5 /
&checkpoint  keep=0 /
"""
# Files of the user, of a case whose name begins in the same way, and names similar to those of the run.
OTHERS = ("bär notes.txt", "bär_p_000001.hdf.png", "bär_mine.csv", "bär_chk_x.h5", "bär_b_history.csv",
          "bär_b_p_000001.hdf", "bär_b.summary.json", "bär_p_1.hdf", "bär2.log")
WAYS = ("--restart", "--overwrite", "--outdir")


def contents(folder):
    """Files of a folder with their contents."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}


class TestFormerResults:
    """Two runs into one folder."""

    def run_of(self, options, folder="a folder", **how):
        """A finished run, in a folder with a blank and with an umlaut in its name."""
        run = case.Case(options, folder, DECK, **how)
        run.name, run.guarded = "bär", True
        return run.run("--quiet")

    def test_nothing_is_lost(self, options):
        """The same command again, with one rank and two: exit code 3, the options of the user, and no file has
        changed."""
        run = self.run_of(options)
        before = contents(run.folder)
        assert "bär_further_p_000004.hdf" in before
        for run.ranks in (1, 2):
            run.run("--quiet", expect=3)
            for word in WAYS:
                assert word in run.output
            assert f"'{run.folder}'" in run.output
            assert contents(run.folder) == before
        run.ranks = 1
        run.run("--check", "--no-estimate")
        assert "warning: results of case 'bär' are in" in run.output
        assert contents(run.folder) == before
        run.run("--check", "--no-estimate", "--overwrite")
        assert "are in" not in run.output
        run.run("--quiet", "--restart")
        run.run("--quiet", "--restart", "--overwrite", expect=2)

    def test_each_file_counts(self, options, sheet):
        """A single table, snapshot or checkpoint counts as a result; a log and an echo do not, because a failed start
        leaves them."""
        run = self.run_of(options, "one left")
        kept = contents(run.folder)
        for names, code in ((["bär_history.csv"], 3), (["bär_p_000000.hdf"], 3), (["bär_chk_0001.h5"], 3),
                            (["bär.summary.json"], 3), (["bär_further_p_000004.hdf"], 3),
                            (["bär.log", "bär.echo.nml"], 0)):
            with sheet.part(names):
                for name in contents(run.folder):
                    if not name.endswith("left.nml"):
                        (run.folder / name).unlink()
                for name in names:
                    (run.folder / name).write_bytes(kept[name])
                run.run("--quiet", expect=code)
                assert ("--restart" in run.output) == ("bär_chk_0001.h5" in names), run.output

    def test_overwrite(self, options):
        """All files of the previous run are removed, also those of streams that this run lacks, and no other files."""
        run = self.run_of(options, "replaced")
        former = set(contents(run.folder))
        for name in OTHERS:
            (run.folder / name).write_text("mine", encoding="utf-8")
        (run.folder / "bär_chk_0007.h5.part").write_text("half a file", encoding="utf-8")
        text = DECK.replace("&output  name='further'  kind='particles'  every=5 /", "")
        run.deck.write_text(text.replace("max_steps=20", "max_steps=5"), encoding="utf-8")
        run.run("--quiet", "--overwrite")
        after = contents(run.folder)
        for name in OTHERS:
            assert after.get(name) == b"mine", name
        assert "bär_chk_0007.h5.part" not in after
        left = {name for name in after if name not in OTHERS}
        fresh = case.Case(options, "fresh", run.deck.read_text(encoding="utf-8"))
        fresh.name, fresh.deck = "bär", fresh.deck.rename(fresh.folder / run.deck.name)
        fresh.run("--quiet")
        assert left == set(contents(fresh.folder))
        assert left < former
        assert run.summary["steps"] == 5

    def test_checkpoint_of_another_run(self, options):
        """A restart from a file in another folder keeps the existing results and their checkpoints."""
        first, second = self.run_of(options, "first"), self.run_of(options, "second")
        file = options.work / "elsewhere.h5"
        shutil.copyfile(first.path("_chk_0001.h5"), file)
        before = contents(second.folder)
        second.run("--quiet", "--restart", file, "--set", "time.max_steps=30", expect=3)
        assert "is not of that run" in second.output
        assert contents(second.folder) == before
        branch = case.Case(options, "branch", DECK)
        branch.guarded = True
        branch.run("--quiet", "--restart", file, "--set", "time.max_steps=30")
        assert branch.summary["steps"] == 30

    def test_older_checkpoint(self, options):
        """A restart from an older checkpoint of the same run keeps the later ones, and its own checkpoint becomes the
        newest."""
        run = self.run_of(options, "older")
        run.run("--quiet", "--restart", "--set", "time.max_steps=30")
        before = {path.name: path.read_bytes() for path in run.folder.glob("*.h5")}
        assert sorted(before) == ["bär_chk_0001.h5", "bär_chk_0002.h5"]
        older = run.folder.parent / "older" / "." / ".." / "older" / "bär_chk_0001.h5"
        run.run("--quiet", "--restart", older, "--set", "time.max_steps=25")
        assert run.summary["steps"] == 25
        for name, content in before.items():
            assert (run.folder / name).read_bytes() == content, name
        run.run("--restart", "--set", "time.max_steps=25")
        assert "bär_chk_0003.h5" in run.output
