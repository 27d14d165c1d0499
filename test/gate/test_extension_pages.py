# SPDX-License-Identifier: BSD-3-Clause
# timeout: 300
"""The examples of the pages on extensions are built and run as the pages say.

Would catch a page whose example does not compile any more, that names a list or a folder that is not there, or that
leaves out a file or a list that has to be changed. Each page is taken by itself: its code blocks become new files, the
names that it tells to add are added to the lists, CMake writes the catalogues, and what uses them is compiled and
linked with the libraries of the build. Nothing else of the sources is touched.
"""

import json
import math
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import case
from sources import ROOT, Module

FILE = re.compile(r"^`((?:src|test)/[\w/.]+)`:\n\n```fortran\n(.*?)^```", re.M | re.S)
NAME = re.compile(r"[Aa]dd `(\w+)`\s+to the list\s+`(\w+)`\s+in\s+`(src/[\w/]+CMakeLists\.txt)`")
DECK = re.compile(r"^```fortran\n(&.*?)^```", re.M | re.S)
# CMake without a project: only the commands that write files are carried out.
SCRIPT = """
foreach(command IN ITEMS scree_layer add_library set_target_properties target_include_directories
      target_link_libraries set_property)
   function(${{command}})
   endfunction()
endforeach()
list(APPEND CMAKE_MODULE_PATH "{root}/cmake")
set(PROJECT_BINARY_DIR "{work}")
set(CMAKE_CURRENT_SOURCE_DIR "{folder}")
include("{folder}/CMakeLists.txt")
include(ScreeSamples)
file(GLOB tests "{work}/test/unit/material/test_*.pf")
scree_material_samples(scree_unit_samples "{work}/test/unit/material" ${{tests}})
"""


def done(command, folder):
    """Run a command that must succeed; its output."""
    answer = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert answer.returncode == 0, f"{command}\n{answer.stdout}\n{answer.stderr}"
    return answer.stdout


class Extension:
    """The sources with the example of a page, and what is compiled of them."""

    def __init__(self, options, page):
        self.build, self.work = options.scree.resolve().parents[1], options.work
        text = (ROOT / page).read_text(encoding="utf-8")
        self.files, self.names, self.decks = FILE.findall(text), NAME.findall(text), DECK.findall(text)
        commands = self.build / "compile_commands.json"
        if not commands.is_file():
            pytest.skip("the build folder has no compile_commands.json; run scripts/build.sh")
        self.commands = {Path(entry["file"]): entry for entry in json.loads(commands.read_text(encoding="utf-8"))}
        self.objects = []
        (self.work / "modules").mkdir()
        for folder in ("src", "test/unit/material", "test/unit/transfer"):
            shutil.copytree(ROOT / folder, self.work / folder)
        for path, content in self.files:
            assert (self.work / path).parent.is_dir(), f"{page}: there is no folder for {path}"
            (self.work / path).write_text(content, encoding="utf-8")
        for name, *place in self.names:
            self.add(name, *place)

    def add(self, name, listed, place):
        """Add a name to a list in a CMakeLists.txt, and write the catalogue of its folder."""
        path = self.work / place
        text, count = re.subn(rf"^set\({listed} ([^)]*)\)", rf"set({listed} \1 {name})", path.read_text("utf-8"),
                              flags=re.M)
        assert count == 1, f"{place} has no list {listed}"
        path.write_text(text, encoding="utf-8")
        script = self.work / "catalogue.cmake"
        script.write_text(SCRIPT.format(root=ROOT, work=self.work, folder=path.parent), encoding="utf-8")
        done(["cmake", "-P", script], path.parent)

    def compile(self, source, like):
        """Compile a file as the build compiles another one; modules of this copy come first."""
        words = shlex.split(self.commands[like]["command"])
        target = self.work / (source.stem + ".o")
        words[words.index("-o") + 1] = str(target)
        words[words.index("-c") + 1] = str(source)
        own = self.work / "modules"
        words = [f"-I{self.build / word[2:]}" if word.startswith("-J") else word for word in words]
        begin = next(n for n, word in enumerate(words) if word.startswith("-I"))
        done(words[:begin] + [f"-J{own}", f"-I{own}"] + words[begin:], self.commands[like]["directory"])
        self.objects.append(target)

    def compile_all(self):
        """Compile the new files, the catalogues, and the modules that use the names of a catalogue: constants.

        Others that use a catalogue call its procedures, whose interfaces are the same. A module that defines bindings
        could not be compiled alone: gfortran may arrange its table of procedures in another order."""
        generated = self.build / "generated"
        for path, _ in self.files:
            if path.startswith("src"):
                # as another file of its folder
                folder = (ROOT / path).parent
                self.compile(self.work / path, next(file for file in self.commands if file.parent == folder))
        written = [path for path in sorted((self.work / "generated").rglob("*.f90")) if path.stem.endswith("catalogue")]
        assert written, "no list has a new name"
        for path in written:
            self.compile(path, generated / path.relative_to(self.work / "generated"))
        catalogues = {path.stem for path in written}
        for path in sorted((self.work / "src").rglob("*.f90")):
            if not any(name in path.read_text("utf-8") for name in catalogues):
                continue
            module = Module(path)
            if any(name in catalogues and "_names" in text for name, _, text in module.uses):
                assert not any(module.bindings.values()), f"{path.name} uses names of a catalogue and has bindings"
                self.compile(path, ROOT / path.relative_to(self.work))

    def link(self, target):
        """Link a program of the build with the new objects in front of the libraries; test programs lose their own."""
        rules = self.build / "build.ninja"
        if rules.is_file():
            line = done(["ninja", "-C", self.build, "-t", "commands", target], ROOT).rstrip().split("\n")[-1]
        else:
            line = next(path.read_text(encoding="utf-8") for path in self.build.rglob("link.txt")
                        if path.parent.name == f"{Path(target).name}.dir")
        words = shlex.split(next(part for part in line.split("&&") if " -o " in part))
        file = self.work / Path(target).name
        words[words.index("-o") + 1] = str(file)
        first = next(n for n, word in enumerate(words) if word.endswith(".o"))
        words = [word for word in words if not (word.endswith(".o") and word.startswith("test/"))]
        done(words[:first] + [*map(str, self.objects)] + words[first:], self.build)
        return file

    def unit_tests(self, sheet, room, *names):
        """Translate, compile, link and run tests of a room, with the samples of this copy."""
        program, like = f"unit_{room}", self.build / f"test/unit/unit_{room}"
        if not (like / f"{program}.f90").is_file():
            sheet.skipped(f"unit tests of {room}", "the build uses pFUnit or has no tests")
            return
        own = {path.stem for place in ("src", "generated") for path in (self.work / place / room).rglob("*.f90")}
        self.objects = [path for path in self.objects if path.stem in own]
        files = [self.work / "test/unit" / room / f"{name}.pf" for name in names]
        done([sys.executable, ROOT / "test/pfunit/translate.py", self.work, program, *files], self.work)
        if room == "material":
            self.compile(self.work / "generated/test/material_samples.f90",
                         self.build / "generated/test/material_samples.f90")
        for name in (*names, program):
            self.compile(self.work / f"{name}.f90", like / f"{program}.f90")
        said = done([self.link(f"test/unit/{program}/{program}")], self.work)
        sheet.require(re.search(r"^[1-9]\d* tests, 0 failed$", said, re.M), f"unit tests of {room}: {said[-200:]}")


def test_law(options, sheet):
    """The law of the page in the program, its unit test, and the tests of all models with its sample."""
    page = Extension(options, "doc/developer/adding_a_law.md")
    assert len(page.names) == 1 and len(page.files) == 2 and len(page.decks) == 1
    page.compile_all()
    new = SimpleNamespace(scree=page.link("bin/scree"), work=options.work)
    said = done([new.scree, "--list", "fields"], options.work)
    sheet.require("creep_strain [1]" in said, "--list fields names the field of the law")
    point = case.Case(new, "point", page.decks[0]).run("--point")
    values = np.genfromtxt(point.folder / "point_point.csv", delimiter=",", names=True)
    relaxed = math.sqrt(3.0) * (values["strain"][-1] - values["xy"][-1] / 1.0e9) / 3.0
    # the rotation changes the shear stress by a fraction of the order of the strain
    sheet.near("the stored strain is the part of the strain that has no stress", values["creep_strain"][-1], relaxed,
               abs(values["strain"][-1]))
    sheet.above("strain that has relaxed", relaxed, 1.0e-4)
    page.unit_tests(sheet, "material", "test_law_maxwell", "test_material_catalogue")


def test_basis(options, sheet):
    """The shape functions of the page in a run, in two parts with the same bits as in one, and the tests of all."""
    page = Extension(options, "doc/developer/adding_a_method.md")
    assert len(page.names) == 1 and len(page.files) == 1 and len(page.decks) == 1
    page.compile_all()
    new = SimpleNamespace(scree=page.link("bin/scree"), work=options.work)
    deck = (ROOT / "input/two_discs/scene.nml").read_text(encoding="utf-8") + page.decks[0]
    words = ("-q", "-s", "run.method=mpm", "-s")
    whole = case.Case(new, "whole", deck).run(*words, "time.max_steps=12")
    parts = case.Case(new, "parts", deck).run(*words, "time.max_steps=7")
    parts.run(*words, "time.max_steps=12", "--restart")
    sheet.require(whole.summary["steps"] == parts.summary["steps"] == 12, "both runs make 12 steps")
    sheet.require(whole.summary["digest"] == parts.summary["digest"], "a restart has the same bits")
    sheet.below("momentum error", whole.summary["ledger"]["momentum_error"], 1.0e-13)
    other = case.Case(options, "other", deck.replace(page.names[0][0], "gimp"))
    other.run(*words, "time.max_steps=12")
    sheet.require(whole.summary["digest"] != other.summary["digest"], "the functions are not those of gimp")
    page.unit_tests(sheet, "transfer", "test_transfer_basis")


def test_shown_files():
    """A page that shows a file of the sources shows all of it, and new files fit the width of the sources."""
    files = [(page.name, path, content) for page in sorted((ROOT / "doc/developer").glob("adding_*.md"))
             for path, content in FILE.findall(page.read_text(encoding="utf-8"))]
    assert [(page, line) for page, _, content in files for line in content.split("\n") if len(line) > 100] == []
    shown = [file for file in files if (ROOT / file[1]).is_file()]
    assert shown
    assert [(page, path) for page, path, content in shown if (ROOT / path).read_text("utf-8") != content] == []
