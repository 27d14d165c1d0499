# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Rules for all text files: form, licence, no leftovers.

Would catch a file without a licence line, a line that is wider than a screen, a line pasted twice, and a path that
exists on one machine only, and a command that would install the package of somebody else; a message without a code or
with a code that has no record, and a record that no message has.
"""

import re
import subprocess
import sys

import pytest

import document_messages
import message_sites
from sources import ROOT, lines_of, place, project_files

WIDTH = {".f90": 100, ".pf": 100, ".py": 120, ".sh": 100}
DIRECTIVE_WIDTH = 128  # a directive of a .pf file must be on one line
CODE = project_files(".f90", ".pf", ".py", ".sh", ".cmake", ".in") + project_files(
    ".txt", under="src") + [ROOT / "CMakeLists.txt"]
ALL = project_files()
MACHINE_PATH = re.compile(r"(?<![\w.}])/(?:home|root|work|Users|mnt|scratch)/\w")
LEFT_OVER = re.compile(r"\b(?:TO" "DO|FIX" "ME|X" "XX|HA" "CK)\\b")


class TestTextGate:
    """One rule per test; all violations are listed."""

    def none(self, offences):
        assert len(offences) == 0, "\n" + "\n".join(offences)

    def test_files_are_found(self):
        assert len(CODE) > 30

    def test_licence(self):
        self.none([place(path, 1) for path in CODE
                   if not any("SPDX-License-Identifier: BSD-3-Clause" in line
                              for line in lines_of(path)[:2])])

    def test_width(self):
        offences = []
        for path in CODE:
            for number, line in enumerate(lines_of(path), 1):
                directive = path.suffix == ".pf" and line.lstrip().startswith("@")
                limit = DIRECTIVE_WIDTH if directive else WIDTH.get(path.suffix, 120)
                if len(line) > limit:
                    offences.append(f"{place(path, number)} has {len(line)} columns")
        self.none(offences)

    def test_package_index(self):
        """The name scree belongs to somebody else at the Python Package Index: no page may tell users to install it."""
        foreign = re.compile(r"pip\d? install (?:-\S+ )*['\"]?scree(?![\w.]*[/_-])\b")
        assert foreign.search("pip install " + "scree") and foreign.search("pip install -U '" + "scree[movie]'")
        assert not foreign.search("pip install scree_mpm-0.1.0-py3-none-any.whl")
        self.none([place(path, number) for path in ALL for number, line in enumerate(lines_of(path), 1)
                   if foreign.search(line)])
        project = (ROOT / "python/pyproject.toml").read_text(encoding="utf-8")
        assert re.search(r'^name = "scree-mpm"$', project, re.M)

    def test_blanks(self):
        offences = []
        for path in ALL:
            lines = lines_of(path)
            for number, line in enumerate(lines, 1):
                if "\t" in line or "\r" in line:
                    offences.append(f"{place(path, number)} has a tab or a carriage return")
                if line != line.rstrip() and path.suffix != ".md":
                    offences.append(f"{place(path, number)} ends in blanks")
            if lines[-1] or len(lines) > 2 and not lines[-2]:
                offences.append(f"{place(path, len(lines))} must end in exactly one line end")
        self.none(offences)

    def test_no_line_twice(self):
        offences = []
        for path in CODE:
            lines = [line.strip() for line in lines_of(path)]
            offences += [place(path, number + 1) for number in range(1, len(lines))
                         if len(lines[number]) >= 40 and lines[number] == lines[number - 1]]
        self.none(offences)

    def test_nothing_left_over(self):
        offences = []
        for path in ALL:
            for number, line in enumerate(lines_of(path), 1):
                if MACHINE_PATH.search(line):
                    offences.append(f"{place(path, number)} names a path of one machine")
                if LEFT_OVER.search(line):
                    offences.append(f"{place(path, number)} holds work to be done")
        self.none(offences)

    def test_scripts_can_be_run(self):
        self.none([f"{place(path, 1)} cannot be executed"
                   for path in project_files(".sh", under="scripts") + [ROOT / ".ci" / "run"]
                   if path.name != "common.sh" and not path.stat().st_mode & 0o100])

    def test_unit_tests_use_supported_directives(self):
        files = project_files(".pf", under="test")
        assert len(files) > 1
        answer = subprocess.run(
            [sys.executable, ROOT / "test" / "pfunit" / "translate.py", "--check", *files],
            capture_output=True, text=True)
        assert answer.returncode == 0, "\n" + answer.stderr

    def test_unit_tests_say_what_they_catch(self):
        self.none([f"{place(path, 1)} does not say which bug it would catch"
                   for path in project_files(".pf", under="test/unit")
                   if not re.search(r"catch", path.read_text(encoding="utf-8"), re.I)])


class TestMessageCodes:
    """The code of a message is the end of its text at the call."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls):
        cls.known = [message for _, part in document_messages.sections().values() for message in part]
        cls.sites = list(message_sites.sites(ROOT))

    def test_each_code_has_a_record(self):
        """Would catch a misspelt code, a code without a record, and a record of a message that no longer exists."""
        found = {}
        for path in project_files(".f90", under="src"):
            for number, line in enumerate(lines_of(path), 1):
                for text in message_sites.LITERAL.findall(line):
                    codes = message_sites.CODE.findall(text)
                    found.update(dict.fromkeys(codes, place(path, number)))
                    assert len(codes) < 2 and text.endswith(tuple(f"[{code}]" for code in codes) or ""), \
                        f"{place(path, number)}: the code must end the text"
        records = {message.code for message in self.known}
        assert {code: where for code, where in found.items() if code not in records} == {}
        assert records - set(found) == set()

    def test_each_message_has_one_code(self, sheet):
        """Would catch a new message without a code, and one with two."""
        assert len(self.sites) > 400
        for site in self.sites:
            with sheet.part(f"{site.path}:{site.line}: {site.text}"):
                codes = message_sites.CODE.findall(site.text)
                assert len(codes) == 1 or (site.complete and not codes), "the text lacks a code, such as [D209]"

    def test_code_is_that_of_the_words(self, sheet):
        """Would catch the code of another message, for which `scree --explain` gives another one by the words."""
        patterns = document_messages.patterns(self.known)
        # a number of a pattern may be a constant in the source
        loose = [(code, letters, re.compile(re.sub(r"\d+", r"(?:\g<0>|\.{3})", pattern.pattern)))
                 for code, letters, pattern in patterns]
        for site in self.sites:
            for code in message_sites.CODE.findall(site.text):
                with sheet.part(f"{site.path}:{site.line}: {site.text}"):
                    fits = [document_messages.scores(site.text, one)[:1] for one in (patterns, loose)]
                    assert not any(fits) or code in [best[0][1] for best in fits if best], \
                        f"{fits}; see the lines 'says' in src/run/messages"
