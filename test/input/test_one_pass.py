# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""All errors of a deck are reported in one pass, each once, and no warning without a reason.

Would catch: fields of outputs that are checked only if there is no other error, errors that only follow from an invalid
preset, one mistake in a repeated body that is reported for each copy, a gas with a warning about its low density, a
table of gravity that is called one of velocities, a velocity formula that fails only when the run begins, and a run
that continues when no material is left.
"""

import re
import shutil
import subprocess

DECK = {"run": "&run case='c' dimension='plane_strain' /", "grid": "&grid lo=0,0,0 hi=1,1,1 dx=0.1 /",
        "time": "&time t_end=1e-3 /", "material": "&material name='m' preset='al_6061_t6' /",
        "region": "&region name='r' shape='sphere' centre=0.5,0,0.5 radius=0.25 /",
        "body": "&body name='b' region='r' material='m' /"}


def said_of(options, name, *words, files=None, expect=2, **groups):
    """Output of a check, or of another call, for a deck with some groups changed: its lines except the last."""
    folder = options.work / f"{name} ü"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for file, text in (files or {}).items():
        (folder / file).write_text(text, encoding="utf-8")
    deck = folder / "deck.nml"
    deck.write_text("\n".join({**DECK, **groups}.values()) + "\n", encoding="utf-8")
    words = words or ("--check", "--no-estimate")
    answer = subprocess.run([options.scree, *words, deck.name], cwd=folder, text=True, capture_output=True,
                            check=False, timeout=100)
    if answer.returncode != expect:
        raise AssertionError(f"exit code {answer.returncode}, not {expect}: {answer.stdout}{answer.stderr}")
    return answer.stdout + answer.stderr


def problems(said):
    """Lines with errors and warnings."""
    return [line for line in said.splitlines() if ": error: " in line or ": warning: " in line]


class TestOnePass:
    """Decks with a few mistakes each."""

    def test_preset(self, options):
        """Would catch follow-up errors of an invalid preset, on keys that it sets or that depend on such keys."""
        for word, near in (("aluminium_6061", "al_6061_t6"), ("copper", "cu_ofhc"), ("al6061", "al_6061_t6"),
                           ("steel 1006", "steel_1006"), ("al_6061_t5", "al_6061_t6")):
            lines = problems(said_of(options, "preset", material=f"&material name='m' preset='{word}' jc_a=1e8 /"))
            assert len(lines) == 1, lines
            assert f"did you mean '{near}'?" in lines[0]
        # a warning about the wave speed of a material that is not known
        lines = problems(said_of(options, "no modulus", material="&material name='m' density=2700 young=7e10 /"))
        assert len(lines) == 1, lines
        lines = problems(said_of(options, "no preset", material="&material name='m' preset='xyz' /"))
        assert "did you mean" not in lines[0]
        lines = problems(said_of(options, "given wrong", material="&material name='m' preset='copper' density=-1 /"))
        assert len(lines) == 2, "an error that does not follow from the preset is reported"

    def test_fields(self, options):
        """Would catch fields that are checked only after all else, or of which only the first invalid one is
        reported."""
        output = "&output name='o' kind='{}' dt=1e-4 fields='{}','velocty','mass' /"
        for other in ({}, {"time": "&time t_end=1 parsec /"}, {"material": "&material name='m' preset='al_60' /"},
                      {"grid": "&grid lo=0,0,0 hi=1,1,1 dx=-1 /"}):
            for kind in ("particles", "grid", "profile", "slice"):
                at = " " if kind != "slice" else " at=0.5 "
                said = said_of(options, "fields", output=output.format(kind, "pressur").replace(" dt", at + "dt"),
                               **other)
                wrong = [line for line in problems(said) if "output field" in line]
                assert len(wrong) == 2, said
                assert "; did you mean 'pressure'?" in wrong[0]
                assert "'velocty' is unknown" in wrong[1]
                assert len(problems(said)) == 2 + len(other), said
            said = said_of(options, "history", output="&output name='o' kind='history' dt=1e-4 fields='kinetik' /",
                           **other)
            assert "did you mean 'kinetic'?" in said
        said = said_of(options, "lacks", time="&time t_end=1 parsec /",
                       output="&output name='o' kind='particles' dt=1e-4 fields='temperature' /")
        assert "is not stored by any material of this scene" in said

    def test_repeat(self, options):
        """Would catch a mistake that is reported for each copy, or the number of copies missing in the message."""
        body = "&body name='b' region='r' material='m' repeat=3,1,2 repeat_step={},0,0.02 temperature=300 /"
        lines = problems(said_of(options, "copies", body=body.format(0.01)))
        errors = [line for line in lines if ": error: " in line]
        assert len(errors) == 1, lines
        assert "&body 'b': temperature needs" in errors[0]
        assert errors[0].endswith("(all 6 copies) [D306]"), errors
        lines = problems(said_of(options, "outside", body=body.format(1.5).replace(" temperature=300", "")))
        errors = [line for line in lines if ": error: " in line]
        assert len(errors) == 1, lines
        assert re.search(r"&body 'b_2_1|&body 'b_3_1", errors[0])
        assert re.search(r"lies outside of the grid.*\(and \d more among the 6 copies\) \[D409\]$", errors[0])

    def test_gas(self, options):
        """Would catch a warning about the low density of a gas, and the lack of one for a solid or a liquid in other
        units."""
        light = "lighter than polystyrene"
        gas = "&material name='m' density={} elastic='none' {} /"
        for density, keys, warned in ((1.2, "eos_model='ideal_gas' ig_gamma=1.4", False),
                                      (1e-3, "eos_model='ideal_gas' ig_gamma=1.4", False),
                                      (1.2, "bulk=1.4e5", False), (1.0, "bulk=2.2e9", True),
                                      (1.0, "bulk=2.2", True)):
            said = said_of(options, "gas", material=gas.format(density, keys), expect=0)
            assert (light in said) == warned, (density, keys, said)
        said = said_of(options, "solid", material="&material name='m' density=2.7 young=7e5 poisson=0.3 /", expect=0)
        assert light in said

    def test_gravity_table(self, options):
        """Would catch an invalid file of gravity that is reported as one of velocities, or without the key that names
        it."""
        effects = "&effects gravity=.true. gravity_vector=0,0,-9.8 gravity_table='g.csv' /"
        said = said_of(options, "no table", effects=effects)
        assert "&effects: gravity_table: cannot read 'g.csv'" in said
        said = said_of(options, "table", effects=effects, files={"g.csv": "0 0 0\n"})
        assert (
            "gravity_table: cannot read the accelerations of 'g.csv': line 1: expected four numbers t, gx, gy, gz"
        ) in said

    def test_formula(self, options):
        """Would catch a formula without a value at one particle of many that a check does not report."""
        formula = "&body name='b' region='r' material='m' velocity_formula='1/(x-0.525)','0','sqrt(z-0.3)' /"
        lines = problems(said_of(options, "formula", body=formula))
        assert len(lines) == 1
        assert re.search(r"deck.nml:6: error: &body 'b': velocity_formula: .* at x, y, z = ", lines[0])
        said_of(options, "sound formula", body=formula.replace("-0.525", "-0.52").replace("-0.3", "-0.2"), expect=0)
        lines = problems(said_of(options, "two", time="&time t_end=1 parsec /", body=formula))
        assert len(lines) == 2, lines

    def test_all_has_left(self, options):
        """Would catch a run that continues without material, does not report this, or cannot be restarted."""
        body = "&body name='b' region='r' material='m' velocity=3000,0,0 /"
        said = said_of(options, "left", "--overwrite", body=body, time="&time t_end=0.1 /", expect=0)
        assert re.search(r"warning: all material has left the grid before t_end, through open boundaries", said)
        assert re.search(r"ended +all material has left the grid", said)
        folder = options.work / "left ü"
        again = subprocess.run([options.scree, "deck.nml", "--restart"], cwd=folder, text=True, capture_output=True,
                               check=False, timeout=100)
        assert again.returncode == 0, again.stderr
        assert re.search(r"ended +all material has left the grid", again.stdout)

    def test_list(self, options):
        """Would catch --list without a value that is an error, or that names a list that does not exist."""
        answer = subprocess.run([options.scree, "--list"], text=True, capture_output=True, check=False)
        assert answer.returncode == 0, answer.stderr
        names = [line.split()[0] for line in answer.stdout.splitlines() if line.startswith("   ")]
        assert len(names) > 4
        for name in names:
            answer = subprocess.run([options.scree, "--list", name], text=True, capture_output=True, check=False)
            assert answer.returncode == 0, answer.stderr
            assert len(answer.stdout) > 10
        answer = subprocess.run([options.scree, "--list", "?"], text=True, capture_output=True, check=False)
        assert answer.returncode == 2
        for name in names:
            assert name in answer.stderr
