#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Change one place of the sources at a time and see whether a test fails.

    build/venv/bin/python scripts/mutate.py prepare             # copy, build, record which test executes which line
    build/venv/bin/python scripts/mutate.py run                 # try all mutants that have no row in the table yet
    build/venv/bin/python scripts/mutate.py run --again survived
    build/venv/bin/python scripts/mutate.py run --list test/mutants/by_hand.txt
    build/venv/bin/python scripts/mutate.py list                # print the mutants and try none
    build/venv/bin/python scripts/mutate.py summary             # counts by folder of src/

A mutant is the program with one operator, sign, index, comparison or constant changed in the body of a procedure.
Mutants are drawn from all folders of src/; the same sources and the same --seed give the same mutants. Everything is
done in a copy of the project (build/mutants), which needs 3 GB; the user's files and build are only read.

A mutant is compiled alone and linked before the libraries of the copy. Only tests that execute the changed line are
run: first the unit test of the module, then the other unit tests of its folder, those of other folders, and tests in
Python of the tier smoke, the quick ones first, until one fails. The tests beyond the folder stop when their recorded
costs exceed --budget. Tests named in a list of mutants are always run. Each process gets a limit of processor time,
so an endless loop ends. A row of the table has one of these outcomes:

    killed            a test fails that passes without the change
    timed out         a test did not end; counted as killed
    does not compile  not counted
    equivalent        the compiler makes the same code; not counted
    survived          the note says whether the digests of some decks of input/ differ after 40 steps

The table is written after each mutant, so an interrupted run continues. Several runs may work on one table.
"""
import argparse
import csv
import fcntl
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter, defaultdict
from pathlib import Path
from typing import Dict, Iterable, List, Optional, Sequence, Set, Tuple

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "scripts")]
from mutants import places  # noqa: E402
from mutants.places import Mutant  # noqa: E402
from mutants.workshop import PROGRAMS, Test, Workshop  # noqa: E402

COLUMNS = ("place", "before", "after", "kind", "outcome", "by", "seconds", "tests", "note")
LONGEST = {"unit": 0.0, "smoke": 19.0, "full": 31.5}     # longest recorded duration of a Python test that is used [s]
# Tests of the Python package and of the installation, which are not used.
NOT_OF_PROGRAM = re.compile(r"install|speed_bench|test_post_|damaged_series|message_codes")
# limit of the processor time of a test: constant part [s], and factor of its recorded duration
CPU = (20.0, 10.0)
Row = Dict[str, str]


class Coverage:
    """The lines that each test executes."""

    def __init__(self) -> None:
        self.tests: Dict[Tuple[str, int], List[str]] = defaultdict(list)

    def add(self, test: str, lines: Dict[str, List[int]]) -> None:
        """Store the executed lines of one test."""
        for file, numbers in lines.items():
            for number in numbers:
                self.tests[file, number].append(test)

    def of(self, mutant: Mutant, lines: Sequence[str], counted: Set[int]) -> List[str]:
        """Tests that execute the statement of a mutant. The compiler has no counter for some assignments of constants;
        for these the tests of the next lines with a counter are returned."""
        first = last = mutant.line
        while lines[first - 2].rstrip().endswith("&"):
            first -= 1
        while lines[last - 1].rstrip().endswith("&"):
            last += 1
        if not counted & set(range(first, last + 1)):
            first = max((number for number in counted if number < first), default=first)
            last = min((number for number in counted if number > last), default=last)
        return sorted({test for number in range(first, last + 1) for test in self.tests.get((mutant.file, number), ())})


def used_tests(shop: Workshop, tier: str) -> List[Test]:
    """Unit tests, and tests of a tier with a short duration."""
    return [test for test in shop.tests.values() if test.is_unit or test.labels & {"smoke", tier}
            and test.cost <= LONGEST[tier] and not NOT_OF_PROGRAM.search(test.name)]


def layer_of(shop: Workshop, test: Test) -> str:
    """Folder of test/unit that contains a unit test; an empty text for other tests."""
    found = list(shop.source.glob(f"test/unit/*/{test.name}.pf"))
    return found[0].parent.name if found else ""


def in_order(shop: Workshop, mutant: Mutant, names: Iterable[str]) -> List[Test]:
    """Tests in the order in which they run: the most likely to fail and the quickest first; tests that a list names
    follow the unit tests."""
    def rank(test: Test) -> Tuple[int, float, str]:
        if test.is_unit:
            words = set(mutant.module.split("_")) & set(test.name.split("_")[1:])
            same = test.name == f"test_{mutant.module}"
            return (0 if same else 1 if layer_of(shop, test) == mutant.layer else 2, -len(words), test.name)
        return (3 if test.name in mutant.hints else 4, test.cost, test.name)
    return sorted((shop.tests[name] for name in {*names, *mutant.hints}), key=rank)


def cpu_limit(test: Test) -> float:
    """Limit of the processor time of each process of a test [s]."""
    return CPU[0] + CPU[1] * test.cost


class Trial:
    """Tests mutants, and stores which tests pass without a change."""

    def __init__(self, shop: Workshop, coverage: Coverage, options: argparse.Namespace) -> None:
        self.shop, self.coverage, self.budget, self.closer = shop, coverage, options.budget, not options.quick
        self.sound: Dict[str, bool] = {}
        self.digests: Dict[str, str] = {}

    def passes(self, test: Test) -> bool:
        """True if the test passes without a change; it is run only once."""
        if test.name not in self.sound:
            folder = self.shop.scratch / "sound"
            for program in test.programs:
                self.shop.link(program, folder)
            self.sound[test.name] = self.shop.try_test(test, folder, cpu_limit(test)).code in (0, 77)
            if not self.sound[test.name]:
                print(f"    {test.name} fails without a change and is left out", flush=True)
        return self.sound[test.name]

    def judge(self, mutant: Mutant) -> Row:
        """Test one mutant. Returns its row of the table."""
        begin = time.time()
        row = {"place": mutant.place, "before": mutant.before.strip(), "after": mutant.after.strip(),
               "kind": mutant.kind, "by": "", "tests": "0", "note": ""}
        lines = (self.shop.source / mutant.file).read_text(encoding="utf-8").split("\n")
        assert lines[mutant.line - 1] == mutant.before, f"{mutant.place}: the copy is old; run `prepare`"
        changed = "\n".join([*lines[:mutant.line - 1], mutant.after, *lines[mutant.line:]])
        made, errors = self.shop.compile(mutant, changed)
        if made is None:
            row.update(outcome="does not compile", note=next((line for line in errors.splitlines()
                                                              if line.startswith(("Error", "Fatal"))), ""))
        else:
            self.try_tests(mutant, made, lines, row)
            if row["outcome"] == "survived" and row["tests"] != "0" and self.closer:
                self.look_closer(mutant, made, lines, row)
        row["seconds"] = f"{time.time() - begin:.1f}"
        return row

    def try_tests(self, mutant: Mutant, made: Path, lines: Sequence[str], row: Row) -> None:
        """Run tests until one fails, and enter the result into the row."""
        tests = in_order(self.shop, mutant, self.coverage.of(mutant, lines, self.shop.counted_lines(mutant.file)))
        spent, linked, number = 0.0, set(), 0
        row["outcome"] = "survived"
        folder = self.shop.scratch / "bin"
        for test in tests:
            if not (test.is_unit and layer_of(self.shop, test) == mutant.layer) and test.name not in mutant.hints:
                spent += test.cost
                if spent > self.budget:
                    row["note"] = f"tests left out: {len(tests) - number}; "
                    break
            for program in test.programs:
                if program not in linked:
                    self.shop.link(program, folder, made, mutant.file)
                    linked.add(program)
            ended = self.shop.try_test(test, folder, cpu_limit(test))
            number += 1
            if ended.code not in (0, 77) and self.passes(test):
                row.update(outcome="timed out" if ended.late else "killed", by=test.name)
                break
        row["tests"] = str(number)
        if not tests:
            row["note"] = "no test executes the line"

    def look_closer(self, mutant: Mutant, made: Path, lines: Sequence[str], row: Row) -> None:
        """Compare code and digests of a mutant that passed all tests with those of the original program."""
        changed = made.rename(self.shop.scratch / "kept.o")
        same, _ = self.shop.compile(mutant, "\n".join(lines))
        if same is not None and same.read_bytes() == changed.read_bytes():
            row.update(outcome="equivalent", note="the compiler makes the same code")
            return
        decks = sorted(self.shop.source.glob("input/*/scene.nml"))[::2]
        if not self.digests:
            for program in PROGRAMS:
                self.shop.link(program, self.shop.scratch / "sound")
            self.digests = self.shop.digests(self.shop.scratch / "sound", decks)
        self.shop.link("scree", self.shop.scratch / "bin", changed, mutant.file)
        now = self.shop.digests(self.shop.scratch / "bin", decks)
        differ = [name.split("/")[1] for name in now if now[name] != self.digests[name]]
        row["note"] += "digest differs: " + " ".join(differ) if differ else "digests are the same"


def key_of(row: Row) -> Tuple[str, str]:
    """The values that identify a mutant."""
    return row["place"], row["after"]


class Table:
    """The rows of all mutants, in a file that several runs may share."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def rows(self) -> List[Row]:
        """All rows; for a mutant that was tried several times, only the last one."""
        return list({key_of(row): row for row in self.lines()}.values())

    def lines(self) -> List[Row]:
        """All rows in the order of the file."""
        if not self.path.is_file():
            return []
        with self.path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def add(self, row: Row) -> None:
        """Append a row."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with self.path.open("a", encoding="utf-8", newline="") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            writer = csv.DictWriter(file, COLUMNS)
            if file.tell() == 0:
                writer.writeheader()
            writer.writerow(row)

    def claim(self, mutant: Mutant) -> bool:
        """True if no other run is trying this mutant."""
        path = self.path.with_suffix(".claims")
        name = f"{mutant.place} {mutant.after.strip()}"
        with path.open("a+", encoding="utf-8") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            file.seek(0)
            claims = dict(line.rstrip("\n").split(" ", 1)[::-1] for line in file)
            if name in claims and int(claims[name]) != os.getpid() and Path(f"/proc/{claims[name]}").is_dir():
                return False
            file.write(f"{os.getpid()} {name}\n")
            return True


def summary(rows: Sequence[Row]) -> str:
    """A table in Markdown of the outcomes by folder of src/."""
    counts: Dict[str, Counter[str]] = defaultdict(Counter)
    for row in rows:
        for layer in (row["place"].split("/")[1], "all"):
            counts[layer][row["outcome"]] += 1
    text = ["| folder | mutants | killed | timed out | survived | equivalent | do not compile | killed [%] |",
            "|---|--:|--:|--:|--:|--:|--:|--:|"]
    for layer in sorted(counts, key=lambda name: (name == "all", name)):
        count = counts[layer]
        found = count["killed"] + count["timed out"]
        share = f"{100.0 * found / (found + count['survived']):.0f}" if found + count["survived"] else ""
        text.append(f"| {layer} | {sum(count.values())} | {count['killed']} | {count['timed out']} | "
                    f"{count['survived']} | {count['equivalent']} | {count['does not compile']} | {share} |")
    return "\n".join(text)


def prepare(shop: Workshop, options: argparse.Namespace) -> None:
    """Bring the copy up to date, and record the lines that each test executes."""
    shop.copy()
    shop.make()
    shop.load()
    shop.make_coverage()
    end = time.time() + 60.0 * options.minutes
    for test in sorted(used_tests(shop, options.tier), key=lambda test: (not test.is_unit, test.cost)):
        if time.time() > end:
            sys.exit("the time is over; call `prepare` again")
        try:
            lines = shop.covered_by(test)
        except subprocess.CalledProcessError as error:
            sys.exit(f"{test.name}: {error.stderr}")
        print(f"{test.name}: {sum(map(len, lines.values()))} lines", flush=True)


def chosen(options: argparse.Namespace, source: Path) -> List[Mutant]:
    """The mutants of a list, or the random selection by the seed."""
    if options.list is not None:
        return places.read_list(source, options.list)
    return places.choose(source, options.count, options.least, options.seed)


def run(shop: Workshop, options: argparse.Namespace) -> None:
    """Try the mutants that have no row yet."""
    shop.load()
    coverage = Coverage()
    names = {test.name for test in used_tests(shop, options.tier)}
    for file in (shop.cover / "lines").glob("*.json"):
        kept = json.loads(file.read_text(encoding="utf-8"))
        if kept["test"] in names and not (options.no_unit and shop.tests[kept["test"]].is_unit):
            coverage.add(kept["test"], kept["lines"])
    trial, table = Trial(shop, coverage, options), Table(options.table)
    before = table.lines()
    done = {key_of(row) for row in table.rows() if row["outcome"] != options.again}
    mutants, end = chosen(options, shop.source), time.time() + 60.0 * options.minutes
    for number, mutant in enumerate(mutants, 1):
        if time.time() > end:
            sys.exit("the time is over; call `run` again")
        key = (mutant.place, mutant.after.strip())
        if not any(text in mutant.place for text in options.only) or key in done or not table.claim(mutant):
            continue
        if key in map(key_of, table.lines()[len(before):]):
            continue
        row = trial.judge(mutant)
        table.add(row)
        print(f"{number}/{len(mutants)} {row['place']} {row['outcome']} {row['by']} {row['seconds']} s {row['note']}",
              flush=True)


def arguments(words: Optional[Sequence[str]] = None) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("prepare", "run", "list", "summary"))
    parser.add_argument("--folder", type=Path, default=ROOT / "build/mutants", help="where the copy is")
    parser.add_argument("--table", type=Path, help="the table, in FOLDER if not given")
    parser.add_argument("--list", type=Path, help="file of mutants, instead of a draw")
    parser.add_argument("--count", type=int, default=220, help="number of mutants, more by the least of folders")
    parser.add_argument("--least", type=int, default=4, help="least number in each folder of src/")
    parser.add_argument("--seed", type=int, default=1, help="of the draw")
    parser.add_argument("--quick", action="store_true", help="do not look for equal code and digests")
    parser.add_argument("--again", help="try again the mutants with this outcome")
    parser.add_argument("--only", nargs="+", default=[""], help="try only mutants whose place has one of these texts")
    parser.add_argument("--no-unit", action="store_true", help="leave out unit tests, which passed before")
    parser.add_argument("--budget", type=float, default=200.0,
                        help="recorded seconds of tests beyond those of the folder, for one mutant")
    parser.add_argument("--tier", choices=tuple(LONGEST), default="smoke", help="which tests in Python are used")
    parser.add_argument("--minutes", type=float, default=1.0e6, help="begin nothing after this time")
    parser.add_argument("--jobs", type=int, default=1, help="compilations at a time in `prepare`")
    options = parser.parse_args(words)
    if options.table is None:
        options.table = options.folder / ("mutants.csv" if options.list is None else options.list.stem + ".csv")
    return options


def main() -> None:
    """Execute the command line."""
    options = arguments()
    if options.what == "list":
        for mutant in chosen(options, ROOT):
            print(f"{mutant.place} ({mutant.kind})\n- {mutant.before.strip()}\n+ {mutant.after.strip()}\n")
        return
    if options.what == "summary":
        print(summary(Table(options.table).rows()))
        return
    # a run that a signal ends must remove its scratch files
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    shop = Workshop(ROOT, options.folder.resolve(), options.jobs)
    try:
        (prepare if options.what == "prepare" else run)(shop, options)
    finally:
        shop.close()


if __name__ == "__main__":
    main()
