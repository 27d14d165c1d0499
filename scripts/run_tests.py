# SPDX-License-Identifier: BSD-3-Clause
"""Select the tests of a tier, run them with CTest and list passed, failed and skipped tests at the end.

Called by scripts/test.sh, which builds first and documents the options. Only the standard library is needed.

Every test is in one or more tiers, according to its labels: smoke (a few minutes, every part of the program), full (all
default tests) and long (studies of many minutes). Lines of a test's output that begin with KNOWN (a known miss: a
target that is not met yet) or SKIPPED (a part that cannot run on this machine) are collected into tables.
"""

import argparse
import json
import math
import os
import re
import subprocess
import sys
import time
import xml.etree.ElementTree as ElementTree
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
COSTS = ROOT / "test/costs.csv"
NEXT_TIER = {"smoke": "full", "full": "long"}
SHARES = 3      # number of groups of the long tests, one of which is run at a time
DAY = 86400
UNKNOWN = 1.0   # cost of a test without a recorded duration
PRESUMED = 600.0  # assumed duration of a long test without a recorded one [s], so that no share gets all of them
LEAST = 180.0   # [s]; a test without a recorded duration starts only if at least this time is left
SLACK = 10.0    # [s]; CTest may end tests this much before the time limit
STOPPED = re.compile(r"Test +#\d+: (\S+) \.+\*\*\*Timeout")


class Test:
    """One test in the list of CTest."""

    def __init__(self, entry):
        self.name = entry["name"]
        values = {item["name"]: item["value"] for item in entry.get("properties", ())}
        self.labels = set(values.get("LABELS", ()))
        self.cost = float(values.get("COST", UNKNOWN))
        self.cores = int(values.get("PROCESSORS", 1))


def listed(folder, options):
    """The tests that CTest knows, filtered by options such as -R or -L."""
    answer = subprocess.run(["ctest", "--show-only=json-v1", *options], cwd=folder, capture_output=True,
                            text=True, check=False)
    if answer.returncode:
        sys.exit(f"ctest --show-only failed:\n{answer.stderr}")
    return [Test(entry) for entry in json.loads(answer.stdout)["tests"]]


def long_share(tests, share):
    """One of SHARES groups of the long tests. The groups have about the same cost, and every test is in exactly one of
    them."""
    def work(test):
        return (PRESUMED if test.cost == UNKNOWN else test.cost) * test.cores

    groups = [[] for _ in range(SHARES)]
    for test in sorted(tests, key=lambda test: (-work(test), test.name)):
        min(groups, key=lambda group: sum(map(work, group))).append(test)
    return groups[share]


def in_time(tests, extra, seconds, jobs):
    """The tests of `extra` that can end within the time when they are run together with `tests`, and the other tests of
    `extra`."""
    chosen, left = list(tests), []
    for test in sorted(extra, key=lambda test: test.cost):
        (chosen if expected([*chosen, test], jobs) <= seconds else left).append(test)
    return chosen[len(tests):], left


def choose(tests, choice, filtered):
    """The tests to run, and the long tests without a recorded duration, which start when all others have ended and run
    in the remaining time. The tests are those of the named tiers. With a filter but no tier they are those of tier
    `full`, or all tests that match if none of these is in `full`."""
    tiers = [name for name in ("smoke", "full", "long") if getattr(choice, name)]
    if not tiers:
        tiers = ["full"] if filtered else ["smoke"]
        if filtered and not any("full" in test.labels for test in tests):
            return tests, []
    chosen, tried = [test for test in tests if test.labels & set(tiers)], []
    if choice.long_share is not None:
        share = long_share([test for test in tests if "long" in test.labels and test not in chosen], choice.long_share)
        tried = in_turns([test for test in share if test.cost == UNKNOWN], choice.day)
        extra, left = in_time(chosen, [test for test in share if test.cost != UNKNOWN], 60.0 * choice.minutes,
                              choice.jobs)
        for test in left:
            print(f"NOT RUN  {test.name}: it takes {minutes(test.cost)}, so it may not end in time")
        chosen += extra
    return chosen, tried


def in_turns(tests, day):
    """The same tests in cyclic order: the first test changes from day to day, so that each is the first on some day."""
    first = day // SHARES % len(tests) if tests else 0
    return tests[first:] + tests[:first]


def minutes(seconds):
    """A duration as text."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60.0:.0f} min"


def expected(tests, jobs):
    """Duration of tests on `jobs` cores [s], by the recorded costs."""
    work = sum(test.cost * min(test.cores, jobs) for test in tests) / jobs
    return max([work] + [test.cost for test in tests])


def outcomes(file):
    """(name, result, seconds, output) of each test in a JUnit file; result is passed, failed or skipped."""
    found = []
    for entry in ElementTree.parse(file).getroot().iter("testcase"):
        status = entry.get("status")
        skipped = entry.find("skipped") is not None or status in ("notrun", "disabled")
        result = "failed" if status == "fail" else "skipped" if skipped else "passed"
        # A test that could not be started, for example because its program was not built, counts as failed.
        message = entry.find("skipped")
        if result == "skipped" and message is not None and "SKIP" not in message.get("message", ""):
            result = "failed"
        found.append((entry.get("name"), result, float(entry.get("time", 0)), entry.findtext("system-out") or ""))
    return found


def table(title, rows):
    """Print rows of text under a title, in columns."""
    if not rows:
        return
    print(f"\n{title}")
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        print("  " + "  ".join(text.ljust(width) for text, width in zip(row, widths)).rstrip())


def marked(results, word):
    """(test, rest of the line) for all output lines that begin with the given word."""
    return [(name, line[len(word):].strip()) for name, _, _, output in results
            for line in output.splitlines() if line.startswith(word + " ")]


def record(results, tests):
    """Write the durations of tests that passed into the list of costs. Entries of other tests do not change; entries of
    tests that do not exist any more are removed."""
    costs = {}
    for line in COSTS.read_text(encoding="utf-8").splitlines()[1:]:
        name, seconds = line.rsplit(",", 1)
        costs[name] = seconds
    costs.update({name: f"{max(seconds, 0.1):.1f}" for name, result, seconds, _ in results if result == "passed"})
    names = sorted(set(costs) & {test.name for test in tests})
    COSTS.write_text("name,seconds\n" + "".join(f"{name},{costs[name]}\n" for name in names), encoding="utf-8")


def report(results, choice, everything, spent):
    """Print the tables and the closing lines. True if nothing failed."""
    known = []
    for name, text in marked(results, "KNOWN"):
        match = re.match(r"(.*): (\S+) \((.*)\)$", text)
        known.append((name, *match.groups()) if match else (name, text, "", ""))
    skipped = marked(results, "SKIPPED")
    said = {name for name, _ in skipped}
    skipped += [(name, "all: no reason was given") for name, result, _, _ in results
                if result == "skipped" and name not in said]
    table("Known misses: targets that are not met yet", known)
    table("Skipped", skipped)
    failed = [name for name, result, _, _ in results if result == "failed"]
    table("Failed", [(name,) for name in failed])
    print(f"\nThe tests took {minutes(spent)}.", end="")
    following = NEXT_TIER.get("full" if choice.full or choice.long_share is not None
                              else "long" if choice.long else "smoke")
    if following:
        more = [test for test in everything if following in test.labels]
        print(f" Next: scripts/test.sh --{following}, {len(more)} tests, about "
              f"{minutes(expected(more, choice.jobs))}.", end="")
    print("\nOne test: scripts/test.sh -R NAME (all names: ctest --test-dir build -N)")
    count = {word: sum(result == word for _, result, _, _ in results) for word in ("passed", "failed", "skipped")}
    print(f"{count['passed']} passed, {count['failed']} failed, {count['skipped']} skipped", flush=True)
    return not failed


class Filter(argparse.Action):
    """Stores the options that select tests, in the form in which CTest needs them."""

    def __call__(self, parser, namespace, values, option_string=None):
        namespace.filters = namespace.filters + [option_string, values]


def arguments():
    """The options of this script; all others are passed to CTest."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--folder", type=lambda text: Path(text).resolve(), default=ROOT / "build")
    for word in ("smoke", "full", "long", "record"):
        parser.add_argument(f"--{word}", action="store_true")
    today = int(time.time() // DAY)
    parser.add_argument("--long-share", type=int, nargs="?", const=today % SHARES, choices=range(SHARES))
    parser.add_argument("--minutes", type=float, default=65.0)
    for word in ("-R", "-E", "-L", "-LE"):
        parser.add_argument(word, dest="filters", action=Filter)
    parser.set_defaults(filters=[], day=today)
    parser.add_argument("--jobs", "-j", type=int, default=int(os.environ.get("TEST_JOBS", os.cpu_count() or 2)))
    return parser.parse_known_args()


def run_ctest(tests, choice, options, end=math.inf):
    """Run tests with CTest, at most until `end`. Returns the exit code, the results, and the names of the tests that
    were stopped at this time. A test that exceeds its own time limit before has failed."""
    names = "|".join(re.escape(test.name).replace("\\-", "-").replace("\\/", "/") for test in tests)
    file = choice.folder / "Testing/results.xml"
    file.unlink(missing_ok=True)
    command = ["ctest", "--output-on-failure", "--no-tests=error", "-j", str(choice.jobs), *options,
               "-R", f"^({names})$", "--output-junit", str(file), "--test-output-size-passed", "1000000",
               "--test-output-size-failed", "1000000"]
    stopped = []
    with subprocess.Popen(command, cwd=choice.folder, stdout=subprocess.PIPE, text=True, errors="replace") as process:
        for line in process.stdout:
            print(line, end="", flush=True)
            match = STOPPED.search(line)
            if match and time.time() > end - SLACK:
                stopped.append(match.group(1))
    return process.returncode, outcomes(file) if file.is_file() else [], stopped


def try_in_time(tests, choice, options, end):
    """Run tests without a recorded duration until the time `end`. Returns the results of those that have ended, and
    prints the names of the others."""
    results = []
    if end - time.time() > LEAST:
        clock = time.strftime("%H:%M:%S", time.localtime(end))
        _, results, stopped = run_ctest(tests, choice, [*options, "--stop-time", clock], end)
        results = [result for result in results if result[0] not in stopped]
    ended = {name for name, _, _, _ in results}
    table("Not ended in time, and never recorded", [(test.name,) for test in tests if test.name not in ended])
    return results


def main():
    """Select the tests, run them and print the report."""
    choice, options = arguments()
    everything = listed(choice.folder, [])
    chosen, tried = choose(listed(choice.folder, choice.filters), choice, bool(choice.filters))
    if not chosen:
        sys.exit("no test fits these options; all names: ctest --test-dir build -N")
    print(f"{len(chosen)} tests, {choice.jobs} at a time, about {minutes(expected(chosen, choice.jobs))}", flush=True)
    begin = time.time()
    code, results, _ = run_ctest(chosen, choice, options)
    if not results:
        sys.exit(code or 1)
    if tried:
        results += try_in_time(tried, choice, options, begin + 60.0 * choice.minutes)
    good = report(results, choice, everything, time.time() - begin)
    if choice.record:
        record(results, everything)
    sys.exit(0 if good and code == 0 else 1)


if __name__ == "__main__":
    main()
