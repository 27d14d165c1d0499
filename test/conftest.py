# SPDX-License-Identifier: BSD-3-Clause
"""What every test has: the program, a folder, the tier, and a sheet of checks.

    pytest test/verify/ductile/test_gurson.py                      # with build/bin/scree, the tier full
    pytest test/hard/test_contact.py -k slides --tier smoke
    pytest test/input/test_jobs.py --scree PROGRAM --work FOLDER

A test takes as arguments what it needs of:

    options         options.scree is the program, options.work an empty place of this test; for case.Case
    file_options    the same, with a folder that all tests of the file share; for fixtures of a wider scope
    sheet           checks that go on after a miss (report.py); the test fails at its end with the list of all misses

CTest starts one file at a time (cmake/ScreeScriptTest.cmake). The exit code is 77 if all tests were skipped, and not
0 if there was none.
"""

import os
import re
import resource
import shutil
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import case
import cost
import measured
import report
import tier

NAME = pytest.StashKey()      # of the folder of a test
RECORDED = pytest.StashKey()  # names of numbers that were measured, by test file
SPENT = pytest.StashKey()     # when the run began, and how many tests passed, failed and were skipped


def pytest_addoption(parser):
    """Options of the tests, which the environment can give as well."""
    group = parser.getgroup("scree")
    group.addoption("--scree", default=os.environ.get("SCREE", case.ROOT / "build/bin/scree"), type=Path,
                    help="the program (default: build/bin/scree, or SCREE of the environment)")
    group.addoption("--work", default=os.environ.get("WORK"), type=Path,
                    help="folder for what tests write (default: WORK of the environment, or a temporary one)")
    group.addoption("--tier", default=tier.NAME, choices=tier.TIERS,
                    help="how much of each test runs (default: SCREE_TIER of the environment, or full)")


def pytest_configure(config):
    """Tests read the tier when they are imported."""
    tier.NAME = config.getoption("tier")
    # programs that a test starts read it as well
    os.environ["SCREE_TIER"] = tier.NAME
    for name, value in case.PATIENT.items():
        os.environ.setdefault(name, value)
    config.stash[RECORDED] = {}
    config.stash[SPENT] = {"begin": time.time(), "passed": 0, "failed": 0, "skipped": 0}


def pytest_collection_modifyitems(config, items):
    """Leave out what another tier runs, and name the folders."""
    for item in items:
        wrong = [name for mark in item.iter_markers("tiers") for name in mark.args if name not in tier.TIERS]
        if wrong:
            raise pytest.UsageError(f"{item.nodeid}: {wrong[0]} is none of the tiers {', '.join(tier.TIERS)}")
    out = [item for item in items
           if any(tier.NAME not in mark.args for mark in item.iter_markers("tiers"))]
    items[:] = [item for item in items if item not in out]
    if out:
        config.hook.pytest_deselected(items=out)
    several = len({item.path for item in items}) > 1
    taken = set()
    for item in items:
        short = re.sub("^test_", "", re.sub(r"[^\w.+-]+", "_", item.nodeid.split("::", 1)[1]).strip("_")[:60])
        name = stem = (f"{item.path.stem}/" if several else "") + short
        while name in taken:
            name = f"{stem}_{len(taken)}"
        taken.add(name)
        item.stash[NAME] = name


def pytest_make_parametrize_id(val):
    """Names of rows that a shell and -k take as they are."""
    if isinstance(val, str):
        return re.sub(r"[^\w.+-]+", "_", val, flags=re.ASCII).strip("_")[:60]
    return f"{val:g}" if isinstance(val, float) else None


def program(config):
    """The program that is tested."""
    path = config.getoption("scree").resolve()
    if not path.is_file():
        pytest.fail(f"there is no program {path}: build it with scripts/build.sh, or name one with --scree",
                    pytrace=False)
    return path


@pytest.fixture(scope="session")
def base(pytestconfig, tmp_path_factory):
    """The folder below which all tests write."""
    folder = pytestconfig.getoption("work")
    folder = folder.resolve() if folder else tmp_path_factory.mktemp("work")
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def given(config, folder):
    """What case.Case needs; the folder is made anew."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return SimpleNamespace(scree=program(config), work=folder)


@pytest.fixture
def options(request, base):
    """The program, and a folder of this test."""
    return given(request.config, base / request.node.stash[NAME])


@pytest.fixture(scope="module")
def file_options(request, base):
    """The program, and a folder of this file."""
    return given(request.config, base / f"{request.path.stem}.shared")


@pytest.fixture
def sheet():
    """Checks that go on after a miss."""
    return report.Report()


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item):
    """Numbers that fixtures measure have the name of this file as well."""
    measured.begin(item.path.stem)


def keep_numbers(item):
    """Write down what a test measured; how that differs from the pages."""
    rows, config = measured.taken(), item.config
    names = config.stash[RECORDED].setdefault(item.path, set())
    folder = config.getoption("work")
    if rows and folder:
        path = folder.resolve() / "measured.jsonl"
        path.parent.mkdir(parents=True, exist_ok=True)
        if not any(config.stash[RECORDED].values()):
            path.unlink(missing_ok=True)
        measured.save(rows, path, os.path.relpath(item.path, case.ROOT))
    names |= {row["name"] for row in rows}
    own = item.path.is_relative_to(case.ROOT / "test")     # not a test of the harness in another folder
    return measured.differences(rows) + (measured.misses(rows, os.path.relpath(item.path, case.ROOT)) if own else [])


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call(pyfuncitem):
    """A test with a sheet fails at its end if a check was missed or none was made, or a page has other numbers."""
    sheet = pyfuncitem.funcargs.get("sheet")
    try:
        result = yield
    except pytest.skip.Exception:
        if sheet is None or not sheet.missed:
            raise
        result = None
    finally:
        different = keep_numbers(pyfuncitem)
    if sheet is not None and not sheet.good():
        pytest.fail(sheet.verdict(), pytrace=False)
    if different:
        pytest.fail("\n".join([*different, "to update pages: python3 scripts/document_numbers.py"]), pytrace=False)
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """Print a line for each test, and a line SKIPPED for the table of scripts/run_tests.py."""
    result = yield
    if call.when == "call" or result.outcome != "passed":
        counts = item.config.stash[SPENT]
        counts[result.outcome] += 1
        name = item.nodeid.split("::", 1)[1]
        if result.skipped:
            report.skipped(name, result.longrepr[2].removeprefix("Skipped: "))
        else:
            sheet = item.funcargs.get("sheet") if hasattr(item, "funcargs") else None
            checks = f", {sheet.verdict()}" if sheet is not None and sheet.good() else ""
            print(f"{result.outcome}   {name}: {result.duration:.1f} s{checks}", flush=True)
    return result


def pytest_report_teststatus(report):
    """No dots between the lines of the tests."""
    return (report.outcome if report.when == "call" or report.outcome != "passed" else "", "", "")


def pytest_sessionfinish(session, exitstatus):
    """A file whose tests were all skipped has an exit code that CTest knows."""
    counts = session.config.stash[SPENT]
    if exitstatus == pytest.ExitCode.OK and counts["skipped"] and not counts["passed"]:
        session.exitstatus = report.NOT_RUN
    whole = not session.config.option.keyword and not any("::" in word for word in session.config.args)
    if exitstatus == pytest.ExitCode.OK and whole and not counts["skipped"]:
        for path, names in session.config.stash[RECORDED].items():
            for name in measured.missing(names, os.path.relpath(path, case.ROOT)):
                print(f"FAILED   {path.name} no longer measures {name}, which a page shows", flush=True)
                session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_unconfigure():
    """Print the processor time of this file, for the list of costs."""
    print(cost.line(resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)), flush=True)
