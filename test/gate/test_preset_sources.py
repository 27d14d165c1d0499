# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Each number of the library of materials has a source that was read, or says that it is a choice.

Would catch a number from memory, an abbreviation of a source that the manual does not explain, and a row of the manual
that no number uses.
"""

import csv
import re

from sources import ROOT

LINE = re.compile(r"^(\w+) = ([^|]+) \| ([^|]+?)(?: \| (.+))?$")
TAG = re.compile(r"\[([a-z0-9]+)\]")
ROW = re.compile(r"^\| `\[([a-z0-9]+)\]` \| ([^|]+) \| ([^|]+) \|$", re.M)
FORBIDDEN = ("memory", "handbook", "judgement", "unknown", "confidence")


def entries():
    """File, number of the line, preset, source of each value."""
    found = []
    for path in sorted((ROOT / "src/material/preset").glob("*.txt")):
        preset = ""
        for number, line in enumerate(path.read_text(encoding="ascii").splitlines(), 1):
            if line.startswith("preset "):
                preset = line.split()[1].rstrip(":")
            elif line and not line.startswith("#"):
                match = LINE.match(line)
                found.append((f"{path.name}:{number}", preset, match.group(3) if match else ""))
    return found


def table():
    """Sources of the manual by their abbreviation."""
    text = (ROOT / "doc/reference/materials.md").read_text(encoding="utf-8")
    rows = ROW.findall(text)
    assert len(rows) == len({row[0] for row in rows}), "a source is listed twice"
    return {tag: (what.strip(), where.strip()) for tag, what, where in rows}


def test_each_number_has_a_source():
    """Fails for a value whose source is missing or from memory."""
    found = entries()
    assert len(found) > 200
    wrong = [f"{place} {preset}: {source}" for place, preset, source in found
             if not (TAG.search(source) or source.startswith("chosen"))
             or any(word in source for word in FORBIDDEN)]
    assert not wrong, "\n".join(wrong)


def test_sources_are_explained():
    """The abbreviations in use and the rows of the manual are the same."""
    used = {tag for _, _, source in entries() for tag in TAG.findall(source)}
    with (ROOT / "test/verify/materials/published.csv").open(encoding="ascii") as file:
        used |= {row["source"] for row in csv.DictReader(line for line in file if not line.startswith("#"))}
    explained = table()
    assert used == set(explained), f"not explained: {used - set(explained)}; not used: {set(explained) - used}"
    assert all(what and where for what, where in explained.values())
