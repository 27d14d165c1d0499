# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""A restart compares its deck with the one in the checkpoint.

Would catch: a state that is continued in a scene in which it has no meaning (another grid, density, body, law), a
change that is not reported, a finished case that is submitted again with another deck and reports success with its old
results, an older checkpoint that is used because it fits the deck, and outputs that are lost because the deck has other
streams or another end time.
"""

import json

import case

DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps={steps}  dt_fixed=1e-5 /
&effects  contact=.true. /
&material  name='metal'  density=2700  young=70e9  poisson=0.3  strength_model='von_mises'  yield=1e8 /
&region  name='low'   shape='box'  lo=0.1,0,0.1  hi=0.5,1,0.5 /
&region  name='high'  shape='box'  lo=0.1,0,0.5  hi=0.5,1,0.9 /
&body  name='one'   region='low'   material='metal'  velocity=1,0,0 /
&body  name='two'   region='high'  material='metal' /
&contact  bodies='one','two'  friction=0.2 /
&boundary  face='zlo'  type='friction'  friction=0.1 /
&output  name='h'  kind='history'    every=5 /
&output  name='p'  kind='particles'  every=5 /
&output  name='g'  kind='grid'  every=5 /
"""
# Key as in a message, and the change of the deck.
REFUSED = [
    ("&grid dx = 0.2, was 0.1", "dx=0.1", "dx=0.2"),
    ("&grid hi = 2.0, 1.0, 1.0, was 1.0, 1.0, 1.0", "hi=1,1,1", "hi=2,1,1"),
    ("&run method = 'mpm', was 'ddmp'", "&run ", "&run method='mpm' "),
    ("&run seed = 7, was 12345", "&run ", "&run seed=7 "),
    ("&material 'metal' density = 2000.0, was 2700.0", "density=2700", "density=2000"),
    ("&material 'metal' strength_model = 'elastic', was 'von_mises'", "strength_model='von_mises'  yield=1e8", ""),
    ("&body 'one' velocity = 2.0, 0.0, 0.0, was 1.0, 0.0, 0.0", "velocity=1,0,0", "velocity=2,0,0"),
    ("&region 'low' hi = 0.4, 1.0, 0.5, was 0.5, 1.0, 0.5", "hi=0.5,1,0.5", "hi=0.4,1,0.5"),
    ("&contact law = 'stick', was 'friction'", "'two'  friction=0.2", "'two'  law='stick'"),
    ("&effects damage = .true., was .false.: it decides which fields the particles of the checkpoint have",
     "contact=.true. /", "contact=.true.  damage=.true. /"),
    ("&body 'three' is new", "&contact", "&region name='far' shape='box' lo=0.7,0,0.7 hi=0.9,1,0.9 /\n"
     "&body name='three' region='far' material='metal' /\n&contact"),
]
TOLD = [
    ("&contact friction = 0.5, was 0.2", "friction=0.2", "friction=0.5"),
    ("&boundary[1] friction = 0.4, was 0.1", "friction=0.1", "friction=0.4"),
    ("&material 'metal' yield = 2.0e8, was 1.0e8", "yield=1e8", "yield=2e8"),
    ("&time dt_fixed = 2.0e-6, was 1.0e-5", "dt_fixed=1e-5", "dt_fixed=2e-6"),
]


def contents(folder):
    """Files of a folder with their contents, except the deck."""
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".nml"
            or ".echo." in path.name}


class TestChangedDecks:
    """A run of ten steps, and decks for its restart."""

    def run_of(self, options, name, deck=DECK, steps=10):
        """The first part of the run."""
        return case.Case(options, name, deck.format(steps=steps)).run("--quiet")

    def again(self, run, old, new, *flags, steps=20, deck=DECK, expect=0):
        """A restart with a changed deck."""
        assert deck.count(old) == 1, old
        run.deck.write_text(deck.replace(old, new).format(steps=steps), encoding="utf-8")
        return run.run("--restart", *flags, expect=expect)

    def test_refused(self, options, sheet):
        """Exit code 3, the key with both values, and no file has changed."""
        run = self.run_of(options, "refused")
        before = contents(run.folder)
        for said, old, new in REFUSED:
            with sheet.part(said):
                self.again(run, old, new, expect=3)
                assert said in run.output
                assert contents(run.folder) == before
        run.ranks = 2
        self.again(run, "dx=0.1", "dx=0.2", expect=3)
        assert run.output.count("&grid dx = 0.2, was 0.1") == 1, run.output

    def test_told(self, options, sheet):
        """A change of keys for the physics of the remaining run is a warning; a change of its end time or its files is
        not."""
        for number, (said, old, new) in enumerate(TOLD):
            with sheet.part(said):
                run = self.run_of(options, f"told_{number}")
                self.again(run, old, new)
                assert "warning: these changes affect the rest of the run" in run.output
                assert said in run.output
                assert "&time max_steps = 20, was 10" in run.output
                assert run.summary["steps"] == 20
        run = self.run_of(options, "quiet")
        self.again(run, "&run ", "&run title='another' ", "--quiet")
        assert run.output == ""
        assert "&run title = 'another', was" in run.path(".log").read_text(encoding="utf-8")

    def test_finished(self, options, sheet):
        """A finished case with a changed deck has no new results and must not end with exit code 0; with an unchanged
        deck it ends with 0."""
        run = self.run_of(options, "finished")
        before = contents(run.folder)
        for old, new in (("friction=0.2", "friction=0.5"),
                         ("every=5 /\n&output  name='p'", "every=2 /\n&output  name='p'"),
                         ("t_end=1", "t_end=5e-5")):
            with sheet.part(new):
                self.again(run, old, new, steps=10, expect=3)
                assert "the run is finished" in run.output
                assert contents(run.folder) == before
        self.again(run, "&run ", "&run ", "--set", "log.progress_seconds=5", steps=10)
        assert run.summary["steps"] == 10

    def test_at_rest(self, options):
        """The same if `stop_when` has ended the run."""
        deck = DECK.replace("t_end=1", "t_end=1  stop_when='kinetic_below'  stop_value=1e9")
        run = self.run_of(options, "rest", deck, steps=100)
        assert run.summary["steps"] == 0
        self.again(run, "friction=0.2", "friction=0.5", deck=deck, steps=100, expect=3)
        assert "the run is finished" in run.output

    def test_level(self, options):
        """A run ends with the first row of a table beyond a level, on any ranks and after a restart, and has then
        ended: would catch a level that is compared with the row before, in the units of the file, or not after a
        restart."""
        level = "t_end=1  stop_when='above'  stop_quantity='gauge.x'  stop_level=0.30042"
        deck = DECK.replace("t_end=1", level).replace(
            "&output  name='g'", "&units  output_units='mm-us-mg' /\n&output  name='m'  kind='gauge'  gauge='mean'  "
            "bodies='one'  every=5  fields='velocity' /\n&output  name='g'")
        run = self.run_of(options, "level", deck, steps=100)
        assert run.summary["reason"].endswith(" is above stop_level = 0.30042"), run.summary["reason"]
        table = run.path("_gauge.csv").read_text(encoding="ascii")
        place = table.split("\n", 1)[0].split(",").index("x [mm]")
        before, last = (float(line.split(",")[place]) for line in table.splitlines()[-2:])
        assert before <= 300.42 < last, (before, last)
        assert run.summary["steps"] % 5 == 0 and 30 < run.summary["steps"] < 100
        self.again(run, "friction=0.2", "friction=0.5", deck=deck, steps=100, expect=3)
        assert "the run is finished" in run.output
        part = self.run_of(options, "level_part", deck, steps=25)
        assert part.summary["steps"] == 25
        part.ranks = 2
        self.again(part, "&run ", "&run ", deck=deck, steps=100)
        assert part.path("_gauge.csv").read_text(encoding="ascii") == table
        assert part.summary["digest"] == run.summary["digest"]

    def test_no_older_one(self, options):
        """A newer checkpoint of another deck is not skipped in favour of an older one that fits."""
        run = self.run_of(options, "mixed")
        other = self.run_of(options, "other", DECK.replace("dx=0.1", "dx=0.2"))
        run.path("_chk_0002.h5").write_bytes(other.path("_chk_0001.h5").read_bytes())
        run.run("--quiet", "--restart", expect=3)
        assert "_chk_0002.h5' belongs to another deck" in run.output

    def test_streams(self, options):
        """A deck with more streams, fewer, or in another order keeps the existing snapshots and continues their
        numbers."""
        run = self.run_of(options, "streams")
        kept = {path.name: path.read_bytes() for path in run.folder.glob("*.hdf")}
        assert len(kept) == 6 + 1              # the last one has the walls
        self.again(run, "&output  name='h'  kind='history'    every=5 /",
                   "&output  name='g2'  kind='grid'  every=5 /\n&output  name='h'  kind='history'  every=5 /")
        for name, content in kept.items():
            if "_p_" in name:
                assert (run.folder / name).read_bytes() == content, name
        assert [round(snapshot.provenance["time"] / 1e-5) for _, snapshot in run.snapshots()] == [0, 5, 10, 15, 20]
        assert run.history["step"].tolist() == [0, 5, 10, 15, 20]

    def test_longer(self, options):
        """A restart with a later end time continues outputs that are given by `count`, with the interval that follows
        from the new end."""
        deck = DECK.replace("max_steps={steps}", "").replace("t_end=1", "t_end={steps}e-5").replace(
            "kind='history'    every=5", "kind='history'  count=10")
        run = self.run_of(options, "longer", deck)
        assert len(run.history["step"]) == 11
        self.again(run, "&run ", "&run ", deck=deck, steps=40)
        assert run.history["step"].tolist() == [*range(11), *range(12, 41, 4)]

    def test_echo_is_kept(self, options):
        """The checkpoint contains the deck that wrote it, and a restarted run writes its own deck."""
        run = self.run_of(options, "echo")
        self.again(run, "friction=0.2", "friction=0.5", "--quiet")
        self.again(run, "friction=0.2", "friction=0.5", "--quiet", steps=30)
        assert "was 0.2" not in run.output
        assert json.loads(run.path(".summary.json").read_text(encoding="utf-8"))["steps"] == 30
