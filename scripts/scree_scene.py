# SPDX-License-Identifier: BSD-3-Clause
"""Runs and measurements of a scene: tables and numbers in the README of the scene, and pictures.

The file `measure.py` of a scene defines a `Study` of its runs. When called, it makes the runs that have no results yet,
prints the tables, and draws the pictures. The last table is the verdict of the program on its runs, `trust` of their
summaries. With --write the tables are written to the README, between the lines

    <!-- figures -->
    <!-- end of figures -->

and the pictures to the same folder. Any other number from the runs, in the README or another document, is between
invisible marks: <!--=hole-->17.5<!--=--> mm. --write replaces it by the value of that name; --check compares tables
and numbers with the runs. The text around a number can be changed freely.
"""
import argparse
import math
import re
from dataclasses import dataclass, field
from pathlib import Path

import scree_post
from scree.errors import ScreeError
from scree import program, results, study
from scree.quantities import value_of

WIDE = 1800                            # pixels of a picture
TIMES = ("seconds", "seconds_all")     # names of the processor times of the unchanged deck and of all runs [s]
VERDICTS = ("bad", "check", "ok")      # of the program on a run, the worst first
BEGIN, END = "<!-- figures -->", "<!-- end of figures -->"
MARKED = re.compile(r"<!--=(\w+)-->(.*?)<!--=-->", re.S)
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


class Run:
    """A finished run of a scene."""

    def __init__(self, folder, case):
        self.folder, self.case, self.results = Path(folder), case, results.Run(folder, case)

    @property
    def summary(self):
        """The content of CASE.summary.json."""
        return self.results.summary

    @property
    def history(self):
        """The first history, or None if the deck writes none."""
        name = self.file_of("history")
        return scree_post.history(str(self.folder / name)) if name else None

    @property
    def series(self):
        """Times [s] and files of the first particle output, or None."""
        name = self.file_of("particles")
        return scree_post.series(str(self.folder / name)) if name else None

    def file_of(self, kind):
        """The first output of a kind, or None."""
        files = self.summary.get("files", {})
        return next((files[key] for key in sorted(files) if key.startswith(kind)), None)

    def last_snapshot(self):
        """The last snapshot of the first particle output, or None."""
        series = self.series
        return scree_post.snapshot(series[-1][1]) if series else None

    def value(self, quantity, body=None, percentile=100.0):
        """The number of a quantity; the error for an unknown name lists all quantities."""
        return value_of(self.results, quantity, body, percentile)

    def near(self, moment):
        """The snapshot nearest to a time [s]."""
        return scree_post.snapshot(min(self.series, key=lambda frame: abs(frame[0] - moment))[1])

    @property
    def verdict(self):
        """The verdict of the program on the run, and the entries with their values that are the reason."""
        trust = self.summary["trust"]
        entries = {name: entry for name, entry in trust.items() if isinstance(entry, dict)}
        return trust["verdict"], {name: entry["value"] for name, entry in entries.items() if entry["verdict"] != "ok"}

    def error(self, name):
        """An error of the ledger, such as "energy_error" [1]."""
        return self.summary["ledger"][name]

    @property
    def code(self):
        """The exit code; it can differ from 0 only for cases in `may_fail`."""
        return self.summary["exit_code"]


@dataclass
class Table:
    """A table: headings and rows of texts."""

    heads: list
    rows: list = field(default_factory=list)

    def text(self):
        """The table in Markdown."""
        lines = [self.heads, ["---"] * len(self.heads), *self.rows]
        return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


def cell_of(settings):
    """The size of cells in the settings of a run, for an order by size; runs with that of the deck are the last."""
    try:
        return float(settings["grid.dx"])
    except (KeyError, TypeError, ValueError):
        return math.inf


class Study:
    """The runs of a scene, the quantities measured in them, and the functions that draw them.

    `cases` gives for each name the deck, relative to the folder of the scene, and values for --set; `tables` makes
    tables of the runs by name; `pictures` gives for each file name what draws it: a function of the runs and of
    pyplot that returns the figure, or None if the runs for it were left out. `numbers` gives for each document,
    relative to the folder, a function of the runs that returns the texts of its marked numbers by name. `may_fail`
    gives the exit code of cases whose failure is a result. `as_it_stands` is the case that is the deck as it stands,
    if its values are not empty.
    """

    def __init__(self, script, cases, tables, pictures, *, numbers=None, may_fail=None, as_it_stands=None,
                 tolerance=0.02):
        self.folder = Path(script).resolve().parent
        self.cases, self.tables, self.pictures = cases, tables, pictures
        self.numbers, self.may_fail, self.tolerance = numbers or {}, may_fail or {}, tolerance
        self.as_it_stands = as_it_stands or next((name for name, (_, values) in cases.items() if not values), None)

    def main(self):
        """Evaluate the command line and execute it."""
        scree_post.run(self.work, self.folder.name)

    def work(self):
        """Execute the study. Returns the exit code."""
        options = self.arguments()
        runs = self.run(options)
        if options.pictures:
            return self.draw(runs, self.folder)
        text = "\n".join(table.text() for table in [*self.tables(runs), verdicts(runs)])
        print(text)
        if options.check:
            return self.check(self.documents(runs, text))
        documents = self.documents(runs, text, self.times(runs)) if options.write else {}
        self.draw(runs, self.folder if options.write else options.out)
        for path, (_, now) in documents.items():
            path.write_text(now, encoding="utf-8")
        return 0

    def draw(self, runs, folder):
        """Draw the pictures into a folder. Returns the exit code."""
        for name, draw in self.pictures.items():
            figure = draw(runs, scree_post.pyplot())
            if figure:
                picture = folder / name
                scree_post.save(figure, str(picture), WIDE / figure.get_figwidth())
                scree_post.make_small(picture)
                print(picture)
        return 0

    def arguments(self):
        """The options."""
        parser = argparse.ArgumentParser(
            description=f"Run the decks of input/{self.folder.name} and measure the results.")
        parser.add_argument("--scree", metavar="PROGRAM", help="path of the program (build/bin/scree)")
        parser.add_argument("--out", type=Path, default=Path("out") / self.folder.name,
                            help="folder for the results")
        parser.add_argument("--only", nargs="+", metavar="CASE", help="run only these cases")
        parser.add_argument("--write", action="store_true",
                            help="update the tables, numbers and pictures of the scene")
        parser.add_argument("--pictures", action="store_true",
                            help="update only the pictures of the scene; with --only those that need no other cases")
        parser.add_argument("--check", action="store_true",
                            help="compare tables and numbers with the runs; exit code 1 if they differ")
        options = parser.parse_args()
        if options.only and (options.write or options.check):
            raise ScreeError("--only leaves out runs that --write and --check need", scree_post.EXIT_USAGE)
        unknown = set(options.only or ()) - set(self.cases)
        if unknown:
            raise ScreeError(f"no case {min(unknown)}; there are: {', '.join(self.cases)}",
                            scree_post.EXIT_USAGE)
        options.scree, options.out = program.find_program(options.scree), options.out.resolve()
        options.out.mkdir(parents=True, exist_ok=True)
        return options

    def run(self, options):
        """Make the runs that have no results yet. Returns all runs by name."""
        chosen = {name: case for name, case in self.cases.items()
                  if not options.only or name in options.only}
        threads = program.threads_of_a_run()
        for deck in dict.fromkeys(deck for deck, _ in chosen.values()):
            some = [study.Combination(values, str(options.out / name), name)
                    for name, (other, values) in chosen.items() if other == deck]
            some.sort(key=lambda one: cell_of(one.settings))     # the longest run does not begin last
            study.Study((self.folder / deck).resolve(), program=options.scree, threads=threads, overwrite=True).all(
                some, program.jobs_for(threads), self.refuse_failed)
        return {name: Run(options.out / name, name) for name in chosen}

    def refuse_failed(self, run):
        """Raise an error if a run failed, unless its exit code is in `may_fail`: without this run the tables cannot be
        written."""
        if run.code not in (0, self.may_fail.get(run.case, 0)):
            raise ScreeError(f"{run.case} ended with exit code {run.code}: {run.reason}", run.code)

    def documents(self, runs, text, times=None):
        """For each path the present text of the document, and the text with tables and numbers of the runs."""
        found = {}
        for name in {"README.md": None, **self.numbers}:
            path = (self.folder / name).resolve()
            told = path.read_text(encoding="utf-8")
            values = self.numbers[name](runs) if name in self.numbers else {}
            now = told
            if name == "README.md":
                now = with_tables(path, told, text)
                values = {**values, **(times or dict.fromkeys(TIMES))}
            found[path] = told, with_numbers(path, now, values)
        return found

    def times(self, runs):
        """Processor times of the runs as numbers of the README. They differ from run to run, so --check does not
        compare them."""
        worked = {name: run.summary["processor_s"] for name, run in runs.items()}
        first = worked.get(self.as_it_stands, 0.0)
        return dict(zip(TIMES, (two_digits(first), two_digits(sum(worked.values())))))

    def check(self, documents):
        """Compare the numbers of the documents with those of the runs."""
        number = 0
        for path, texts in documents.items():
            for line in differences(*texts, self.tolerance):
                print(f"{path.name}: {line}")
                number += 1
        print(f"{number} differences" if number else "all figures are those of the runs")
        return 1 if number else 0


def verdicts(runs):
    """The verdict of the program on the runs: the worst first, runs with the same reasons together, and for each
    reason the least and the greatest value."""
    found = {}
    for name, run in runs.items():
        verdict, reasons = run.verdict
        found.setdefault((verdict, tuple(reasons)), []).append((name, reasons))
    table = Table(["verdict of the program", "because of", "runs"])
    for (verdict, names), same in sorted(found.items(), key=lambda item: VERDICTS.index(item[0][0])):
        values = {name: sorted({f"{reasons[name]:.2g}" for _, reasons in same}, key=float) for name in names}
        table.rows.append([verdict, ", ".join(f"{name} {' to '.join(dict.fromkeys((few[0], few[-1])))}"
                                              for name, few in values.items()),
                           "all" if len(found) == 1 and len(runs) > 1 else ", ".join(f"`{name}`" for name, _ in same)])
    return table


def with_tables(path, text, tables):
    """The document with another text between the two marks of the tables."""
    if text.count(BEGIN) != 1 or text.count(END) != 1:
        raise ScreeError(f"{path}: wants one line {BEGIN} and one line {END}")
    before, rest = text.split(BEGIN)
    return f"{before}{BEGIN}\n\n{tables}\n{END}{rest.split(END)[1]}"


def with_numbers(path, text, values):
    """The document with other texts in its marks, by name; the value None means no change.

    The marks and the names must agree, except that marks of times may be absent.
    """
    marked = {name for name, _ in MARKED.findall(text)}
    unmarked, unknown = set(values) - marked - set(TIMES), marked - set(values)
    for kind, names in (("no mark", unmarked), ("a mark without a value", unknown)):
        if names:
            raise ScreeError(f"{path}: {kind} for the number '{min(names)}'; marks are <!--=NAME-->...<!--=-->")

    def renewed(found):
        value = values[found[1]]
        return found[0] if value is None else f"<!--={found[1]}-->{value}<!--=-->"

    return MARKED.sub(renewed, text)


def two_digits(value):
    """A positive number as text with two significant digits."""
    return f"{float(f'{value:.2g}'):g}"


def differences(told, found, tolerance):
    """Lines that differ: in their words, or in numbers by more than the relative tolerance. Numbers below 1e-9 are
    rounding errors."""
    told, found = told.splitlines(), found.splitlines()
    if len(told) != len(found):
        return [f"{len(told)} lines, {len(found)} with the figures of the runs"]
    wrong = []
    for left, right in zip(told, found):
        numbers = [[float(word) for word in NUMBER.findall(line)] for line in (left, right)]
        same = NUMBER.sub("#", left) == NUMBER.sub("#", right) and all(
            abs(a - b) <= tolerance * max(abs(a), abs(b)) or max(abs(a), abs(b)) < 1.0e-9
            for a, b in zip(*numbers))
        if not same:
            wrong.append(f"'{left}' is now '{right}'")
    return wrong
