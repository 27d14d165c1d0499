# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
# timeout: 240
"""Libraries with a strength law that are broken, and decks that do not fit them.

Would catch: a library that is missing, of another kind, version or without a procedure, whose use crashes the program;
a declaration with repeated, long or wrong names, units or ranges that is accepted; a constant that the deck misspells,
leaves out, repeats or gives in a wrong unit; a rejection by the library that is lost; an error during a run without its
number; a restart that continues with the fields of another library; a law with static variables, a law that depends on
other rows or on the orientation, that `--check` accepts; a field of a library that outputs do not know.
"""

import pytest

import case
import law_libraries

SOURCE = r"""
#include "scree_law.h"
#ifndef TEXT
#define TEXT "law soft\nconstant Y [Pa] > 0 : yield stress\nfield mark [1] start 2 : count\n"
#endif
#ifndef BODY
#define BODY
#endif
#ifndef VERSION
#define VERSION SCREE_LAW_INTERFACE
#endif
#ifndef NAME
#define NAME scree_law_update
#endif
static double calls;
int32_t scree_law_interface(void) { return VERSION; }
const char *scree_law_declaration(void) { return TEXT; }
void NAME(scree_rows *r) { calls += 0.0 * r->dt; BODY; }
#ifdef CHECK
int32_t scree_law_check(const double *constants, char *message, int64_t length)
{
   const char *text = "Y is too large";
   for (int64_t i = 0; i < length - 1 && *text; i++)
      *message++ = *text++;
   *message = 0;
   return constants[0] > 1.0e9;
}
const char *scree_law_explain(int32_t error) { return error == -7 ? "strain beyond the data" : 0; }
#endif
"""

DECK = """&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps=8 /
&material  name='a'  density=1000  bulk=2e9  shear=1e9
  strength_model='library'  library='law.so'
  library_constants={constants} /
&region  name='r'  shape='box'  lo=0.2,0,0  hi=0.7,1,1 /
&body  name='r'  region='r'  material='a'  velocity=10,0,0 /
&output  name='p'  kind='particles'  every=4  fields='identity','mark' /
"""
GOOD = "'Y = 90 MPa'"

# Flags of the compiler, and what the program must say.
BROKEN = {
    "version": (["-DVERSION=7"], "it has version 7 of the interface of laws and this program has version 1"),
    "no_update": (["-DNAME=update"], "it has no procedure scree_law_update"),
    "null": (["-DTEXT=0"], "its declaration has no line 'law NAME'"),
    "no_law": (['-DTEXT="stress whole\\n"'], "its declaration has no line 'law NAME'"),
    "twice": (['-DTEXT="law a\\nconstant Y [Pa] : one\\nconstant Y [Pa] : two\\n"'],
              "line 3 of its declaration: constant 'Y' is given twice"),
    "field_twice": (['-DTEXT="law a\\nfield f [1] : one\\nfield f [1] : two\\n"'], "field 'f' is given twice"),
    "long": (['-DTEXT="law a\\nconstant a234567890123456789012345678901234 [1] : long\\n"'],
             "is longer than 31 letters"),
    "letters": (['-DTEXT="law a\\nconstant Y-0 [Pa] : wrong\\n"'], "name 'Y-0' must begin with a letter"),
    "no_unit": (['-DTEXT="law a\\nconstant Y : wrong\\n"'], "'Y' needs a unit in brackets"),
    "unit": (['-DTEXT="law a\\nconstant Y [MPa] : wrong\\n"'], "'MPa' is not a unit of SI"),
    "range": (['-DTEXT="law a\\nconstant Y [Pa] positive : wrong\\n"'], "'positive' is not a range"),
    "start": (['-DTEXT="law a\\nfield f [1] start : wrong\\n"'], "'start' is not 'start' with a number"),
    "reserved": (['-DTEXT="law a\\nfield stress [Pa] : wrong\\n"'], "field 'stress' has the name of a field"),
    "word": (['-DTEXT="law a\\nstress all\\n"'], "line 2 of its declaration: 'stress all' is not one of"),
}

# Texts of library_constants, and what the program must say.
WRONG = {
    "unknown": ("'Y = 90 MPa', 'yy = 1'", "the library has no constant 'yy'"),
    "case": ("'y = 90 MPa'", "the library has no constant 'y'; did you mean Y?"),
    "missing": ("'Z = 1'", "library_constants: 'Y = NUMBER Pa' must be given: yield stress [D376]"),
    "again": ("'Y = 90 MPa', 'Y = 1 Pa'", "library_constants: 'Y' is given twice [D376]"),
    "unit": ("'Y = 90 m'", "library_constants: Y expects Pa or a unit of the same kind such as GPa, not 'm' [D202]"),
    "range": ("'Y = -1'", "library_constants: Y must be > 0 Pa [D214]"),
    "number": ("'Y = big'", "library_constants: Y expects a number"),
    "form": ("'Y 90'", "library_constants: 'Y 90' is not of the form 'NAME = NUMBER UNIT' [D376]"),
}

# Bodies of laws that break a rule, and what --check says about them.
UNFIT = {
    "static": ("calls += 1; for (int64_t i = 0; i < r->count; i++) r->stress[3][i] += calls",
               "the same particles on the same path end in other stresses or fields the second time"),
    "rows": ("for (int64_t i = 0; i < r->count; i++) r->stress[3][i] += r->stress[3][0]",
             "a row must not depend on other rows"),
    "outside": ("r->stress[3][r->count] = 1", "a call changes the stress or a field of particles that are not in its"),
    "infinite": ("for (int64_t i = 0; i < r->count; i++) r->history[0][i] = 1.0 / (r->dt - 1.0e-6)",
                 "a stress or a field is not a finite number"),
    "reports": ("r->error = 3", "of its law reports error 3"),
}


def skip_if_trapped(options):
    """Skip what makes numbers that are not finite in a build that traps them."""
    if " Debug " in case.version(options.scree):
        pytest.skip("a build that traps bad numbers stops before the message")


def prepared(options, name, constants, *flags):
    """A case with its library."""
    run = case.Case(options, name, DECK.format(constants=constants))
    (run.folder / "law.c").write_text(SOURCE, encoding="utf-8")
    law_libraries.build_c(run.folder / "law.c", run.folder / "law.so", *flags)
    return run


@pytest.mark.parametrize("name", BROKEN)
def test_broken(options, name):
    """Each broken library is an error of the deck that names the library."""
    flags, said = BROKEN[name]
    run = prepared(options, name, GOOD, *flags).run("--check", expect=2)
    assert f"cannot use the library '{run.folder}/law.so': " in run.output, run.output
    assert said in run.output and "[F127]" in run.output, run.output


def test_no_library(options):
    """A file that is missing, and one that is no library."""
    run = prepared(options, "missing", GOOD)
    (run.folder / "law.so").unlink()
    run.run("--check", expect=2)
    assert "cannot open shared object file: No such file or directory [F127]" in run.output, run.output
    # the field of the library in &output is not an error of its own
    assert "7 groups, 1 errors" in run.output, run.output
    run.run("--check", "-s", "material.library=.", expect=2)
    assert "[F127]" in run.output, run.output
    (run.folder / "law.so").write_text("not a library", encoding="ascii")
    run.run("--check", expect=2)
    assert "cannot use the library" in run.output and "[F127]" in run.output, run.output


@pytest.mark.parametrize("name", WRONG)
def test_constants(options, name):
    """Each wrong constant is an error of the deck."""
    constants, said = WRONG[name]
    run = prepared(options, name, constants).run("--check", expect=2)
    assert said in " ".join(run.output.split()), run.output


def test_units(options):
    """A number without a unit is in SI, and is refused where the deck has other units."""
    run = prepared(options, "units", "'Y = 9e7'").run("--check")
    assert "law: soft of" in run.output and "; Y = 9.0e7 Pa" in run.output, run.output
    run.deck.write_text("&units system='mm-ms-g' /\n" + run.deck.read_text(encoding="utf-8"), encoding="utf-8")
    run.run("--check", expect=2)
    assert "'Y = 9e7' needs a unit, such as Pa, in a deck with &units [D376]" in run.output, run.output


def test_rejected(options):
    """The check of a library rejects constants with its own words."""
    run = prepared(options, "rejected", "'Y = 2 GPa'", "-DCHECK").run("--check", expect=2)
    assert "library_constants: the library rejects them: Y is too large [D376]" in run.output, run.output
    prepared(options, "accepted", GOOD, "-DCHECK").run("--check")


@pytest.mark.parametrize("name", UNFIT)
def test_unfit(options, name):
    """`--check` finds laws that break a rule; a run accepts those that are finite."""
    body, said = UNFIT[name]
    if name in ("infinite", "reports"):
        skip_if_trapped(options)
    run = prepared(options, name, GOOD, f"-DBODY={body}").run("--check", expect=2)
    assert said in run.output and "[F128]" in run.output, run.output


def test_orientation(options):
    """A law with a direction of its own is a warning."""
    run = prepared(options, "direction", GOOD, "-DBODY=for (int64_t i = 0; i < r->count; i++) r->stress[0][i] *= 0.5, "
                   "r->stress[2][i] -= r->stress[0][i]").run("--check")
    assert "the stress depends on the orientation" in run.output and "[F128]" in run.output, run.output


def test_error_in_run(options):
    """An error ends the run with its number and meaning, the same for one and two ranks."""
    skip_if_trapped(options)
    body = "-DBODY=if (r->gradient[0][0] < -1e-9) { r->error = -7; r->error_row = 0; }"
    said = []
    for ranks in (1, 2) if case.has_ranks(options.scree) else (1,):
        run = prepared(options, f"error_{ranks}", GOOD, body, "-DCHECK")
        run.ranks = ranks
        deck = run.deck.read_text(encoding="utf-8").replace("hi=0.7,1,1", "hi=1,1,1").replace("max_steps=8", "")
        run.deck.write_text(deck + "&boundary  face='all'  type='slip' /\n", encoding="utf-8")
        run.run("-q", expect=4)
        said += [line for line in run.output.split("\n") if "its stress is not a finite number" in line][:1]
        assert "reports error -7: strain beyond the data" in run.output, run.output
    assert len({line.partition("error_")[0] for line in said}) == 1, said


def test_restart(options):
    """Fields are in outputs and in checkpoints; a library with other fields cannot continue."""
    run = prepared(options, "restart", GOOD, "-DBODY=for (int64_t i = 0; i < r->count; i++) r->history[0][i] += 1")
    run.run("-q", "-s", "time.max_steps=4")
    marks = run.snapshots()[-1][1].fields["mark"]
    assert set(marks) == {6.0}, marks
    law_libraries.build_c(run.folder / "law.c", run.folder / "law.so",
                          r'-DTEXT="law soft\nconstant Y [Pa] > 0 : yield stress\nfield other [1] : count\n"')
    run.deck.write_text(run.deck.read_text(encoding="utf-8").replace(",'mark'", ""), encoding="utf-8")
    run.run("-q", "--restart", expect=3)
    assert "these keys must not change" in run.output and "library_fields" in run.output, run.output
    law_libraries.build_c(run.folder / "law.c", run.folder / "law.so",
                          r'-DTEXT="law soft\nconstant Y [Pa] > 0 : yield stress\n"')
    run.run("-q", "--restart", expect=3)
    assert "mark [1]" in run.output, run.output
    run.run("-q", "--check", "-s", "material.library_fields='mark [1]'", expect=2)
    assert "the fields of the library are 'none', not 'mark [1]'" in run.output, run.output
