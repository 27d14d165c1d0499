# SPDX-License-Identifier: BSD-3-Clause
"""Select the tests of a tier, run them with CTest and list passed, failed and skipped tests at the end.

Called by scripts/test.sh, which builds first and documents the options. Only the standard library is needed.

Every test is in one or more tiers, according to its labels: smoke (a few minutes, every part of the program), full (all
default tests) and long (studies of many minutes). Lines of a test's output that begin with KNOWN (a known miss: a
target that is not met yet), WARNING (sizes above a limit) or SKIPPED (a part that cannot run on this machine) are
collected into tables.
"""

import argparse
import json
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
CORES = 2       # of the machine for which the limits hold
USED = 0.9      # fraction of the time of the cores that tests use; the rest is lost by waiting
# Greatest duration of the tests of a tier on that machine [s], according to the list of costs; test/gate/test_costs.py
# checks it. The smoke tier leaves a minute of the four of scripts/test.sh for the build of the tests.
LIMITS = {"smoke": 180.0, "full": 1500.0}
MINUTES = 32.0  # time for the tests with --long-share: setup and build take 5 to 6 minutes of the 40 of .ci/run
DAY = 86400
UNKNOWN = 0.0   # cost of a test that was never recorded


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


def long_groups(tests, seconds, jobs):
    """Groups of long tests, each of which ends within the time; every test that fits is in exactly one of them. Returns
    the groups, and the tests that do not fit or were never recorded."""
    left = [test for test in tests if test.cost == UNKNOWN or expected([test], jobs) > seconds]
    groups = []
    for test in sorted((test for test in tests if test not in left), key=lambda test: (-test.cost, test.name)):
        fitting = (group for group in groups if expected([*group, test], jobs) <= seconds)
        group = next(fitting, None)
        if group is None:
            groups.append([test])
        else:
            group.append(test)
    return groups, left


def choose(tests, choice, filtered):
    """The tests to run, those of the named tiers. With a filter but no tier they are those of tier `full`, or all tests
    that match if none of these is in `full`."""
    tiers = [name for name in ("smoke", "full", "long") if getattr(choice, name)]
    if not tiers:
        tiers = ["full"] if filtered else ["smoke"]
        if filtered and not any("full" in test.labels for test in tests):
            return tests
    return [test for test in tests if test.labels & set(tiers)]


def share(tests, chosen, choice):
    """The long tests of today's group. The groups take the time that `chosen` leaves according to the list of costs, so
    that they are the same every day."""
    rest = [test for test in tests if "long" in test.labels and test not in chosen]
    groups, left = long_groups(rest, 60.0 * choice.minutes - expected(chosen, choice.jobs), choice.jobs)
    table("Long tests that are never in a group (scripts/test.sh --long)",
          [(test.name, minutes(expected([test], choice.jobs)) if test.cost else
            "never recorded: scripts/test.sh --long --record -R NAME") for test in left])
    if not groups:
        return []
    number = choice.long_share % len(groups)
    print(f"\nLong tests: group {number + 1} of {len(groups)}", flush=True)
    return groups[number]


def in_time(tests, seconds, jobs):
    """The tests that can end within the time when they are run together, and the others."""
    chosen, left = [], []
    for test in sorted(tests, key=lambda test: -test.cost):
        (chosen if expected([*chosen, test], jobs) <= seconds else left).append(test)
    return chosen, left


def minutes(seconds):
    """A duration as text."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60.0:.0f} min"


def expected(tests, jobs):
    """Duration of tests on `jobs` cores [s], by the recorded costs."""
    work = sum(test.cost for test in tests) / jobs
    return max([work] + [test.cost / min(test.cores, jobs) for test in tests]) / USED


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
    """Write the processor times of tests that passed into the list of costs, and of those that were skipped and have
    no entry. Entries of other tests do not change; entries of tests that do not exist any more are removed."""
    costs = {}
    for line in COSTS.read_text(encoding="utf-8").splitlines()[1:]:
        name, seconds = line.rsplit(",", 1)
        costs[name] = seconds
    counted = {name for name, result, _, _ in results
               if result == "passed" or result == "skipped" and name not in costs}
    # a test may print the lines of others; its own is the last
    costs.update({name: f"{max(float(text), 0.01):.2f}" if float(text) < 1.0 else f"{float(text):.1f}"
                  for name, text in marked(results, "COST") if name in counted})
    names = sorted(set(costs) & {test.name for test in tests})
    COSTS.write_text("name,seconds\n" + "".join(f"{name},{costs[name]}\n" for name in names), encoding="utf-8")


def report(results, choice, everything, spent):
    """Print the tables and the closing lines. True if nothing failed."""
    known = []
    for name, text in marked(results, "KNOWN"):
        match = re.match(r"(.*): (\S+) \((.*)\)$", text)
        known.append((name, *match.groups()) if match else (name, text, "", ""))
    table("Warnings", marked(results, "WARNING"))
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
    parser.add_argument("--long-share", type=int, nargs="?", const=int(time.time() // DAY))
    parser.add_argument("--minutes", type=float, default=MINUTES)
    for word in ("-R", "-E", "-L", "-LE"):
        parser.add_argument(word, dest="filters", action=Filter)
    parser.set_defaults(filters=[])
    parser.add_argument("--jobs", "-j", type=int, default=int(os.environ.get("TEST_JOBS", os.cpu_count() or 2)))
    return parser.parse_known_args()


def run_ctest(tests, choice, options):
    """Run tests with CTest. Returns the exit code and the results."""
    names = "|".join(re.escape(test.name).replace("\\-", "-").replace("\\/", "/") for test in tests)
    file = choice.folder / "Testing/results.xml"
    file.unlink(missing_ok=True)
    command = ["ctest", "--output-on-failure", "--no-tests=error", "-j", str(choice.jobs), *options,
               "-R", f"^({names})$", "--output-junit", str(file), "--test-output-size-passed", "1000000",
               "--test-output-size-failed", "1000000"]
    code = subprocess.run(command, cwd=choice.folder, check=False).returncode
    return code, outcomes(file) if file.is_file() else []


def run_share(tests, choice, options, spent):
    """Run the long tests that end in the remaining time, on a machine as fast as `spent`, measured and expected time of
    the tests before, tells. Returns the exit code and the results."""
    measured, recorded = spent
    slower = max(1.0, measured / recorded) if recorded else 1.0
    chosen, left = in_time(tests, (60.0 * choice.minutes - measured) / slower, choice.jobs)
    table("Not run, because the tests before took longer than expected", [(test.name,) for test in left])
    return run_ctest(chosen, choice, options) if chosen else (0, [])


def main():
    """Select the tests, run them and print the report."""
    choice, options = arguments()
    everything = listed(choice.folder, [])
    named = listed(choice.folder, choice.filters)
    chosen = choose(named, choice, bool(choice.filters))
    if not chosen:
        sys.exit("no test fits these options; all names: ctest --test-dir build -N")
    print(f"{len(chosen)} tests, {choice.jobs} at a time, about {minutes(expected(chosen, choice.jobs))}", flush=True)
    extra = share(named, chosen, choice) if choice.long_share is not None else []
    begin = time.time()
    code, results = run_ctest(chosen, choice, options)
    if not results:
        sys.exit(code or 1)
    if extra:
        spent = time.time() - begin, expected(chosen, choice.jobs)
        more, found = run_share(extra, choice, options, spent)
        code, results = code or more, results + found
    good = report(results, choice, everything, time.time() - begin)
    if choice.record:
        record(results, everything)
    sys.exit(0 if good and code == 0 else 1)


if __name__ == "__main__":
    main()
