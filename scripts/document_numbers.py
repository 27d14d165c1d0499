# SPDX-License-Identifier: BSD-3-Clause
"""Numbers of the pages of doc/ that tests measure, and the page of limits, which is made of them.

    python3 scripts/document_numbers.py            write the numbers of the last test runs into the pages
    python3 scripts/document_numbers.py --check    exit code 1 if pages and tables of numbers differ

A test writes each number that it measures to the file measured.jsonl in its working folder below build/test
(test/support/measured.py). The script copies those that a page names to doc/theory/measured.csv, and from there into
the pages; a row of the tier `page` was taken from the page and waits for a run of its test. Numbers that no test
measures are in doc/theory/records.csv, as the page shows them, with the conditions of the measurement, the version of
the program, and the date on which the page was last changed there.

In a page, numbers are between invisible marks, or follow a mark in the row of a table:

    ends with <!--=free_bar.mpm.energy*100-->93<!--=--> times the energy
    | displacement <!--=column.cells_{20,40,80}.displacement--> | 4.3e-3 | 1.5e-3 | 4.9e-4 |

A name begins with that of its test (free_bar for test_free_bar.py), with `record`, or with one of three pages:
speed.block_ddmp.core is the speed of a case in the table of doc/developer/performance_table.md,
accuracy.vortex.ddmp.24 the error of a case in doc/accuracy/accuracy.csv (the name of the problem, of the variant, and
the number of cells, with the first number of particles and cfl = 0.4), and scene.debris_cloud.hole the number between
the marks of that name in the README of a scene, which its measure.py writes. Braces stand for
several names; names are separated by blanks, and `-` skips a number that is not measured. Percentages are measured as
fractions. `abs:NAME` is the absolute value, `NAME*1000` a multiple; a single name `record.NAME` of several numbers
stands for record.NAME.1 and so on. A number keeps the digits and the form that it has in the page.

doc/reference/limits.md is written from doc/reference/limits.csv, a list of limits in which numbers have marks as on a
page, and from the known misses of the tests (`sheet.known`), whose titles and targets are in doc/theory/known.csv.

Only the standard library is needed.
"""
import argparse
import csv
import json
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCUMENTS = ROOT / "doc"
MEASURED, RECORDS = DOCUMENTS / "theory/measured.csv", DOCUMENTS / "theory/records.csv"
SPEEDS = DOCUMENTS / "developer/performance_table.md"
KNOWN = DOCUMENTS / "theory/known.csv"
LIMITS, LIMITS_PAGE = DOCUMENTS / "reference/limits.csv", DOCUMENTS / "reference/limits.md"
ACCURACY = DOCUMENTS / "accuracy/accuracy.csv"
HEADS, KNOWN_HEADS = ("name", "value", "limit", "test", "tier"), ("name", "title", "target")
TOLD = ("record.", "speed.", "scene.", "accuracy.")     # names that no test measures
INLINE = re.compile(r"<!--=([^>]*?\.[^>]*?)-->(?! *\|)(.*?)<!--=-->(\s?%)?", re.S)
ROW = re.compile(r"<!--=([^>]*?\.[^>]*?)--> *\|(.*)$", re.M)
NUMBER = re.compile(r"(?<![\w.^])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w^])")
BRACES = re.compile(r"\{([^{}]*)\}")
ROUND_OFF = 1.0e-10                    # smaller numbers differ between machines
HEAD = """<!-- written by scripts/document_numbers.py from limits.csv and known.csv -->
# Limits and known deviations

This page lists the limits of the program and its known errors. Each number belongs to the page that is linked beside
it, or to a test at the end of this page. `--check` rejects decks with features that exclude each other and reports file
and line.
"""
MISSES = """
## Known misses of the tests

A *known miss* is a target in a test that the program does not meet. The test fails if the size of the value exceeds the
limit, and also if the target is met ([Testing](../developer/testing.md)). Test runs end with their known misses.
"""


@dataclass
class Place:
    """A number of a page, with the name under which it is measured."""

    path: Path
    name: str
    factor: float
    size_only: bool
    signed: bool
    span: tuple
    text: str

    def shown(self, value):
        """A measured value converted to the unit and factor of the page, before rounding."""
        return (abs(value) if self.size_only else value) * self.factor

    def is_rounding(self, value):
        """Whether the text and a measured value are rounding errors."""
        return max(abs(self.shown(value)), abs(float(self.text))) < ROUND_OFF

    def written(self, value):
        """A measured value as text, in the format of the present text."""
        value, mantissa, _, exponent = self.shown(value), *self.text.partition("e")
        digits = len(mantissa.partition(".")[2])
        sign = "+" if self.signed else ""
        if not exponent:
            return f"{value:{sign}.{digits}f}"
        mantissa, exponent = f"{value:{sign}.{digits}e}".split("e")
        return f"{mantissa}e{int(exponent)}"

    def differs(self, value, units=1.0):
        """Whether a measured value and the text differ by more than a given number of units of the last digit."""
        if self.is_rounding(value):
            return False
        value, told = self.shown(value), float(self.text)
        mantissa, _, exponent = self.text.partition("e")
        digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
        return not abs(value - told) <= units * digit * (1.0 + 1.0e-9)


def names_of(words):
    """The names in a mark, with braces expanded."""
    found = []
    for word in words.split():
        texts = [word]
        while any(BRACES.search(text) for text in texts):
            texts = [BRACES.sub(choice, text, count=1) for text in texts
                     for choice in BRACES.search(text)[1].split(",")]
        found += texts
    return found


def numbers_of(path, text, words, start, part, percent):
    """Places of the numbers in a part of a page that begins at `start`."""
    names, found = names_of(words), list(NUMBER.finditer(part))
    line = text.count("\n", 0, start) + 1
    signed = any(number[0].startswith("+") for number in found)
    if len(names) == 1 and len(found) > 1 and names[0].startswith(("record.", "scene.")):
        names = numbered(names[0], len(found))
    if len(names) != len(found):
        raise ValueError(f"{path}:{line}: {len(names)} names for {len(found)} numbers in '{part.strip()}'")
    for name, number in zip(names, found):
        if name == "-":
            continue
        name, _, factor = name.partition("*")
        cell = part[number.end():].split("|")[0].rstrip()
        fraction = (percent or cell.endswith("%")) and not name.removeprefix("abs:").startswith(("record.", "scene."))
        scale = float(factor or 1.0) * (100.0 if fraction else 1.0)
        yield Place(path, name.removeprefix("abs:"), scale, name.startswith("abs:"),
                    signed and not name.startswith("abs:"),
                    (start + number.start(), start + number.end()), number[0])


def places_of(path, text=None):
    """All measured numbers of a page."""
    text = path.read_text(encoding="utf-8") if text is None else text
    found, inside = [], []
    for mark in INLINE.finditer(text):
        inside.append(mark.span())
        found += numbers_of(path, text, mark[1], mark.start(2), mark[2], bool(mark[3]))
    for mark in ROW.finditer(text):
        if not any(first <= mark.start() < last for first, last in inside):
            found += numbers_of(path, text, mark[1], mark.start(2), mark[2], False)
    return sorted(found, key=lambda place: place.span)


def all_places():
    """The measured numbers of all pages."""
    pages = [*sorted(DOCUMENTS.rglob("*.md")), LIMITS, *sorted((ROOT / "input").glob("*/README.md")),
             ROOT / "README.md"]
    return [place for path in pages for place in places_of(path)]


def rewritten(text, places, values):
    """A page with the measured values; numbers without a measured value and rounding errors do not change."""
    for place in reversed(places):
        if place.name in values and not place.is_rounding(values[place.name]):
            text = text[:place.span[0]] + place.written(values[place.name]) + text[place.span[1]:]
    return text


def table(path):
    """Rows of a table of numbers by name."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {row["name"]: row for row in csv.DictReader(file)}


def speeds():
    """Speeds of the table of scree-bench by case, for names such as speed.block_ddmp.core [million updates/s]."""
    rows = re.findall(r"^\| (\w+) \| ([\d.]+) \| ([\d.]+) \|", SPEEDS.read_text(encoding="utf-8"), re.M)
    return {f"speed.{case}.{column}": float(value) for case, *values in rows
            for column, value in zip(("core", "wall"), values)}


def scenes():
    """Numbers of the READMEs of the scenes, for names such as scene.debris_cloud.hole; several numbers in one mark
    have names with .1, .2 and so on."""
    found = {}
    for path in sorted((ROOT / "input").glob("*/README.md")):
        for name, text in re.findall(r"<!--=(\w+)-->(.*?)<!--=-->", path.read_text(encoding="utf-8"), re.S):
            several = [float(number) for number in NUMBER.findall(text)]
            found |= dict(zip(numbered(f"scene.{path.parent.name}.{name}", len(several)), several))
    return found


def numbered(name, count):
    """The names of several numbers with a common name."""
    return [name] if count == 1 else [f"{name}.{number}" for number in range(1, count + 1)]


def errors():
    """Errors of the study of accuracy and cost, for names such as accuracy.vortex.ddmp.24."""
    found = {}
    with ACCURACY.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            if row["error"] and row["cfl"] == "0.4":
                found.setdefault(f"accuracy.{row['problem']}.{row['way'].replace(' ', '_')}.{row['cells']}",
                                 float(row["error"]))
    return found


def known_values():
    """All values by name; a record of several values has names with .1, .2 and so on."""
    values = {name: float(row["value"]) for name, row in table(MEASURED).items()}
    for name, row in table(RECORDS).items():
        words = row["values"].split()
        values.update(zip(numbered(name, len(words)), map(float, words)))
    return {**speeds(), **scenes(), **errors(), **values}


def results(folder):
    """Measured values of the test runs below a folder, as rows by name. A later run takes precedence over an earlier
    one, and tier full over tier long."""
    found = {}
    for path in sorted(folder.rglob("measured.jsonl"), key=lambda path: path.stat().st_mtime):
        for line in path.read_text(encoding="utf-8").splitlines():
            row = json.loads(line)
            own = row["test"].startswith("test/")    # not a test of the harness
            if own and row["tier"] != "smoke" and not (row["tier"] == "long" and row["name"] in found
                                                       and found[row["name"]]["tier"] == "full"):
                found[row["name"]] = row
    return found


def write(folder):
    """Copy the numbers of test runs to the table and the pages. Returns lines about numbers without a measured
    value."""
    measured, new = table(MEASURED), results(folder)
    known = write_known(new, measured)
    places = all_places()
    names = {place.name for place in places if not place.name.startswith(TOLD)} | set(known)
    rows = {name: new.get(name, measured.get(name)) for name in names}
    with MEASURED.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, HEADS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for name in sorted(name for name in names if rows[name]):
            row = rows[name]
            writer.writerow({**row, "value": f"{float(row['value']):.5g}",
                             "limit": f"{float(row['limit']):.4g}" if row["limit"] not in (None, "") else ""})
    values = known_values()
    for path in {place.path for place in places} - {LIMITS_PAGE}:
        text = path.read_text(encoding="utf-8")
        path.write_text(rewritten(text, places_of(path, text), values), encoding="utf-8")
    LIMITS_PAGE.write_text(limits_page(), encoding="utf-8")
    places = all_places()
    return sorted(f"{place.path.relative_to(ROOT)}: no value for {place.name}" for place in places
                  if place.name not in values)


def write_known(new, measured):
    """Update the table of known misses from test runs. Returns its rows by name. A test that was run and no longer has
    a miss removes it."""
    known = table(KNOWN)
    ran = {(row["test"], row["tier"]) for row in new.values()}
    for name in [name for name in known if name not in measured
                 or (measured[name]["test"], measured[name]["tier"]) in ran and "target" not in new.get(name, {})]:
        del known[name]
    known.update({name: row for name, row in new.items() if "target" in row})
    with KNOWN.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, KNOWN_HEADS, extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for name in sorted(known):
            writer.writerow({**known[name], "target": f"{float(known[name]['target']):.4g}"})
    return known


def title_of(path, anchor):
    """The heading of a page, and that of one of its sections."""
    heads = [re.sub(r"[`*]", "", head) for head in re.findall(r"^#+ (.*)$", path.read_text(encoding="utf-8"), re.M)]
    anchors = {re.sub(r"[^\w -]", "", head).strip().lower().replace(" ", "-"): head for head in heads}
    if anchor and anchor not in anchors:
        raise ValueError(f"{LIMITS}: {path} has no section {anchor}")
    section = re.sub(r" \(.*\)$", "", anchors[anchor]) if anchor else ""
    return ": ".join(filter(None, (heads[0], section)))


def link(owner):
    """A link to the page that owns a limit, or nothing."""
    path, _, anchor = owner.partition("#")
    return f"[{title_of(LIMITS.parent / path, anchor)}]({owner})" if owner else ""


def limits_page():
    """The page of limits."""
    with LIMITS.open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    text = HEAD
    for section in dict.fromkeys(row["section"] for row in rows):
        text += f"\n## {section}\n\n| limit | size, or what to do | page |\n|---|---|---|\n"
        text += "".join(f"| {row['limit']} | {row['size']} | {link(row['owner'])} |\n".replace("|  |", "| |")
                        for row in rows if row["section"] == section)
    measured, known = table(MEASURED), table(KNOWN)
    text += MISSES + "\n| test | known miss | value | target | limit |\n|---|---|---|---|---|\n"
    for name in sorted(known, key=lambda name: (measured[name]["test"], name)):
        value, limit = (float(measured[name][key]) for key in ("value", "limit"))
        title = known[name]["title"].replace("|", "/")
        text += (f"| `{Path(measured[name]['test']).stem}` | {title} <!--={name} - - --> | {value:.2g} "
                 f"| {float(known[name]['target']):.4g} | {limit:.4g} |\n")
    return text


def faults():
    """Differences between pages and tables."""
    places, values = all_places(), known_values()
    found = [f"{place.path.relative_to(ROOT)}: {place.name} has no value" for place in places
             if place.name not in values]
    found += [f"{place.path.relative_to(ROOT)}: {place.name} is {place.shown(values[place.name]):.5g}, not {place.text}"
              for place in places if place.name in values and place.differs(values[place.name], 0.51)]
    if LIMITS_PAGE.read_text(encoding="utf-8") != limits_page():
        found.append(f"{LIMITS_PAGE.relative_to(ROOT)} is not what {Path(__file__).name} writes")
    unused = set(values) - set(speeds()) - set(scenes()) - set(errors()) - {place.name for place in places}
    found += [f"{name} is in a table of numbers and in no page" for name in unused]
    return sorted(found)


def main():
    """Execute the command."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="only compare; exit code 1 if they differ")
    parser.add_argument("--results", type=Path, default=ROOT / "build/test", metavar="FOLDER",
                        help="working folders of the tests (default: build/test)")
    options = parser.parse_args()
    lines = faults() if options.check else write(options.results)
    print("\n".join([*lines, f"{len(all_places())} numbers, {len(lines)} without a current value"]))
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
