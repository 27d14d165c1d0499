# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Equations of the theory pages have numbers, and the sources that implement them cite these.

Would catch a number that is used twice or skipped, an equation without one, a number in the middle of a paragraph,
where it is not shown, an equation that no source implements (or whose source was renamed), a citation of a number that
no longer exists, a citation that does not name the page, a row of a table with a bar in its mathematics, which is split
into more cells than the table has, and a renumbering script that omits citations or changes examples and code.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

from sources import ROOT, lines_of, place, project_files

THEORY = ROOT / "doc" / "theory"
TAG = re.compile(r"\\tag\{([^}]*)\}")
CITED = re.compile(r"\(([A-Z])\.([1-9]\d*)\)")
DISPLAY = re.compile(r"\$\$(.*?)\$\$", re.S)
LINK = re.compile(r"\]\(([^)\s#]+)")
CODE = re.compile(r"`[^`\n]*`")


def blocks(path):
    """Pairs (line, contents) of the displayed equations of a page."""
    text = path.read_text(encoding="utf-8")
    return [(text.count("\n", 0, found.start()) + 1, found.group(1)) for found in DISPLAY.finditer(text)]


def comment_of(line):
    """The comment of a line of Fortran; quotes are respected."""
    quote = ""
    for position, letter in enumerate(line):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter == "!":
            return line[position:]
    return ""


PAGES = [path for path in sorted(THEORY.glob("*.md")) if any(TAG.search(text) for _, text in blocks(path))]
GIVEN = {path: [tag for _, text in blocks(path) for tag in TAG.findall(text)] for path in PAGES}
HOME = {tag[0]: path for path, tags in GIVEN.items() for tag in tags}
KNOWN = {tag for tags in GIVEN.values() for tag in tags}
DOCUMENTS = project_files(".md")


def citations(path, lines):
    """Triples (line, letter, number as text) of the citations in a file."""
    return [(at, found.group(1), ".".join(found.groups())) for at, line in enumerate(lines, 1)
            for found in CITED.finditer(line)]


def source_citations():
    """Citations in the comments of the sources, by file."""
    return {path: citations(path, [comment_of(line) for line in lines_of(path)])
            for path in project_files(".f90", under="src")}


class TestEquationGate:
    """One rule per test; all violations are listed."""

    def none(self, offences):
        assert len(offences) == 0, "\n" + "\n".join(offences)

    def test_equations_are_found(self):
        assert len(PAGES) > 10
        assert len(KNOWN) > 100
        assert sum(map(len, source_citations().values())) > 150

    def test_numbers(self):
        offences = []
        for path, tags in GIVEN.items():
            letter = tags[0][0]
            wanted = [f"{letter}.{n}" for n in range(1, len(tags) + 1)]
            offences += [f"{place(path, 1)} has {tag} where {right} is due" for tag, right in zip(tags, wanted)
                         if tag != right]
            if HOME[letter] != path:
                offences.append(f"{place(path, 1)} has the letter {letter} of {HOME[letter].name}")
        self.none(offences)

    def test_one_number_a_block(self):
        self.none([f"{place(path, line)} has {len(TAG.findall(text))} numbers in an equation"
                   for path in PAGES for line, text in blocks(path) if len(TAG.findall(text)) != 1])

    def test_blocks_are_paragraphs(self):
        offences = []
        for path in PAGES:
            text = path.read_text(encoding="utf-8")
            offences += [f"{place(path, text.count(chr(10), 0, found.start()) + 1)} has an equation inside of text"
                         for found in DISPLAY.finditer(text)
                         if text[:found.start()][-2:] != "\n\n" or text[found.end():][:2] not in ("\n\n", "\n")]
        self.none(offences)

    def test_no_number_elsewhere(self):
        offences = []
        for path in DOCUMENTS:
            outside = DISPLAY.sub(lambda found: "\n" * found.group().count("\n"),
                                  CODE.sub("", path.read_text(encoding="utf-8")))
            offences += [f"{place(path, at)} has a number outside of a displayed equation"
                         for at, line in enumerate(outside.split("\n"), 1) if TAG.search(line)]
        self.none(offences)

    def test_citations_of_sources(self):
        offences = []
        for path, found in source_citations().items():
            text = path.read_text(encoding="utf-8")
            for at, letter, number in found:
                if number not in KNOWN:
                    offences.append(f"{place(path, at)} cites ({number}), which is not there")
                elif f"doc/theory/{HOME[letter].name}" not in text:
                    offences.append(f"{place(path, at)} cites ({number}) but does not name doc/theory/"
                                    f"{HOME[letter].name}")
        self.none(offences)

    def test_every_equation_is_implemented(self):
        cited = {number for found in source_citations().values() for _, _, number in found}
        self.none([f"no source cites ({tag}) of {path.relative_to(ROOT)}" for path, tags in GIVEN.items()
                   for tag in tags if tag not in cited])

    def test_citations_of_documents(self):
        offences = []
        for path in DOCUMENTS:
            linked = {(path.parent / target).resolve() for line in lines_of(path) for target in LINK.findall(line)}
            for at, letter, number in citations(path, [CODE.sub("", line) for line in lines_of(path)]):
                if number not in KNOWN:
                    offences.append(f"{place(path, at)} cites ({number}), which is not there")
                elif path != HOME[letter] and HOME[letter] not in linked:
                    offences.append(f"{place(path, at)} cites ({number}) without a link to {HOME[letter].name}")
        self.none(offences)

    def test_script_that_numbers(self):
        script = [sys.executable, ROOT / "scripts" / "number_equations.py", "--root"]
        page = "$$a\\tag{Z.1}$$ and $$b\\tag{Z.1a}$$\n$$c\\tag{Z.2}$$ (Z.1a) (Z.2) `(Z.2)`, see (B.2)\n"
        source = 'call say("(Z.2)", 1)   ! (Z.2)\n!> Equations (Z.1), (Z.1a) and (Z.2).\n'
        with tempfile.TemporaryDirectory() as folder:
            theory, code = Path(folder) / "doc" / "theory", Path(folder) / "src"
            theory.mkdir(parents=True)
            code.mkdir()
            (theory / "zeta.md").write_text(page, encoding="utf-8")
            (code / "zeta.f90").write_text(source, encoding="utf-8")
            subprocess.run([*script, folder], check=True, capture_output=True)
            assert (theory / "zeta.md").read_text(
                encoding="utf-8"
            ) == "$$a\\tag{Z.1}$$ and $$b\\tag{Z.2}$$\n$$c\\tag{Z.3}$$ (Z.2) (Z.3) `(Z.2)`, see (B.2)\n"
            assert (code / "zeta.f90").read_text(
                encoding="utf-8"
            ) == 'call say("(Z.2)", 1)   ! (Z.3)\n!> Equations (Z.1), (Z.2) and (Z.3).\n'
            (code / "zeta.f90").write_text(source.replace("Z.1a", "Z.7"), encoding="utf-8")
            answer = subprocess.run([*script, folder], capture_output=True, text=True)
            assert answer.returncode == 1
            assert "(Z.7) is not there" in answer.stderr

    def test_tables(self):
        offences = []
        for path in DOCUMENTS:
            columns, inside, example = 0, False, False
            for at, line in enumerate(lines_of(path), 1):
                example ^= line.startswith("```")
                if example or not line.startswith("|"):
                    inside = False
                    continue
                cells = line.count("|") - line.count(r"\|") - 1
                if inside and cells != columns:
                    offences.append(f"{place(path, at)} has {cells} cells, its table {columns}")
                if not inside:
                    columns, inside = cells, True
        self.none(offences)
