# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The choice of mutants by scripts/mutate.py, and the list of mutants in test/mutants.

Would catch a list whose lines are no longer in the sources, a random choice that differs between two calls, and mutants
of comments, texts or declarations, which no test can find.
"""

import pytest

from mutants import places
from sources import ROOT

LISTS = [ROOT / "test/mutants/by_hand.txt", ROOT / "test/mutants/survivors.txt"]
SOURCE = """module m
   real :: spacing = 1.0_wp
contains
   !> Adds 1 + 2.
   subroutine s(x, error)
      real(wp), intent(inout) :: x(3)   !! a + b
      x(1) = -x(2)*0.5_wp + 1.0e-12_wp  ! a - b
      if (x(1) > 0.0_wp) call fail(error, exit_deck, "1 + 1 = "//text(1 + 1))
      print "(a)", "1 + 1"
      x(3) = min(x(1), &
         x(2) - 1.0_wp)
   end subroutine s
end module m
"""


@pytest.fixture
def folder(tmp_path):
    """A project with one source."""
    (tmp_path / "src/base").mkdir(parents=True)
    (tmp_path / "src/base/m.f90").write_text(SOURCE, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize("file", LISTS, ids=lambda file: file.stem)
def test_list_fits_sources(file):
    found = places.read_list(ROOT, file)
    assert len(found) >= 30
    assert len({mutant.layer for mutant in found}) >= 7
    assert all(mutant.before != mutant.after for mutant in found)


def test_wrong_line_is_reported(folder):
    wrong = folder / "list.txt"
    wrong.write_text("file: src/base/m.f90\n- x(1) = x(2)\n+ x(1) = x(3)\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"list.txt:3: 'x\(1\) = x\(2\)' is 0 times in src/base/m.f90"):
        places.read_list(folder, wrong)
    wrong.write_text("file: src/base/m.f90\n- x(3) = min(x(1), &\n\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"the block has no line '\+'"):
        places.read_list(folder, wrong)


def test_line_of_a_procedure(folder):
    """The same line in two procedures; a procedure that is not there has no lines."""
    again = SOURCE.replace("end module m", "   subroutine t(x)\n      print \"(a)\", \"1 + 1\"\n   end subroutine t\n"
                           "end module m")
    (folder / "src/base/m.f90").write_text(again, encoding="utf-8")
    text = "file: src/base/m.f90\n{}- print \"(a)\", \"1 + 1\"\n+ print *\n"
    found = folder / "list.txt"
    for name, line in (("in: s\n", 9), ("in: t\n", 14)):
        found.write_text(text.format(name), encoding="utf-8")
        assert [mutant.line for mutant in places.read_list(folder, found)] == [line]
    for name, times in (("", "is 2 times in src"), ("in: u\n", "is 0 times in u of src")):
        found.write_text(text.format(name), encoding="utf-8")
        with pytest.raises(ValueError, match=times):
            places.read_list(folder, found)


def test_changes(folder):
    """Of the first statement: the sign, three indices, both operators and one constant. Of the condition: all but the
    message. Of the last statement: also its second line."""
    found = [mutant for here in places.candidates(folder, folder / "src/base/m.f90") for mutant in here]
    after = {mutant.after.strip() for mutant in found if mutant.line == 7}
    rest = "*0.5_wp + 1.0e-12_wp  ! a - b"
    assert {"x(1) = x(2)" + rest, "x(2) = -x(2)" + rest, "x(1) = -x(3)" + rest} <= after
    assert {"x(1) = -x(2)/0.5_wp + 1.0e-12_wp  ! a - b", "x(1) = -x(2)*0.5_wp - 1.0e-12_wp  ! a - b",
            "x(1) = -x(2)*1.0_wp + 1.0e-12_wp  ! a - b"} <= after
    assert len(after) == 6
    condition = [mutant.after.strip() for mutant in found if mutant.line == 8]
    assert len(condition) == 4 and all('call fail(error, exit_deck, "1 + 1 = "//text(1 + 1))' in line
                                       for line in condition)
    assert {mutant.line for mutant in found} == {7, 8, 10, 11}


def test_same_seed_same_mutants():
    first, again = (places.choose(ROOT, 220, 4, 1) for _ in range(2))
    assert first == again and len(first) >= 220
    layers = [mutant.layer for mutant in first]
    folders = {path.name for path in (ROOT / "src").iterdir() if path.is_dir()}
    assert {layer: layers.count(layer) for layer in folders if layers.count(layer) < 4} == {}
