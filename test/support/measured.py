# SPDX-License-Identifier: BSD-3-Clause
"""Record the numbers that a test measures, and compare them with the pages that show them.

    import measured
    measured.record("default, 10 cells", {"energy": -4.2e-4, "displacement": 5.9e-4})
    measured.record("run-out", 1.36, limit=1.5)

All checks of a sheet (report.py) are recorded as well. The name of a number consists of the name of the test file, the
text, and the key: spin.default_10_cells.energy. At the end of a test its numbers are written to measured.jsonl in the
folder of the tests, and numbers that a page of doc/ names (scripts/document_numbers.py) must agree with the page, to
one unit of its last digit.
"""

import functools
import json
import math
import numbers
import re

import document_numbers
import tier

ROWS, STEM = [], [""]


def begin(stem):
    """Start recording for another test file."""
    STEM[0] = stem.removeprefix("test_")


def slug(text):
    """A text converted to a name."""
    words = re.sub(r"-{2,}", "-", re.sub(r"[^a-z0-9.+-]+", "_", text.lower()))
    return re.sub(r"_*\._*", ".", words).strip("_")


def record(what, value, limit=None, target=None):
    """Record a number, or several by key; numbers that are not finite are left out. A known miss has a target."""
    if isinstance(value, dict):
        for key, number in value.items():
            record(f"{what}.{slug(str(key))}", number, limit)
        return
    try:
        value = float(value)
    except (TypeError, ValueError):
        return
    if math.isfinite(value):
        ROWS.append({"name": f"{STEM[0]}.{slug(what)}", "value": value,
                     "limit": None if limit is None else float(limit), "tier": tier.NAME,
                     **({} if target is None else {"target": float(target), "title": what})})


def recorded(run):
    """A decorator for a function run(options, name, ...) that returns a dictionary, whose numbers are recorded under
    that name."""
    @functools.wraps(run)
    def wrapped(options, name, *words, **more):
        result = run(options, name, *words, **more)
        record(name, result)
        return result
    return wrapped


def show(what, values):
    """Record numbers by key and print them in a line."""
    record(what, values)
    print(f"         {what}: " + ", ".join(f"{key} {float(value):+.3g}" for key, value in values.items()
                                           if isinstance(value, numbers.Real)), flush=True)


def taken():
    """The numbers recorded since the last call."""
    rows, ROWS[:] = ROWS[:], []
    return rows


def save(rows, path, test):
    """Append numbers to a file."""
    with path.open("a", encoding="utf-8") as file:
        file.writelines(json.dumps({**row, "test": test}) + "\n" for row in rows)


@functools.lru_cache(maxsize=None)
def shown():
    """The positions at which pages show a number, by its name."""
    found = {}
    for place in document_numbers.all_places():
        found.setdefault(place.name, []).append(place)
    return found


def compared(name):
    """True if a number of this tier must agree with the page; runs of another tier may differ."""
    row = document_numbers.table(document_numbers.MEASURED).get(name, {"tier": "page"})
    return tier.NAME == row["tier"] or row["tier"] == "page" and tier.NAME != "smoke"


def differences(rows):
    """Differences between measured numbers and pages. A name that a page shows must not be used for two values."""
    wrong = []
    for name in filter(compared, sorted({row["name"] for row in rows} & set(shown()))):
        values = [row["value"] for row in rows if row["name"] == name]
        if max(values) != min(values):
            wrong.append(f"{name} is measured twice: {min(values):.6g} and {max(values):.6g}")
        wrong += [f"{place.path.name} says {place.text} for {name}, which is {place.shown(value):.6g}"
                  for place in shown()[name] for value in values[-1:] if place.differs(value)]
    return wrong


def is_recorded(test):
    """True if numbers of a test were recorded in this tier. A study of the tier long may never have been."""
    return any(row["test"] == test and row["tier"] == tier.NAME
               for row in document_numbers.table(document_numbers.MEASURED).values())


def misses(rows, test):
    """Known misses of a test that the page of limits does not list, or lists with another target."""
    known, wrong = document_numbers.table(document_numbers.KNOWN), []
    for row in rows if tier.NAME == "full" or tier.NAME == "long" and is_recorded(test) else ():
        name, told = row["name"], known.get(row["name"])
        if "target" not in row:
            if told and compared(name):
                wrong.append(f"limits.md lists {name}, which is no longer a known miss")
        elif told is None:
            wrong.append(f"limits.md does not list the known miss {name}")
        elif f"{row['target']:.4g}" != told["target"]:
            wrong.append(f"limits.md says {told['target']} for the target of {name}, which is {row['target']:.4g}")
    return wrong


def missing(names, test):
    """Numbers that pages show as measured by a test in this tier and that the test did not measure."""
    return sorted(name for name, row in document_numbers.table(document_numbers.MEASURED).items()
                  if row["test"] == test and row["tier"] == tier.NAME and name not in names)
