# SPDX-License-Identifier: BSD-3-Clause
"""Scenes that measure themselves: runs, a table in the README of the scene, and a picture.

A scene has a file `measure.py` that makes a `Study` of its runs. Called by a user it runs what has not been run yet,
prints the table, and draws the picture. With --write the table goes into the README, between the lines

    <!-- figures -->
    <!-- end of figures -->

and the picture beside it. With --check the figures of the README are held against those of the runs.
"""
import argparse
import os
import re
from dataclasses import dataclass, field
from pathlib import Path

import scree_post
from scree_post import PostError, study
from scree_post.written import Written

BEGIN, END = "<!-- figures -->", "<!-- end of figures -->"
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")


class Run(Written):
    """A finished run of a scene."""

    def near(self, moment):
        """The snapshot nearest to a time [s]."""
        return scree_post.snapshot(min(self.series, key=lambda frame: abs(frame[0] - moment))[1])

    def error(self, name):
        """An error of the ledger, such as "energy_error" [1]."""
        return self.summary["ledger"][name]


@dataclass
class Table:
    """Heads and rows of texts."""

    heads: list
    rows: list = field(default_factory=list)

    def text(self):
        """As lines of Markdown."""
        lines = [self.heads, ["---"] * len(self.heads), *self.rows]
        return "\n".join("| " + " | ".join(map(str, line)) + " |" for line in lines) + "\n"


class Study:
    """The runs of a scene, what is measured on them, and how it is drawn.

    `cases` gives for each name the deck, relative to the folder of the scene, and values for --set; `tables` makes
    tables of the runs by name; `pictures` gives for each file name what draws it: a function of the runs and of
    pyplot that returns the figure, or None if the runs for it were left out.
    """

    def __init__(self, script, cases, tables, pictures, tolerance=0.02):
        self.folder = Path(script).resolve().parent
        self.cases, self.tables, self.pictures = cases, tables, pictures
        self.tolerance = tolerance

    def main(self):
        """Understand the command line and do what it asks for."""
        scree_post.run(self.work, self.folder.name)

    def work(self):
        """All of it; the exit code."""
        options = self.arguments()
        runs = self.run(options)
        text = "\n".join(table.text() for table in self.tables(runs))
        print(text)
        if options.check:
            return self.check(text)
        for name, draw in self.pictures.items():
            figure = draw(runs, scree_post.pyplot())
            if figure:
                picture = (self.folder if options.write else options.out) / name
                scree_post.save(figure, str(picture), 85)
                print(picture)
        if options.write:
            self.write(text)
        return 0

    def arguments(self):
        """The options."""
        parser = argparse.ArgumentParser(
            description=f"Run what input/{self.folder.name} holds and measure it.")
        parser.add_argument("--scree", metavar="PROGRAM", help="the program (build/bin/scree)")
        parser.add_argument("--out", type=Path, default=Path("out") / self.folder.name,
                            help="folder of the results")
        parser.add_argument("--only", nargs="+", metavar="CASE", help="these cases and no others")
        parser.add_argument("--write", action="store_true",
                            help="renew table and picture in the folder of the scene")
        parser.add_argument("--check", action="store_true",
                            help="hold the README against the runs; exit code 1 if it differs")
        options = parser.parse_args()
        unknown = set(options.only or ()) - set(self.cases)
        if unknown:
            raise PostError(f"no case {min(unknown)}; there are: {', '.join(self.cases)}",
                            scree_post.EXIT_USAGE)
        options.scree, options.out = study.find_program(options.scree), options.out.resolve()
        options.out.mkdir(parents=True, exist_ok=True)
        return options

    def run(self, options):
        """Run the cases that are not there yet; all of them by name."""
        chosen = {name: case for name, case in self.cases.items()
                  if not options.only or name in options.only}
        threads = os.environ.get("OMP_NUM_THREADS") or os.cpu_count() or 1
        for deck in dict.fromkeys(deck for deck, _ in chosen.values()):
            some = [study.Run(values, str(options.out / name), name)
                    for name, (other, values) in chosen.items() if other == deck]
            study.Study(options.scree, (self.folder / deck).resolve(), threads).all(some, 1, refuse_failed)
        return {name: Run(options.out / name, name) for name in chosen}

    def parts(self):
        """README before, between and after the two lines."""
        text = (self.folder / "README.md").read_text(encoding="utf-8")
        if text.count(BEGIN) != 1 or text.count(END) != 1:
            raise PostError(f"{self.folder}/README.md: wants one line {BEGIN} and one line {END}")
        before, rest = text.split(BEGIN)
        return before, *rest.split(END)

    def write(self, text):
        """Renew the table of the README."""
        before, _, after = self.parts()
        (self.folder / "README.md").write_text(f"{before}{BEGIN}\n\n{text}\n{END}{after}",
                                               encoding="utf-8")

    def check(self, text):
        """Numbers of the README against those of the runs."""
        _, told, _ = self.parts()
        wrong = differences(told.strip(), text.strip(), self.tolerance)
        for line in wrong:
            print(f"README.md: {line}")
        print(f"{len(wrong)} differences" if wrong else "README.md tells what the runs show")
        return 1 if wrong else 0


def refuse_failed(run):
    """A scene without one of its runs has no figures."""
    if run.code:
        raise PostError(f"{run.case} ended with exit code {run.code}: {run.reason}", run.code)


def differences(told, found, tolerance):
    """Lines that differ: other words, or numbers off by more than a share. Numbers below 1e-9 are rounding."""
    told, found = told.splitlines(), found.splitlines()
    if len(told) != len(found):
        return [f"{len(told)} lines of figures, the runs make {len(found)}"]
    wrong = []
    for left, right in zip(told, found):
        numbers = [[float(word) for word in NUMBER.findall(line)] for line in (left, right)]
        same = NUMBER.sub("#", left) == NUMBER.sub("#", right) and all(
            abs(a - b) <= tolerance * max(abs(a), abs(b)) or max(abs(a), abs(b)) < 1.0e-9
            for a, b in zip(*numbers))
        if not same:
            wrong.append(f"'{left}' is now '{right}'")
    return wrong
