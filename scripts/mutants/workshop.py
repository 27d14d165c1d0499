# SPDX-License-Identifier: BSD-3-Clause
"""A copy of the project in which mutants are compiled, linked and tested. The user's files are only read.

A mutant is one changed object file. It is placed before the libraries when a test program is linked, so the object of
the same name is not taken from its library: neither the libraries nor the programs of the copy change.
"""

import hashlib
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, FrozenSet, List, Optional, Sequence, Set, Tuple

from mutants.places import Mutant
from mutants.process import Ended, run

PROGRAMS = ("scree", "fuzz_decks", "libscree.so")
# Optimisation level that halves the compilation time of the copy; all tests pass with it.
LEVEL = ("-O3 -fno-trapping-math", "-O1 -fno-trapping-math")
# Labels of tests that cannot detect a wrong result of the program.
LEFT_OUT = {"gate", "bench"}


@dataclass(frozen=True)
class Test:
    """One test in the list of CTest."""
    name: str
    command: Tuple[str, ...]
    labels: FrozenSet[str]
    cost: float                 # recorded duration [s]
    folder: str
    environment: Tuple[str, ...]

    @property
    def is_unit(self) -> bool:
        """True for a unit test: the part of a program that is made of one file of test/unit."""
        return "unit" in self.labels

    @property
    def programs(self) -> Tuple[str, ...]:
        """The programs that the test runs. The command of a unit test ends with program and name of the file."""
        return (Path(self.command[-2]).name,) if self.is_unit else PROGRAMS


class Workshop:
    """The copy of the sources, its build, and the processes in it."""

    def __init__(self, root: Path, folder: Path, jobs: int) -> None:
        self.root, self.folder, self.jobs = root, folder, jobs
        self.source, self.build, self.cover = folder / "source", folder / "build", folder / "cover"
        self.scratch = Path(tempfile.mkdtemp(prefix="mutant"))
        self.compilations: Dict[str, List[str]] = {}    # by object
        self.objects: Dict[str, str] = {}               # by source file, relative to the root
        self.links: Dict[str, List[str]] = {}           # by program
        self.libraries: Dict[str, List[str]] = {}       # objects by library
        self.tests: Dict[str, Test] = {}

    def close(self) -> None:
        """Remove the scratch files of this process."""
        shutil.rmtree(self.scratch, ignore_errors=True)

    def copy(self) -> None:
        """Update the copy from the user's files; files with equal content keep their modification time."""
        answer = subprocess.run(["git", "ls-files", "-coz", "--exclude-standard"], cwd=self.root, check=True,
                                capture_output=True, text=True)
        names = {name for name in answer.stdout.split("\0") if name and (self.root / name).is_file()}
        for name in sorted(names):
            data, target = (self.root / name).read_bytes(), self.source / name
            if name == "cmake/ScreeOptions.cmake":
                data = data.replace(LEVEL[0].encode(), LEVEL[1].encode())
            if not target.is_file() or target.read_bytes() != data:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(data)
                shutil.copymode(self.root / name, target)
        for path in self.source.rglob("*"):
            if path.is_file() and path.relative_to(self.source).as_posix() not in names:
                path.unlink()

    def make(self) -> None:
        """Configure on the first call, and build all changed files."""
        self.build.mkdir(parents=True, exist_ok=True)
        venv = self.root / "build/venv"
        if venv.is_dir() and not (self.build / "venv").exists():
            (self.build / "venv").symlink_to(venv.resolve())
        if not (self.build / "CMakeCache.txt").is_file():
            subprocess.run(["cmake", "-S", self.source, "-B", self.build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                            "-DSCREE_WERROR=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"], check=True,
                           stdout=subprocess.DEVNULL)
        subprocess.run(["ninja", "-C", str(self.build), "--quiet", f"-j{self.jobs}"], check=True)

    def load(self) -> None:
        """Read the commands of the build and the list of tests."""
        for entry in json.loads((self.build / "compile_commands.json").read_text(encoding="utf-8")):
            words = shlex.split(entry["command"])
            made = words[words.index("-o") + 1]
            self.compilations[made] = words
            if Path(entry["file"]).is_relative_to(self.source / "src"):
                self.objects[Path(entry["file"]).relative_to(self.source).as_posix()] = made
        lines = subprocess.run(["ninja", "-C", self.build, "-t", "commands", "all"], check=True, capture_output=True,
                               text=True).stdout.splitlines()
        for line in lines:
            library = re.search(r"/ar qc (\S+) (.*?) &&", line)
            if library:
                self.libraries[library[1]] = library[2].split()
            elif line.startswith(": && ") and " -o " in line:
                words = shlex.split(line)[2:-2]
                self.links[Path(words[words.index("-o") + 1]).name] = words
        listed = subprocess.run(["ctest", "--show-only=json-v1"], cwd=self.build, check=True, capture_output=True,
                                text=True).stdout
        for entry in json.loads(listed)["tests"]:
            values = {item["name"]: item["value"] for item in entry.get("properties", ())}
            labels = frozenset(values.get("LABELS", ()))
            if not labels & LEFT_OUT and not entry["name"].startswith("unit/"):
                self.tests[entry["name"]] = Test(
                    entry["name"], tuple(entry["command"]), labels, float(values.get("COST", 1.0)),
                    values.get("WORKING_DIRECTORY", str(self.build)), tuple(values.get("ENVIRONMENT", ())))

    def compile(self, mutant: Mutant, text: str) -> Tuple[Optional[Path], str]:
        """Compile a source file with this text. Returns the object, or the error messages of the compiler."""
        words = list(self.compilations[self.objects[mutant.file]])
        changed, made = self.scratch / Path(mutant.file).name, self.scratch / "changed.o"
        changed.write_text(text, encoding="utf-8")
        made.unlink(missing_ok=True)
        own = next(word for word in words if word.startswith("-J"))
        (self.scratch / "modules").mkdir(exist_ok=True)
        words[words.index(own):words.index(own) + 1] = [f"-J{self.scratch}/modules", f"-I{own[2:]}", "-w"]
        words[words.index("-c") + 1], words[words.index("-o") + 1] = str(changed), str(made)
        ended = run(words, self.build, {}, 300.0)
        return (made if ended.code == 0 and made.is_file() else None), ended.output

    def link(self, program: str, folder: Path, changed: Optional[Path] = None, file: str = "") -> Path:
        """Link a program with the changed object of a file."""
        words = list(self.links[program])
        made = folder / program
        folder.mkdir(parents=True, exist_ok=True)
        at = words.index("-o")
        words[at + 1] = str(made)
        if changed is not None and self.objects[file] in words:
            words[words.index(self.objects[file])] = str(changed)
        elif changed is not None:
            words.insert(at + 2, str(changed))
        subprocess.run(words, cwd=self.build, check=True, capture_output=True)
        return made

    def link_covered(self, program: str, folder: Path) -> None:
        """Link a program whose libraries count lines."""
        words = [str(self.cover / word) if (self.cover / word).is_file() else word for word in self.links[program]]
        folder.mkdir(parents=True, exist_ok=True)
        words[words.index("-o") + 1] = str(folder / program)
        subprocess.run([*words, "--coverage"], cwd=self.build, check=True, capture_output=True)

    def try_test(self, test: Test, folder: Path, cpu: float) -> Ended:
        """Run one test with the programs in a folder."""
        work = Path(tempfile.mkdtemp(prefix="w", dir=self.scratch))
        words = list(test.command)
        if test.is_unit:
            words[-2] = str(folder / test.programs[0])
        else:
            words[words.index("--scree") + 1] = str(folder / "scree")
            words[words.index("--work") + 1] = str(work / "case")
        environment = dict(line.split("=", 1) for line in test.environment)
        try:
            return run(words, Path(test.folder), {**environment, "TMPDIR": str(work),
                                                  "SCREE_LIBRARY": str(folder / "libscree.so")}, cpu)
        finally:
            shutil.rmtree(work, ignore_errors=True)

    def make_coverage(self) -> None:
        """Compile all files whose object is older than the source again, with counters of executed lines."""
        (self.cover / "modules").mkdir(parents=True, exist_ok=True)
        old = []
        for library, objects in self.libraries.items():
            if not Path(library).name.startswith("libscree_pfunit"):
                old += [made for made in objects if made in self.compilations and self.is_old(made)]
        with ThreadPoolExecutor(self.jobs) as pool:
            list(pool.map(self.compile_covered, old))
        for library, objects in self.libraries.items():
            made = self.cover / library
            if "pfunit" not in library and (set(objects) & set(old) or not made.is_file()):
                made.parent.mkdir(parents=True, exist_ok=True)
                made.unlink(missing_ok=True)
                subprocess.run(["ar", "rcs", made, *(self.cover / one for one in objects)], check=True)

    def is_old(self, made: str) -> bool:
        """True if the object with counters is older than its source."""
        words = self.compilations[made]
        source, there = Path(words[words.index("-c") + 1]), self.cover / made
        return not there.is_file() or there.stat().st_mtime < source.stat().st_mtime

    def compile_covered(self, made: str) -> None:
        """Compile one object with counters of executed lines."""
        words = [word for word in self.compilations[made] if not word.startswith("-O")]
        target = self.cover / made
        target.parent.mkdir(parents=True, exist_ok=True)
        own = next(word for word in words if word.startswith("-J"))
        words[words.index(own):words.index(own) + 1] = [f"-J{self.cover}/modules", f"-I{own[2:]}", "-w", "-O1",
                                                        "--coverage"]
        words[words.index("-o") + 1] = str(target)
        answer = subprocess.run(words, cwd=self.build, capture_output=True, text=True, check=False)
        if answer.returncode:
            sys.exit(f"{' '.join(words)}:\n{answer.stderr}")

    def covered_by(self, test: Test) -> Dict[str, List[int]]:
        """Executed lines of a test by file. They are stored in a file, which is valid until the sources or the test
        change."""
        kept = self.cover / "lines" / (re.sub(r"\W", "_", test.name) + ".json")
        key = self.state(test)
        if kept.is_file():
            found = json.loads(kept.read_text(encoding="utf-8"))
            if found["key"] == key:
                return dict(found["lines"])
        folder = self.cover / "bin"
        for program in test.programs:
            if test.is_unit or not (folder / program).is_file():
                self.link_covered(program, folder)
        for path in self.cover.rglob("*.gcda"):
            path.unlink()
        self.try_test(test, folder, 60.0 + 30.0 * test.cost)
        if test.is_unit:
            (folder / test.programs[0]).unlink()
        lines = self.counted()
        kept.parent.mkdir(exist_ok=True)
        fresh = kept.with_suffix(".new")
        fresh.write_text(json.dumps({"test": test.name, "key": key, "lines": lines}), encoding="utf-8")
        fresh.rename(kept)
        return lines

    def counted(self) -> Dict[str, List[int]]:
        """Executed lines of src/, from the counters of the compiler."""
        files = [str(path) for path in self.cover.rglob("*.gcda")]
        return {file: sorted(line for line, count in counts.items() if count)
                for file, counts in self.counts(files).items() if any(counts.values())}

    def counted_lines(self, file: str) -> Set[int]:
        """Lines of a file that have a counter."""
        found = self.counts([str((self.cover / self.objects[file]).with_suffix(".gcno"))])
        return set(found.get(file, {}))

    def counts(self, files: Sequence[str]) -> Dict[str, Dict[int, int]]:
        """Number of executions of each line, by file of src/."""
        found: Dict[str, Dict[int, int]] = {}
        if not files:
            return found
        answer = subprocess.run(["gcov", "--json-format", "--stdout", *files], cwd=self.scratch, capture_output=True,
                                text=True, check=False)
        for line in answer.stdout.splitlines():
            if line.startswith("{"):
                for file in json.loads(line)["files"]:
                    path = self.build / file["file"]
                    if path.is_relative_to(self.source):
                        counts = found.setdefault(path.relative_to(self.source).as_posix(), {})
                        for entry in file["lines"]:
                            number = entry["line_number"]
                            counts[number] = counts.get(number, 0) + entry["count"]
        return found

    def state(self, test: Test) -> str:
        """A hash of the sources and of the file of the test."""
        digest = hashlib.sha256()
        file = self.source / "test" / f"{test.name.split('.')[0]}.py"
        tests = list(self.source.glob(f"test/unit/*/{test.name}.pf")) if test.is_unit else [file]
        for path in [*sorted((self.source / "src").rglob("*.f90")), *tests]:
            digest.update(path.read_bytes())
        return digest.hexdigest()

    def digests(self, folder: Path, decks: Sequence[Path]) -> Dict[str, str]:
        """Digests of some decks after a few steps with the program in a folder; for a run that fails, its exit code."""
        found = {}
        for deck in decks:
            work = Path(tempfile.mkdtemp(prefix="w", dir=self.scratch))
            environment = {"OMP_NUM_THREADS": "1", "TMPDIR": str(work), "OMPI_ALLOW_RUN_AS_ROOT": "1",
                           "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
            command = [str(folder / "scree"), "-q", "--overwrite", "--case", "m", "--outdir", str(work), str(deck),
                       "--set", "time.max_steps=40"]
            ended = run(command, self.build, {**os.environ, **environment}, 120.0)
            summary = work / "m.summary.json"
            match = re.search(r'"digest": *"?(\w+)', summary.read_text(encoding="utf-8")) if summary.is_file() else None
            found[deck.relative_to(self.source).as_posix()] = match[1] if match else f"exit code {ended.code}"
            shutil.rmtree(work, ignore_errors=True)
        return found
