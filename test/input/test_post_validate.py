# SPDX-License-Identifier: BSD-3-Clause
# timeout: 120
"""scree-post validate: list, mistakes, verdicts, a measured row, a prediction, and the page.

The first line of each test states which bug it would catch. Runs have few cells: only the shock has a limit, 3 %, the
error of 20 cells behind a front of two to three cells.
"""

import csv
import subprocess

import pytest

import case
from post_command import call
from scree_post import validation
from scree_post.commands import validate

PAGE = "# Page\n\nbefore\n\n<!-- rows -->\nold\n<!-- end of rows -->\n\nafter\n"


def lines_of(answer):
    """Lines of the table that a call printed."""
    assert answer.returncode == 0, answer.stderr
    lines = answer.stdout.splitlines()
    first = next(place for place, line in enumerate(lines) if line.startswith("row "))
    return [line for line in lines[first + 1:] if line.startswith(("shock_", "prediction"))]


def test_list():
    """A row that the list lacks, and one name for two rows."""
    said = call("validate").stdout
    known = validation.families()
    names = [*known, *(name for family in known.values() for name in family.shots)]
    assert len(names) == len(set(names)) > 30
    assert all(name in said.replace(":", " ").split() for name in names)


@pytest.mark.parametrize("words, code, parts", [
    (("tayler",), 2, ("no row 'tayler'", "did you mean 'taylor'", "taylor_cu_190")),
    (("taylor_cu_190", "--set", "sped=3"), 2, ("no input 'sped'", "did you mean 'speed'")),
    (("taylor", "hugoniot", "--set", "speed=3"), 2, ("one row or family",)),
    (("taylor", "--set", "speed=3", "--write"), 2, ("without --set",)),
    (("taylor", "--set", "speed"), 2, ("not of the form NAME=VALUE",)),
    (("taylor", "--cells", "1"), 2, ("not an integer above 1",)),
    (("taylor_cu_190", "--write", case.ROOT / "README.md"), 3, ("does not contain the lines",)),
    (("taylor_cu_190", "--set", "speed=fast"), 2, ("cells = 12", "speed = fast"))])
def test_mistakes(options, words, code, parts):
    """A mistake that starts runs, another exit code, a message without what is allowed."""
    answer = call("validate", *words, "--scree", options.scree, folder=options.work)
    assert answer.returncode == code, answer.stderr
    assert all(part in answer.stderr for part in parts), answer.stderr


def test_verdicts():
    """A limit that ignores the error of the measurement, and a coarse grid or an unknown condition that is judged."""
    def verdict(prediction, cells=0.0, error=None, blocked="", measured=100.0):
        return validation.Result("f", "n", "q", "1", prediction, cells, measured, error, 0.0, blocked).verdict

    assert [verdict(95.1), verdict(104.9), verdict(94.9), verdict(105.1)] == ["within"] * 2 + ["outside"] * 2
    assert verdict(92.0, error=8.5) == "within" and verdict(104.0, error=1.0) == "within"
    assert verdict(100.0, cells=5.1) == verdict(100.0, cells=-5.1) == verdict(100.0, blocked="why") == "not comparable"
    assert verdict(100.0, cells=float("nan")) == "not comparable"
    assert verdict(1.0, measured=float("nan")) == "no measurement"


def test_decks(options, sheet):
    """A heading of data.csv that the deck does not know, and a deck that is not accepted on one of its two grids."""
    for family in validation.families().values():
        first, *_, last = (*family.shots.values(), *family.shots.values())
        for shot, cells in ((first, family.cells), (last, round(family.cells / family.coarser))):
            words = [word for key, value in family.settings(shot.inputs, cells).items()
                     for word in ("--set", f"{key}={value}")]
            answer = subprocess.run([options.scree, "--echo", *words, family.folder / "deck.nml"], text=True,
                                    capture_output=True, check=False)
            sheet.require(answer.returncode == 0, f"{shot.name}, cells = {cells}: {answer.stderr}")
            sheet.require(all(name in shot.error for name in shot.measured) and shot.measured and shot.source,
                          f"{shot.name} has a measurement and a source")


def test_measured_row(options):
    """A measurement of another row, a deviation or a difference of grids that is wrong, a page that loses rows."""
    page = options.work / "page.md"
    page.write_text(PAGE, encoding="utf-8")
    words = ("--cells", 40, "--scree", options.scree, "--write", page)
    first = lines_of(call("validate", "shock_cu_2857", *words, folder=options.work))
    prediction, cells, measured = map(float, first[0].split()[6:9])
    error, deviation, verdict = (first[0].split()[place] for place in (9, 11, 13))
    copper = 3940.0 + 1.489 * 2857.3                     # Hugoniot of the preset
    assert abs(prediction / copper - 1.0) < 0.03 and measured == 8221.0 and error == "1.2"
    assert abs(float(deviation) - 100.0 * (prediction / measured - 1.0)) < 0.06 and verdict == "within"
    assert abs(cells) < 0.05 * measured
    lines_of(call("validate", "shock_al_2200", *words, folder=options.work))
    lines_of(call("validate", "shock_cu_2857", *words, folder=options.work))
    assert call("validate", "--write", page).returncode == 0, "the page alone, without runs"
    text = page.read_text(encoding="utf-8")
    assert text.startswith(PAGE.partition("old")[0]) and text.endswith(PAGE.partition("old\n")[2]) and "old" not in text
    subject = (options.work / "page_metals.md").read_text(encoding="utf-8")
    rows = [line for line in subject.splitlines() if line.startswith("| `")]
    assert [row.split("`")[1] for row in rows] == ["shock_cu_2857", "shock_al_2200"], "a line each, ordered"
    assert "2 measured quantities: 2 within" in text and "page_metals.md#shocks-in-metals" in text
    assert f"| {prediction:.4g} |" in rows[0]
    assert (options.work / "figures/page.png").stat().st_size > 10000


def test_prediction(options):
    """Inputs that do not reach the deck, without their unit, or with the measurement of another shot."""
    words = ("validate", "taylor_cu_190", "--cells", 3, "--scree", options.scree, "--set", "length=23.47", "--set")
    slow, fast = (lines_of(call(*words, f"speed={speed}", folder=options.work)) for speed in (89, "0.21km/s"))
    ratios = [float(lines[0].split()[5]) for lines in (slow, fast)]
    assert all("no measurement" in line for line in slow + fast) and len(slow) == 3
    assert abs(ratios[0] / 0.895 - 1.0) < 0.1 and abs(ratios[1] / 0.643 - 1.0) < 0.1, ratios


def test_page():
    """A page that is not that of its results, and results of other measurements than those of data.csv."""
    known = validation.families()
    with open(validation.place() / "results.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert {row["name"] for row in rows} == {name for family in known.values() for name in family.shots}
    for row in rows:
        shot = known[row["family"]].shots[row["name"]]
        assert float(row["measured"]) == shot.measured[row["quantity"]], row
    page, stem = validate.PAGE, validate.PAGE.stem
    pages = {page.name: validation.page_rows(known, rows, stem).join(validation.parts_of(page)),
             **validation.subject_pages(known, rows, stem)}
    there = {path.name: path.read_text(encoding="utf-8") for path in page.parent.glob(f"{stem}*.md")}
    assert there == pages
