# SPDX-License-Identifier: BSD-3-Clause
"""The command scree-bench: reads its options, measures, and prints or compares results."""
import argparse
import re
import sys
import tempfile
import time
from pathlib import Path

from scree_post.command import Parser
from scree.errors import EXIT_DIFFERENT, EXIT_USAGE, ScreeError
from scree_post.errors import run as run_main

from . import __version__, cases, machine, measure, result, tables

CODES = "exit codes: 0 done, 1 something is slower than --limit or a run failed, 2 command line wrong, 3 file problem"
EXAMPLES = """examples:
  scree-bench                                            all cases, a few minutes
  scree-bench --only 'metal*,debris' --repeat 5
  scree-bench --size full --layouts 1x16,16x1 --out node.json --markdown node.md
  scree-bench --compare node.json other.json             another machine or version
  scree-bench --turns ../before/build/bin/scree          faster than before?
"""


def parser():
    """All options."""
    made = Parser(prog="scree-bench", formatter_class=argparse.RawDescriptionHelpFormatter,
                  description="How fast scree is on this machine: particle updates per second of usual cases,\n"
                              "by phases, beside the speed at which a core copies memory.",
                  epilog=f"{EXAMPLES}\n{CODES}")
    add = made.add_argument
    add("--list", action="store_true", help="list the cases and exit")
    add("--size", choices=cases.SIZES, default="small",
        help="small, the default: blocks of 20^3 cells; full: 64^3 cells, 2 GB of memory, about an hour")
    add("--only", default="", metavar="PATTERN",
        help="only cases whose names contain this text or match a pattern such as 'block*,debris'")
    add("--layouts", default="2x1,1x2", metavar="RxT", help="ranks x threads for the parallel cases")
    add("--repeat", type=int, default=3, metavar="N", help="number of runs of each case; default 3")
    add("--scree", metavar="PATH",
        help="the program; default: environment variable SCREE, else scree in the folder of this command")
    add("--turns", metavar="OTHER", help="run another program alternately and print the speed relative to it")
    add("--mpiexec", default="mpiexec", metavar="WORDS", help="command that starts ranks; default mpiexec")
    add("--out", metavar="FILE", help="file of the results, JSON; default scree_bench_DATE_TIME.json")
    add("--markdown", metavar="FILE",
        help=f"write the table to a new file, or between {tables.BEGIN} and {tables.END} of an existing file")
    add("--work", metavar="FOLDER", help="folder for scratch files, which is kept; default: a temporary folder")
    add("--show", metavar="A.json", help="print the table of a file, without measurement")
    add("--compare", nargs=2, metavar=("A.json", "B.json"), help="print the speed of B relative to A for each case")
    add("--limit", type=float, default=1.25, metavar="X",
        help="mark cases that are more than X times slower; default 1.25")
    add("-V", "--version", action="store_true", help="print the version of this command")
    return made


def layouts(text):
    """Pairs (ranks, threads) of 2x1,1x2."""
    found = []
    for word in filter(None, (part.strip() for part in text.split(","))):
        match = re.fullmatch(r"([1-9]\d{0,5})x([1-9]\d{0,3})", word)
        if not match:
            raise ScreeError(f"--layouts {word}: write ranks x threads, such as 2x1,1x2", EXIT_USAGE)
        found.append((int(match.group(1)), int(match.group(2))))
    return list(dict.fromkeys(found))


def check_numbers(options):
    """Refuse invalid values of options."""
    if not 1 <= options.repeat <= 1000:
        raise ScreeError(f"--repeat {options.repeat}: a number from 1 to 1000", EXIT_USAGE)
    if not 1.0 <= options.limit < 1.0e6:
        raise ScreeError(f"--limit {options.limit:g}: how many times slower is allowed, 1 or more", EXIT_USAGE)
    if sum(map(bool, (options.list, options.show, options.compare, options.turns))) > 1:
        raise ScreeError("--list, --show, --compare and --turns exclude each other", EXIT_USAGE)


def listing(options):
    """The text that --list prints."""
    runs = cases.plan(options.only, layouts(options.layouts))
    width = max(len(run.key) for run in runs)
    return "\n".join(f"{run.key:<{width}}  {run.case.about}" + (
        f", {run.ranks} ranks x {run.threads} threads" if run.cores > 1 else "") for run in runs)


def read(path):
    """Read a file of results that contains all values for tables and comparisons."""
    whole = result.read(path)
    try:
        tables.terminal(whole)
        tables.compared(whole, whole, 1.0)
    except (AttributeError, IndexError, KeyError, TypeError, ValueError, ZeroDivisionError) as error:
        raise ScreeError(f"{path} is a damaged file of results ({type(error).__name__}: {error}); "
                        "measure again") from error
    return whole


def show(options):
    """The table of a file."""
    whole = read(options.show)
    if options.markdown:
        tables.write_page(options.markdown, tables.markdown(whole))
    print(tables.terminal(whole))
    return 0


def compare(options):
    """Compare two files of results. Returns the exit code."""
    first, second = (read(path) for path in options.compare)
    result.comparable(first, second, options.compare)
    rows, slower, missing = tables.compared(first, second, options.limit)
    for name, whole in zip("AB", (first, second)):
        print("\n   ".join([f"{name}: {tables.head(whole)[0]}", *tables.head(whole)[1:]]))
    print()
    if not rows:
        raise ScreeError("\n".join([f"{options.compare[0]} and {options.compare[1]} have no case in common", *missing]))
    print(tables.plain(tables.COMPARED, rows))
    print("\n".join([*missing, *(slower or [f"no case is more than {options.limit:g} times slower"])]))
    return EXIT_DIFFERENT if slower else 0


def out_file(options):
    """Path of the results; an error before the measurement if the file cannot be written."""
    path = Path(options.out or time.strftime("scree_bench_%Y-%m-%d_%H%M%S.json"))
    known = path.exists()
    try:
        path.open("a", encoding="utf-8").close()
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror}; name another file with --out") from error
    if not known:
        path.unlink()
    return path


def run_cases(options, beside, copies):
    """Measure, write and print. Returns the exit code."""
    runs = cases.plan(options.only, layouts(options.layouts))
    programs = [machine.program(path, beside) for path in (options.scree, options.turns)[:2 if options.turns else 1]]
    copy = machine.copy_program(programs[0].path, copies)
    mpiexec = measure.mpiexec_words(options.mpiexec)
    path = out_file(options)
    if options.markdown:
        tables.check_page(options.markdown)
    begin = time.monotonic()
    about = {"begun": time.strftime("%Y-%m-%d %H:%M"), "size": options.size, "repeats": options.repeat,
             "machine": machine.describe(), "programs": [program.record() for program in programs]}

    def whole(results):
        return result.document({**about, "seconds": round(time.monotonic() - begin, 1)}, results)

    with scratch(options.work) as folder:
        bench = measure.Bench(programs, copy, folder, options.size, mpiexec)
        written = []

        def save(found):
            result.write(path, whole(found))
            written.append(path)

        try:
            results = measure.measure(bench, runs, options.repeat, save)
        except KeyboardInterrupt:
            print(f"results of {len(written)} repeats in {path}" if written else "no repeat was finished",
                  file=sys.stderr)
            raise
    found = whole(results)
    if options.markdown:
        tables.write_page(options.markdown, tables.markdown(found))
    print(tables.terminal(found))
    slower = tables.slower_in_turns(found, options.limit)
    print("\n".join([*slower, f"results in {path}"]))
    failed = any(one["failed"] for entry in results for one in entry["programs"])
    return EXIT_DIFFERENT if slower or failed else 0


class scratch:
    """A folder for decks and runs: the named one, or a temporary one that is removed."""

    def __init__(self, path):
        self.path, self.temporary = path, None

    def __enter__(self):
        try:
            if self.path:
                folder = Path(self.path).absolute()
                folder.mkdir(parents=True, exist_ok=True)
                return folder
            self.temporary = tempfile.TemporaryDirectory(prefix="scree_bench_")
            return Path(self.temporary.name)
        except OSError as error:
            raise ScreeError(f"no folder for scratch files: {error}; name another one with --work") from error

    def __exit__(self, *_):
        if self.temporary:
            self.temporary.cleanup()


def main(words=None, beside=None, copies=None):
    """Run the command. Returns the exit code."""
    options = parser().parse_args(sys.argv[1:] if words is None else words)
    check_numbers(options)
    if options.version:
        print(f"scree-bench {__version__}")
        return 0
    if options.list:
        print(listing(options))
        return 0
    if options.show:
        return show(options)
    if options.compare:
        return compare(options)
    return run_cases(options, beside, copies)


def run(beside=None, copies=None):
    """Entry point: errors become one line on standard error. `beside` is the folder of the command and `copies` that of
    the program memory_copy, if they are known."""
    run_main(lambda: main(beside=beside, copies=copies), "scree-bench")
