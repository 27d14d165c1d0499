# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Numbers on the pages agree with the tables of recorded numbers, and the script that updates them reads its marks
correctly.

Would catch: a number that was changed by hand on a page, a mark whose number has no source, a number in a table that no
page shows, a mark that is assigned to other numbers, a comparison that accepts different numbers as equal, a table
that names a test that does not exist, a page of limits that is not what its sources say, a limit whose number has no
owner or whose owner is gone, and a known miss that the page does not list.
"""

import csv
import re
from pathlib import Path

import pytest

import document_numbers
import measured
from sources import ROOT

PAGE = Path("page.md")
TEXT = """It ends with <!--=bar.energy*100-->93<!--=--> times, within <!--=bar.{a,b}-->0.3 and 1.5<!--=--> %.

| error <!--=bar.cells_{20,40} - abs:bar.low--> | +4.3e-3 | +1.5e-3 (limit 2) | -0.2 % |
| tried in 2-D <!--=record.tried--> | 12 | 0.5 %, exit code 4 |
"""
VALUES = {"bar.energy": 0.9341, "bar.a": 0.00312, "bar.b": 0.0148, "bar.cells_20": 4.26e-3, "bar.cells_40": 1.54e-3,
          "bar.low": -0.0019}


def places():
    """The positions of the marks in the sample."""
    return document_numbers.places_of(PAGE, TEXT)


def test_marks():
    """Names, texts and factors of the marks on a page."""
    found = {place.name: (place.text, place.factor, place.size_only) for place in places()}
    assert found == {
        "bar.energy": ("93", 100.0, False), "bar.a": ("0.3", 100.0, False), "bar.b": ("1.5", 100.0, False),
        "bar.cells_20": ("+4.3e-3", 1.0, False), "bar.cells_40": ("+1.5e-3", 1.0, False),
        "bar.low": ("-0.2", 100.0, True), "record.tried.1": ("12", 1.0, False), "record.tried.2": ("0.5", 1.0, False),
        "record.tried.3": ("4", 1.0, False)}


def test_rewritten():
    """New values have the format of the old ones, and the rest of the page is unchanged."""
    assert document_numbers.rewritten(TEXT, places(), VALUES) == TEXT.replace("-0.2 %", "0.2 %")
    new = document_numbers.rewritten(TEXT, places(), {**VALUES, "bar.energy": 1.058, "bar.cells_40": -0.013})
    assert ">106<" in new and "| -1.3e-2 (limit 2) |" in new


def test_differences():
    """A difference of one unit of the last digit, or of round-off, is accepted."""
    by_name = {place.name: place for place in places()}
    for name, value, different in (("bar.energy", 0.9399, False), ("bar.energy", 0.9401, True),
                                   ("bar.cells_40", 1.601e-3, True), ("bar.cells_40", 1.4e-3, False),
                                   ("bar.cells_20", float("nan"), True), ("bar.low", 0.004, True)):
        assert by_name[name].differs(value) == different, (name, value)
    small = document_numbers.places_of(PAGE, "to <!--=bar.momentum-->6e-16<!--=-->")[0]
    assert not small.differs(3.0e-15) and small.differs(1.0e-9)


def test_wrong_marks():
    """A mark whose names do not fit its numbers is an error that names the line."""
    try:
        document_numbers.places_of(PAGE, "\n| error <!--=bar.cells_{20,40}--> | 4.3e-3 |\n")
    except ValueError as error:
        assert "page.md:2: 2 names for 1 numbers" in str(error)
    else:
        raise AssertionError("two names for one number are accepted")


def test_names():
    """Names of the numbers that tests record."""
    assert measured.slug("ddmp: first minimum of the tip [m].error") == "ddmp_first_minimum_of_the_tip_m.error"
    assert measured.slug("tillotson -0.3, 800 steps") == "tillotson_-0.3_800_steps"


def test_comparison_in_a_run(monkeypatch, tmp_path):
    """Numbers measured in a run are compared with the pages, and numbers that are no longer measured are reported."""
    right = document_numbers.places_of(PAGE, TEXT.replace("-0.2 %", "0.2 %"))
    monkeypatch.setattr(measured, "shown", lambda: {place.name: [place] for place in right})
    rows = [{"name": name, "value": value} for name, value in VALUES.items()]
    monkeypatch.setattr(measured.tier, "NAME", "full")
    assert measured.differences(rows) == []
    assert len(measured.differences([{"name": "bar.energy", "value": 0.95}])) == 1
    assert "measured twice" in measured.differences([*rows, {"name": "bar.a", "value": 0.0031}])[0]
    table = tmp_path / "measured.csv"
    table.write_text("name,value,limit,test,tier\nbar.a,1,,test_bar.py,full\nbar.b,1,,test_bar.py,long\n",
                     encoding="utf-8")
    monkeypatch.setattr(document_numbers, "MEASURED", table)
    assert [measured.compared(name) for name in ("bar.a", "bar.b", "bar.low")] == [True, False, True]
    assert measured.missing(set(), "test_bar.py") == ["bar.a"]
    assert measured.missing({"bar.a"}, "test_bar.py") == [] == measured.missing(set(), "test_other.py")


def test_numbers_of_other_pages(monkeypatch, tmp_path):
    """Numbers that the README of a scene or the study of accuracy owns; of several rows the first with cfl = 0.4."""
    readme = tmp_path / "input/ball/README.md"
    readme.parent.mkdir(parents=True)
    readme.write_text("<!--=hole-->18.5<!--=--> mm, <!--=runs-->2.2, 4.9<!--=-->\n", encoding="utf-8")
    (tmp_path / "accuracy.csv").write_text("problem,way,cells,ppc,cfl,error\nwaves,ddmp apic,8,2,0.7,9\n"
                                           "waves,ddmp apic,8,2,0.4,0.1\nwaves,ddmp apic,8,3,0.4,5\n"
                                           "waves,mpm,8,2,0.4,\n",
                                           encoding="utf-8")
    monkeypatch.setattr(document_numbers, "ROOT", tmp_path)
    monkeypatch.setattr(document_numbers, "ACCURACY", tmp_path / "accuracy.csv")
    assert document_numbers.scenes() == {"scene.ball.hole": 18.5, "scene.ball.runs.1": 2.2, "scene.ball.runs.2": 4.9}
    assert document_numbers.errors() == {"accuracy.waves.ddmp_apic.8": 0.1}
    text = "<!--=scene.ball.runs-->2.2 and 4.9<!--=--> m; <!--=abs:scene.ball.hole-->18<!--=--> %\n"
    assert [(place.name, place.factor) for place in document_numbers.places_of(PAGE, text)] == [
        ("scene.ball.runs.1", 1.0), ("scene.ball.runs.2", 1.0), ("scene.ball.hole", 1.0)]


def test_known_misses(monkeypatch, tmp_path):
    """Misses that appear, change their target or are met are reported, and the table follows the runs of the tests."""
    known = tmp_path / "known.csv"
    monkeypatch.setattr(document_numbers, "KNOWN", known)
    monkeypatch.setattr(measured, "shown", lambda: {})
    monkeypatch.setattr(measured.tier, "NAME", "full")

    def row(name, **more):
        return {"name": name, "value": 0.4, "limit": 1.0, "test": "test_bar.py", "tier": "full", **more}

    def miss(name, target=0.1):
        return row(name, target=target, title=f"bar: {name}")

    old = {name: row(name) for name in ("bar.a", "bar.b", "bar.c")}
    kept = row("bar.c", test="test_other.py")
    assert list(document_numbers.write_known({name: miss(name) for name in old}, old)) == ["bar.a", "bar.b", "bar.c"]
    assert measured.misses([miss("bar.a"), miss("bar.b"), row("bar.d")], "test/bar.py") == []
    assert "does not list the known miss bar.d" in measured.misses([miss("bar.d")], "test/bar.py")[0]
    assert "says 0.1 for the target of bar.a, which is 0.2" in measured.misses([miss("bar.a", 0.2)], "test/bar.py")[0]
    assert "lists bar.a, which is no longer" in measured.misses([row("bar.a")], "test/bar.py")[0]
    found = document_numbers.write_known({"bar.a": miss("bar.a", 0.2), "bar.b": row("bar.b")}, {**old, "bar.c": kept})
    assert {name: miss["target"] for name, miss in found.items()} == {"bar.a": 0.2, "bar.c": "0.1"}
    assert document_numbers.table(known)["bar.a"] == {"name": "bar.a", "title": "bar: bar.a", "target": "0.2"}


def test_limits_page(monkeypatch, tmp_path):
    """A limit and a known miss on the page; a limit that names a section that is gone is an error."""
    for name, text in (("LIMITS", "section,limit,size,owner\nSizes,rows,<!--=bar.a-->3<!--=-->,page.md#its-section\n"),
                       ("KNOWN", "name,title,target\nbar.b,bar: b,0.1\n"),
                       ("MEASURED", "name,value,limit,test,tier\nbar.b,0.456,1,test_bar.py,full\n")):
        monkeypatch.setattr(document_numbers, name, tmp_path / f"{name}.csv")
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    (tmp_path / "page.md").write_text("# Page\n\n## Its `section` (more)\n\n## Its section\n", encoding="utf-8")
    page = document_numbers.limits_page()
    assert "## Sizes\n\n| limit |" in page
    assert "| rows | <!--=bar.a-->3<!--=--> | [Page: Its section](page.md#its-section) |" in page
    assert "| `test_bar` | bar: b <!--=bar.b - - --> | 0.46 | 0.1 | 1 |" in page
    (tmp_path / "page.md").write_text("# Page\n", encoding="utf-8")
    with pytest.raises(ValueError, match="has no section its-section"):
        document_numbers.limits_page()


def test_limits():
    """In the list of limits each number of a measurement has a mark, so it has one owner."""
    with document_numbers.LIMITS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 40
    bare = {row["limit"]: re.findall(r"\d+\.\d+|\d+ %", re.sub(r"<!--=.*?-->.*?<!--=-->( %)?|`[^`]*`|\[.*?\)", "",
                                                               row["size"]))
            for row in rows if row["section"] not in ("Scope", "Sizes", "Post-processing")}
    assert {limit: numbers for limit, numbers in bare.items() if numbers} == {}


def test_misses_of_tests():
    """Each known miss of the page is one of its test, and has a value."""
    values = document_numbers.table(document_numbers.MEASURED)
    for name in document_numbers.table(document_numbers.KNOWN):
        assert ".known(" in (ROOT / values[name]["test"]).read_text(encoding="utf-8"), name


def test_pages():
    """Pages and tables agree; if not, run scripts/document_numbers.py."""
    assert len(document_numbers.all_places()) > 1000
    assert document_numbers.faults() == []


def test_tables():
    """Tests named in the table exist and have the tier; records have their conditions, version and date."""
    for name, row in document_numbers.table(document_numbers.MEASURED).items():
        path = ROOT / row["test"]
        assert path.is_file() and name.split(".")[0] == path.stem.removeprefix("test_"), name
        assert row["tier"] in ("full", "long", "page"), name
    for name, row in document_numbers.table(document_numbers.RECORDS).items():
        assert all(row[key] for key in ("conditions", "version", "date")), name
