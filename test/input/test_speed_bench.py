# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# cores: 2
"""scree-bench: numbers, tables and comparisons from artificial measurements, and its smallest case as a whole.

No run time is checked. The first line of each test states which bug it would catch.
"""

import copy
import json
import os
import re
import subprocess

import pytest

import case
from scree.errors import ScreeError
from scree_bench import cases, command, machine, measure, result, tables

FOLDER = "wo rk ü"
MILLION = 1000000


def raw(repeat, spent, copied=20.0, **more):
    """One run of a million updates that took `spent` ns each."""
    return {"repeat": repeat, "seconds": 1.0, "processor_s": 1.0e-3 * spent, "particle_updates": MILLION,
            "particle_updates_per_s": 1.0e9 / spent, "particles": 50000, "steps": 20, "bytes_per_particle": 300.0,
            "timers": {"points to nodes": 1.0, "grid": 0.5, "nodes to points": 1.5, "eos": 0.4, "strength": 0.6,
                       "a new phase": 0.25, "output": 100.0},
            "copy_before": {"copy": copied - 2.0, "triad": copied}, "copy_after": {"copy": copied, "triad": copied},
            **more}


def whole(spent=300.0, copied=20.0, names=("block_ddmp", "metal_mpm", "block_ddmp_1x2"), other=None, size="small"):
    """A file of results in which all cases took the same time."""
    entries = []
    for run in cases.plan():
        if run.key in names:
            entry = result.started(run, "digest", "", 2 if other else 1)
            entry["programs"][0]["runs"] = [raw(n + 1, spent * factor, copied * run.cores)
                                            for n, factor in enumerate((1.3, 1.0, 2.0))]
            if other:
                entry["programs"][1]["runs"] = [raw(n + 1, other * factor, copied)
                                                for n, factor in enumerate((1.3, 1.1, 2.0))]
            result.finish(entry)
            entries.append(entry)
    one = machine.Program("/p", "0.1.0", "abc", "gfortran 12.2.0", "Release", "-O3", "MPI").record()
    return result.document({"begun": "2026-01-01 00:00", "size": size, "repeats": 3, "seconds": 60.0,
                            "machine": {"processor": "Made up", "cores": 2, "vectors": "", "memory_gib": 4.0,
                                        "system": "none"}, "programs": [one] * (2 if other else 1)}, entries)


def places(held, where=()):
    """Key paths to all values of a file, outermost key first."""
    pairs = held.items() if isinstance(held, dict) else enumerate(held) if isinstance(held, list) else ()
    for key, inner in pairs:
        yield (*where, key)
        yield from places(inner, (*where, key))


def call(options, *words, code=0):
    """Output of the command on both streams."""
    answer = subprocess.run([str(options.scree.parent / "scree-bench"), *map(str, words)], cwd=options.work / FOLDER,
                            text=True, capture_output=True, check=False, timeout=250,
                            env={**os.environ, **case.OPEN_MPI, "SCREE": ""})
    if answer.returncode != code:
        raise AssertionError(f"{words}: exit code {answer.returncode}, expected {code}\n{answer.stdout}{answer.stderr}")
    return answer.stdout, answer.stderr


class TestNumbers:
    """One result from its runs."""

    @pytest.fixture(autouse=True)
    def made(self):
        self.entry = whole(names=("block_ddmp", "block_ddmp_1x2"))["results"]
        self.one = self.entry[0]["programs"][0]

    def test_best_of_the_runs(self):
        """Would catch the time of the slowest run or the mean of the runs, and another number of nanoseconds."""
        assert abs(self.one["ns"] - 300.0) <= 0.5e-9
        assert abs(self.one["ns_median"] - 390.0) <= 0.5e-9
        assert abs(self.one["ns_most"] - 600.0) <= 0.5e-9
        assert abs(self.one["updates_per_core_s"] - (1.0e9 / 300.0)) <= 0.5e-3

    def test_phases_add_up(self):
        """Would catch a phase that is lost, one that is counted twice, and output that counts as work of the steps."""
        parts = self.one["phases_ns"]
        assert abs(sum(parts.values()) - 300.0) <= 0.5e-9
        assert abs(parts["to particles"] - (300.0 * 1.5 / 4.25)) <= 0.5e-9
        assert abs(parts["material"] - (300.0 * 1.0 / 4.25)) <= 0.5e-9
        assert abs(parts["a new phase"] - (300.0 * 0.25 / 4.25)) <= 0.5e-9
        assert "output" not in parts

    def test_phases_of_all_runs(self):
        """Would catch phases of a single run, whose few samples of the laws scatter."""
        entry = result.started(cases.plan("line")[0], "d", "", 1)
        entry["programs"][0]["runs"] = [raw(1, 300.0), raw(2, 310.0, timers={"grid": 0.75, "output": 9.0})]
        result.finish(entry)
        parts = entry["programs"][0]["phases_ns"]
        assert abs(sum(parts.values()) - 300.0) <= 0.5e-9
        assert abs(parts["nodes"] - (300.0 * 1.25 / 5.0)) <= 0.5e-9

    def test_printed_phases_add_up(self):
        """Would catch a table whose phases do not add up to its time, to half a nanosecond per column."""
        heads, rows = tables.speed_rows(whole())
        first, last = heads.index("+%") + 1, heads.index("bytes")
        for row in rows:
            assert abs(sum(map(float, row[first:last])) - float(row[3])) <= 0.5 * (last - first + 1)

    def test_copy_is_of_one_core(self):
        """Would catch the memory bandwidth of two threads beside the time of one core, and a ratio with the wrong power
        of ten."""
        for entry in self.entry:
            one = entry["programs"][0]
            assert abs(one["copy_gb_s"] - 20.0) <= 0.5e-9
            # in 300 ns a core copies 300 ns x 20 GB/s = 6000 bytes
            assert abs(one["updates_per_mb"] - (1.0e6 / 6000.0)) <= 0.5e-9

    def test_run_that_failed(self):
        """Would catch a failed run that ends the measurement, or one that is not reported."""
        entry = result.started(cases.plan("debris")[0], "d", "", 1)
        entry["programs"][0]["runs"] = [{"repeat": 1, "failed": "exit code 4: x", "copy_before": {}, "copy_after": {}}]
        result.finish(entry)
        assert "ns" not in entry["programs"][0]
        found = whole()
        found["results"].append(entry)
        assert "debris: failed, exit code 4: x" in tables.terminal(found)
        assert "| debris |" not in tables.markdown(found)

    def test_turns(self):
        """Would catch an inverted ratio, runs of different repetitions in one ratio, and a wrong verdict."""
        found = whole(spent=300.0, other=600.0)
        for entry in found["results"]:
            assert abs(entry["turns"]["median"] - 2.0) <= 0.5e-9
            assert abs(entry["turns"]["most"] - 2.2) <= 0.5e-9
            assert abs(entry["turns"]["of_best"] - 2.2) <= 0.5e-9
        assert tables.slower_in_turns(found, 1.25) == []
        assert len(tables.slower_in_turns(whole(spent=600.0, other=300.0), 1.25)) == 3
        assert "speed:other" in tables.terminal(found)


class TestComparison:
    """Two files."""

    def test_slower_is_reported(self):
        """Would catch a slower program that passes, and one within the limit that does not."""
        assert tables.compared(whole(), whole(), 1.25)[1] == []
        assert tables.compared(whole(), whole(spent=370.0), 1.25)[1] == []
        rows, slower, _ = tables.compared(whole(), whole(spent=380.0), 1.25)
        assert len(slower) == 3
        assert slower[0].startswith("block_ddmp: 1.27 times slower"), slower
        assert [row[-1] for row in rows] == ["slower"] * 3
        assert tables.compared(whole(), whole(spent=380.0), 1.3)[1] == []

    def test_slower_machine(self):
        """Would catch a slower machine that is taken for a slower program."""
        rows, slower, _ = tables.compared(whole(), whole(spent=600.0, copied=11.0), 1.25)
        assert slower == []
        assert rows[0][3] == "0.50"

    def test_missing_rows(self):
        """Would catch a case that is in one file only and is skipped without a message, or compared with another
        deck."""
        fewer = whole(names=("block_ddmp",))
        for first, second, which in ((whole(), fewer, "second"), (fewer, whole(), "first")):
            rows, _, missing = tables.compared(first, second, 1.25)
            assert len(rows) == 1
            assert [sorted(line.replace(",", "").split()) for line in missing] == [
                sorted(f"no numbers in the {which} file: metal_mpm block_ddmp_1x2".split())
            ]
        other = whole()
        other["results"][0]["deck"] = "another"
        rows, _, missing = tables.compared(whole(), other, 1.25)
        assert (len(rows), missing) == (2, ["not compared, the decks differ: block_ddmp"])


class TestCommand:
    """The command as installed, in a folder with a blank and an umlaut in its name."""

    @pytest.fixture(autouse=True)
    def made(self, options):
        if not (options.scree.parent / "scree-bench").is_file():
            pytest.skip("there is no build tree around the program")
        (options.work / FOLDER).mkdir()
        for name, held in (("a.json", whole()), ("slow.json", whole(spent=900.0)), ("full.json", whole(size="full"))):
            (options.work / FOLDER / name).write_text(json.dumps(held), encoding="utf-8")

    def test_list(self, options):
        """Would catch a case that --list lacks, a name given twice, a pattern that matches nothing or too much."""
        lines = call(options, "--list")[0].splitlines()
        names = [line.split()[0] for line in lines]
        assert len(names) == len(set(names))
        assert len(names) > 20
        assert {"block_ddmp", "block_mpm_2x1", "debris_1x2", "sparse", "column", "metal_mpm"} <= set(names)
        assert [line.split()[0] for line in call(options, "--list", "--only", "sparse,metal_d*")[0].splitlines()] == [
            "metal_ddmp",
            "metal_ddmp_flip",
            "sparse",
        ]
        listed = call(options, "--list", "--layouts", "1x4,4x2", "--only", "debris_")[0]
        assert re.findall(r"^debris_\S+", listed, re.M) == ["debris_1x4", "debris_4x2"]

    def test_one_case(self, options):
        """Would catch a command that finds neither scree nor the memory benchmark, an empty or damaged file, a page
        without its text, and temporary files that are not removed."""
        page = options.work / FOLDER / "page.md"
        page.write_text(f"before\n{tables.BEGIN}\nold\n{tables.END}\nafter\n", encoding="utf-8")
        said = call(options, "--only", "axisymmetric_mpm", "--repeat", "1", "--out", "one.json", "--markdown", page,
                    "--work", "scratch")[0]
        assert re.search(r"axisymmetric_mpm +\d", said)
        held = result.read(str(options.work / FOLDER / "one.json"))
        (one,) = held["results"][0]["programs"]
        assert one["copy_gb_s"] > 0.0
        assert (one["particles"], one["steps"]) == (72 * 72 * 9, 40)
        assert abs(sum(one["phases_ns"].values()) - one["ns"]) <= 0.5e-6
        assert len(one["runs"]) == 1
        assert held["programs"][0]["commit"] in call(options, "--show", "one.json")[0]
        text = page.read_text(encoding="utf-8")
        assert text.startswith("before\n") and text.endswith("after\n") and "\nold\n" not in text, text
        assert "| axisymmetric_mpm |" in text
        assert (options.work / FOLDER / "scratch/axisymmetric_mpm/out/case.summary.json").is_file()
        assert "no case is more than 1.25 times slower" in call(options, "--compare", "one.json", "one.json")[0]

    def test_decks(self, options):
        """Would catch a case that the program refuses: all decks of both sizes are checked, none is run."""
        bench = measure.Bench([machine.program(str(options.scree))], "", options.work / FOLDER / "decks")
        for size in cases.SIZES:
            bench.size, bench.decks = size, {}
            for one in cases.CASES:
                words = [word for setting in one.overrides(size) for word in ("--set", setting)]
                if size == "full" and (one.example or one.files):
                    continue
                answer = subprocess.run([options.scree, "--check", "--no-estimate", *words, bench.prepare(one)],
                                        text=True, capture_output=True, check=False, cwd=options.work / FOLDER,
                                        env={**os.environ, **case.OPEN_MPI})
                assert answer.returncode == 0, f"{one.name}: {answer.stdout}{answer.stderr}"

    def test_exit_codes(self, options):
        """Would catch a slower file that ends with exit code 0, and files of different sizes that are compared."""
        said = call(options, "--compare", "a.json", "slow.json", code=1)[0]
        assert "block_ddmp: 3.00 times slower per MB copied, limit 1.25" in said
        call(options, "--compare", "slow.json", "a.json")
        call(options, "--compare", "a.json", "slow.json", "--limit", "3.1")
        assert "--size small" in call(options, "--compare", "a.json", "full.json", code=2)[1]

    def test_mistakes(self, options):
        """Would catch a traceback, or a message without a remedy, for a mistake of the user."""
        (options.work / FOLDER / "text.json").write_text("no json", encoding="utf-8")
        (options.work / FOLDER / "other.json").write_text("{}", encoding="utf-8")
        damaged = copy.deepcopy(whole())
        del damaged["results"][0]["programs"][0]["phases_ns"]
        (options.work / FOLDER / "damaged.json").write_text(json.dumps(damaged), encoding="utf-8")
        newer = {**whole(), "schema_version": 99}
        (options.work / FOLDER / "newer.json").write_text(json.dumps(newer), encoding="utf-8")
        (options.work / FOLDER / "plain.md").write_text("text\n", encoding="utf-8")
        few = ("--only", "line", "--repeat", "1")
        for words, code, part in (
                (("--only", "blok"), 2, "no case 'blok'; did you mean 'block"),
                (("--lost",), 2, "did you mean '--list'"), (("--size", "huge"), 2, "huge"),
                (("--repeat", "0"), 2, "from 1"), (("--repeat", "x"), 2, "--repeat"),
                (("--limit", "0.5"), 2, "1 or more"),
                (("--layouts", "2by1"), 2, "such as 2x1"), (("--list", "--show", "a.json"), 2, "exclude"),
                (("--compare", "a.json"), 2, "2 arguments"),
                (("--compare", "a.json", "b.json"), 3, "no such file: b.json"),
                (("--show", "text.json"), 3, "not JSON"), (("--show", "other.json"), 3, "--out"),
                (("--show", "damaged.json"), 3, "measure again"), (("--show", "newer.json"), 3, "version 99"),
                (("--show", "."), 3, "folder"), (("--mpiexec", "", *few), 2, "names no command"),
                (("--scree", "nowhere/scree", *few), 3, "no program nowhere/scree"),
                (("--scree", "/bin/true", *few), 3, "is not scree"),
                (("--turns", "/bin/false", *few), 3, "is it scree"),
                (("--out", "nowhere/x.json", *few), 3, "--out"), (("--markdown", "plain.md", *few), 3, tables.BEGIN),
                (("--markdown", "nowhere/x.md", *few), 3, "--markdown"), (("--work", "a.json/x", *few), 3, "--work")):
            said = call(options, *words, code=code)[1].strip()
            assert part in said, words
            assert len(said.splitlines()) == 1, said
            assert said.startswith("scree-bench: "), said
        assert (options.work / FOLDER / "plain.md").read_text(encoding="utf-8") == "text\n"

    def test_damaged_files(self, options):
        """Would catch a traceback for a file that lacks a key, or has a value of another type."""
        path, refused, tried = options.work / FOLDER / "broken.json", 0, 0
        for where in places(whole(names=("block_ddmp",), other=200.0)):
            for value in (None, "text", 0, [], {}):
                broken = whole(names=("block_ddmp",), other=200.0)
                inner = broken
                for key in where[:-1]:
                    inner = inner[key]
                inner[where[-1]] = value
                if value is None and isinstance(inner, dict):
                    del inner[where[-1]]
                path.write_text(json.dumps(broken), encoding="utf-8")
                tried += 1
                try:
                    command.read(str(path))
                except ScreeError as error:
                    refused += 1
                    assert "broken.json" in str(error)
        assert tried > 400
        assert refused > 100

    def test_layout_that_cannot_run(self, options):
        """Would catch a layout with more cores than the machine has that is measured, or skipped without a message."""
        said = call(options, "--only", "line,block_mpm_1x4000", "--layouts", "1x4000", "--repeat", "1",
                    "--out", "two.json")[0]
        assert "block_mpm_1x4000: skipped, needs 4000 cores" in said
        said = call(options, "--compare", "two.json", "two.json")[0]
        assert "no numbers in the second file: block_mpm_1x4000" in said


class TestMachine:
    """Information about programs and the processor."""

    def test_version(self, options):
        """Would catch a version, commit, compiler or flags that are read wrongly."""
        found = machine.read_version("p", "scree 0.1.0 (git v0.1-3-gabc-dirty)  gfortran 12.2.0 Release -O3 "
                                     "-march=native  Open MPI v4.1.4\n")
        assert list(found.record().values()) == [
            "0.1.0",
            "v0.1-3-gabc-dirty",
            "gfortran 12.2.0",
            "Release",
            "-O3 -march=native",
            "Open MPI v4.1.4",
        ]
        with pytest.raises(ScreeError):
            machine.read_version("p", "something 1.0")
        assert machine.program(str(options.scree)).build[:1].isupper()

    def test_processor(self):
        """Would catch a processor without a name, and another vector length."""
        text = "model name\t: AMD EPYC  9B14\nflags\t\t: fpu sse2 avx avx2\nmodel name\t: b\n"
        assert (machine.processor_name(text), machine.vectors(text)) == ("AMD EPYC 9B14", "AVX2")
        assert machine.vectors(text.replace("avx2", "avx2 avx512f")) == "AVX-512"
        assert machine.processor_name("")
        assert command.layouts("2x1, 1x2,2x1") == [(2, 1), (1, 2)]
