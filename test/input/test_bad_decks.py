# SPDX-License-Identifier: BSD-3-Clause
"""Wrong decks and command lines: all faults in one pass, with line and hint, and the exit code.

Would catch a fault that is not seen, is seen at another line, hides the next one, crashes the
program, or changes a file.
"""

import os
import subprocess
import unittest

import case

OPTIONS = case.arguments(__doc__)

GOOD = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1e-5 /
&material name = 'metal'  density = 2700
  young = 70e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&body name = 'one'  region = 'ball'  material = 'metal' /
"""

# The faults of the transcript in the manual, and what is said about them.
FAULTY = """&run
  title = 'many faults'
  dimention = '3d'
/
&grid
  lo = 0, 0, 0
  hi = 30, 30, 30
  dx = 1 mm
/
&material
  name = 'first'
  density = 2700 kg
  young = 70e9
  poisson = 0.3
  strength_model = 'jonson_cook'
/
&material name = 'second'  density = 7800  young = 200e9  poisson = 0.3
&region name = 'ball'  shape = 'sphere'  centre = 3*15  radius = 5 /
&body name = 'one'  region = 'bal'  material = 'first' /
&time
  t_end = 1
/
&boundry face = 'xlo' /
&output name = 'o'  kind = 'history'  every = 2.5 /
&time t_end = 2 /
&effects gravity = yes /
"""
SAID = """faulty.nml:3: error: &run: unknown key 'dimention'; did you mean 'dimension'?
faulty.nml:8: error: &grid: dx = 1 mm  <- expects a number
faulty.nml:12: error: &material: density = 2700 kg  <- expects a number
faulty.nml:15: error: &material: strength_model = 'jonson_cook' is none of:
faulty.nml:18: error: &material opened in line 17 is not closed before this group
faulty.nml:19: error: &body 'one': no region 'bal'; defined: ball; did you mean 'ball'?
faulty.nml:23: error: unknown group &boundry; did you mean &boundary?
faulty.nml:24: error: &output: every = 2.5  <- expects a whole number
faulty.nml:25: error: &time appears twice; only one is allowed
faulty.nml:26: error: &effects: gravity = yes  <- expects .true. or .false.
faulty.nml: 11 groups, 10 errors, 0 warnings"""

# Old text, new text, a part of what must be said about it.
CHANGES = [
    ("density = 2700", "density = -2700", ":4: error: &material: density = -2700  <- must be > 0"),
    ("density = 2700", "density = ", ":4: error: &material: density =   <- expects a number"),
    ("density = 2700", "", ":4: error: &material 'metal': density must be given"),
    ("density = 2700", "densty = 2700", ":4: error: &material: unknown key 'densty'; did you mean"),
    ("poisson = 0.3", "poisson = 0.5", ":5: error: &material: poisson = 0.5  <- must be"),
    ("poisson = 0.3", "bulk = 1e9", "young"),
    ("'metal' /", "'metall' /", ":7: error: &body 'one': no material 'metall'; defined: metal;"),
    ("'metal' /", "'metal' velocity = 0 0 NaN /", "velocity = 0 0 NaN  <- expects 3 numbers"),
    ("'metal' /", "'metal' velocity = 1 2 3 4 /", "velocity = 1 2 3 4  <- expects 3 numbers, not 4"),
    ("'metal' /", "'metal' velocity = 0 1 0 /", "velocity must be 0 in y"),
    ("/\n&grid lo = 0 0 0  hi = 1 0.1 1", " method = 'mpm' /\n&method basis = 'gimp' /\n&boundary "
     "face = 'all' type = 'periodic' /\n&grid lo = 0.4 0 0  hi = 0.7 0.1 1", ":2: error: &method: "
     "basis = 'gimp' needs at least 4 cells along x, which is periodic, but there are 3; take"),
    ("'metal' /", "'metal' temperature = 300 /", "temperature needs &effects thermal = .true."),
    ("'metal' /", "'metal' specific_energy = 1 /", "material 'metal' carries no internal energy"),
    ("'metal' /", "'metal' /\n&exact solution = 'vortx' /", "did you mean 'vortex'?"),
    ("'metal' /", "'metal' /\n&exact origin = 0 0 0 /", "origin given but solution = 'none'"),
    ("'metal' /", "'metal' /\n&exact solution = 'vortex' /", "frequency must be given"),
    ("'metal' /", "'metal' /\n&exact solution = 'vortex' frequency = 1 mode = 2 /", "mode given but"),
    ("'metal' /", "'metal' /\n&exact solution = 'vortex' frequency = 1 /",
     ":4: error: &material 'metal': solution = 'vortex' of &exact holds for strength_model = 'neo_hookean' only"),
    ("'metal' /", "'metal' /\n&exact solution = 'vortex' frequency = 1 inner_radius = 2 /",
     ":8: error: &exact: solution = 'vortex' needs outer_radius above inner_radius"),
    ("'metal' /", "'metal' spin = 0 1 0 /\n&exact solution = 'spinning_disc' angular_speed = 1 disc_radius = 1 /",
     ":7: error: &body 'one': &exact gives the rotation; remove spin"),
    ("'metal' /", "'metal' velocity = 0 0 1 /\n&exact solution = 'bar_mode' bar_length = 1 mode_speed = 1 /",
     ":7: error: &body 'one': &exact gives the velocity; remove it here"),
    ("'metal' /", "'metal' /\n&exact solution = 'bar_mode' bar_length = 1 mode_speed = 1 flight_speed = 2 /",
     ":8: error: &exact: solution = 'bar_mode' can fly with ends = 'free_free' only"),
    ("'metal' /", "'metal' /\n&exact solution = 'bar_mode' bar_length = 1 mode_speed = 1 bodies = 'two' /",
     "no body 'two'; defined: one"),
    ("'metal' /", "'metal' /\n&body name = 'two' region = 'ball' material = 'metal' /\n"
     "&exact solution = 'bar_mode' bar_length = 1 mode_speed = 1 bodies = 'one' /",
     ":8: error: &body 'two': is of the material of a body that &exact names"),
    ("'metal' /", "'metal' /\n&body name = 'one' region = 'ball' material = 'metal' /", ":8: error:"),
    ("'metal' /", "metal /", "material = metal  <- expects a text in quotes"),
    ("'metal' /", "'metal /", ":7: error: &body: the quote is not closed"),
    ("'metal' /", "'metal'", ":7: error: &body is not closed"),
    ("dx = 0.1", "dx = 0.3", "nearest: hi = 0.9 or dx = 0.333333"),
    ("dx = 0.1", "", "&grid: dx or cells must be given"),
    ("hi = 1 0.1 1", "hi = 1 0.1", "hi = 1 0.1  <- expects 3 numbers, not 2"),
    ("hi = 1 0.1 1", "hi(4) = 1", "hi(4)  <- places are counted from 1 to 3"),
    ("'plane_strain'", "'plain_strain'", "did you mean 'plane_strain'?"),
    ("'plane_strain'", "'axisymmetric'  deck_version = 1e3", "deck_version = 1e3  <- expects a whole number"),
    ("'plane_strain'", "'1d'  case = 'a/b'", "is part of file names"),
    ("shape = 'sphere'", "shape = 'sphere'  height = 1", "height given but shape = 'sphere'"),
    ("radius = 0.2", "radius = 2.7e3*2", "radius = 2.7e3*2  <- expects a number"),
    ("t_end = 1e-5", "t_end = 1e400", "t_end = 1e400  <- is too large or too small"),
    ("t_end = 1e-5", "t_end = 1/3", "numbers are no expressions"),
    ("&time", "&effects gravity_vector = 0 0 1 /\n&time", "given but gravity = .false."),
    ("&time", "&effects damage = 1 /\n&time", "damage = 1  <- expects .true. or .false."),
    ("&time", "&boundary face = 'xlo' type = 'periodic' /\n&time", "periodic needs both faces"),
    ("&time", "&output name = 'o' kind = 'history' /\n&time", "give one of dt, every, times, count"),
    ("&time", "&units system = 'imperial' /\n&time", "system = 'imperial' is none of: si cgs"),
    ("&time", "time\n&time", ":3: error: text outside a group: time"),
]

COMMANDS = [
    (["--set", "grid.dxx=1"], "command line: error: &grid: unknown key 'dxx'; did you mean 'dx'?"),
    (["--set", "grid.dx=abc"], "command line: error: &grid: dx = abc  <- expects a number"),
    (["--set", "material[x].young=1"], "command line: error: no &material 'x'; there are: metal"),
    (["--set", "grid"], "command line: error: grid  <- expects GROUP.KEY=VALUE"),
    (["--chek"], "command line: error: unknown option --chek; did you mean --check?"),
]


class BadDecks(unittest.TestCase):
    """Each is checked only: nothing is computed."""

    def check(self, name, text, *options, expect=2):
        """Write a deck, or the bytes given, check it, and give back what is said."""
        folder = OPTIONS.work / name
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{name}.nml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        before = sorted(os.listdir(folder))
        return self.run_check(path, options, expect, folder, before)

    def run_check(self, path, options, expect, folder, before):
        answer = subprocess.run([OPTIONS.scree, "--check", *options, path.name], cwd=folder,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=60,
                                env={**os.environ, **case.OPEN_MPI}, check=False)
        output = answer.stdout.decode(errors="replace")
        self.assertEqual(answer.returncode, expect, output)
        self.assertEqual(before, sorted(os.listdir(folder)), "--check wrote a file")
        return output

    def test_all_faults_in_one_pass(self):
        """Would catch a fault that hides another one."""
        output = self.check("faulty", FAULTY).splitlines()
        wanted = SAID.splitlines()
        found = [line for line in output if line.startswith("faulty.nml")]
        self.assertEqual(len(found), len(wanted), "\n".join(output))
        for line, start in zip(found, wanted):
            self.assertTrue(line.startswith(start), f"{line}\n{start}")

    def test_good_deck(self):
        """Would catch a check that finds faults where there are none: the changes start from it."""
        output = self.check("good", GOOD, expect=0)
        self.assertIn("good.nml: 6 groups, 0 errors, 0 warnings", output)

    def test_changes(self):
        """Would catch a single fault without its message."""
        for number, (old, new, said) in enumerate(CHANGES):
            with self.subTest(new):
                self.assertIn(old, GOOD)
                name = f"change_{number}"
                output = self.check(name, GOOD.replace(old, new))
                self.assertIn(said, output)

    def test_command_lines(self):
        """Would catch a wrong option that is ignored."""
        for options, said in COMMANDS:
            with self.subTest(options):
                self.assertIn(said, self.check("command", GOOD, *options))

    def test_what_is_no_deck(self):
        """Would catch a crash, or a wrong exit code, on files that are no deck."""
        self.assertIn("the deck is empty; scree --template", self.check("empty", ""))
        self.assertIn("the deck is empty", self.check("comment", "! nothing here\n"))
        self.assertIn("a deck is plain text", self.check("binary", bytes(range(256)) * 40))
        self.assertIn("not closed", self.check("open", "&run"))
        self.assertIn("unknown group", self.check("long", "&" + "x" * 500 + " /"))
        self.assertIn("longer than 512", self.check("line", GOOD + "!" + "x" * 600))
        folder = OPTIONS.work
        before = sorted(os.listdir(folder))
        self.run_check(folder / "nobody.nml", [], 3, folder, before)
        self.run_check(folder / "empty", [], 3, folder, before)

    def test_includes(self):
        """Would catch an include that never ends or is ignored."""
        self.assertIn("cannot include itself", self.check("ring", "&include file = 'ring.nml' /"))
        self.assertIn("cannot read 'nobody.nml'",
                      self.check("lost", "&include file = 'nobody.nml' /", expect=3))

    def test_other_ends_of_lines(self):
        """Would catch decks of other systems that are read differently."""
        self.check("returns", GOOD.replace("\n", "\r\n"), expect=0)
        self.check("tabs", GOOD.replace("  ", "\t").rstrip("\n"), expect=0)
        self.check("mark", b"\xef\xbb\xbf" + GOOD.encode(), expect=0)


if __name__ == "__main__":
    unittest.main()
