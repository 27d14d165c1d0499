# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Types, argument lists, nesting and folders are small enough to be read.

Would catch a type with components of unrelated purposes, a procedure with too many arguments, deeply nested loops and
conditions, and a folder with too many modules.
"""

import re
import warnings
from collections import Counter

from sources import COVERED, END_PROCEDURE, PROCEDURE, ROOT, TYPE, lines_of, place, project_files, statements

COMPONENTS, ARGUMENTS, NESTING, MODULES = 16, 10, 4, 40
# Marks in comments directly above a type or a procedure that allow an exception, each with its reason.
HEADER_RECORD = "! gate: header record because "
LONG_KERNEL = "! gate: long kernel because "
OPENS = re.compile(
    r"^(?:\w+\s*:\s*)?(?:do(?:\s|$)|if\s*\(.*\)\s*then$|select\s|associate\s*\(|block$|critical$)"
    r"|^(?:where|forall)\s*\([^=]*\)$", re.I)
CLOSES = re.compile(r"^end\s*(?:do|if|select|associate|block|critical|where|forall)\b", re.I)


def without_strings(text):
    """A statement with empty strings, so that brackets and keywords in strings are not counted."""
    return re.sub(r'"[^"]*"|\'[^\']*\'', '""', text)


def is_marked(lines, line, marker):
    """True if the comment lines directly above a statement contain a mark."""
    above = line - 2
    while above >= 0 and lines[above].lstrip().startswith("!"):
        if marker in lines[above]:
            return True
        above -= 1
    return False


def names_of(declaration):
    """Number of names in a declaration of components."""
    depth, names = 0, 1
    for letter in declaration.split("::", 1)[1]:
        depth += (letter in "([") - (letter in ")]")
        names += letter == "," and depth == 0
    return names


def opens_block(text):
    """True for a statement that begins an inner block; a masked assignment of one line is not one."""
    if re.match(r"where\s*\(", text, re.I):
        depth = 0
        for position, letter in enumerate(text):
            depth += (letter == "(") - (letter == ")")
            if letter == ")" and depth == 0:
                return position == len(text) - 1
    return bool(OPENS.match(text))


def offences_of(path):
    """Pairs (line, message) of one file."""
    lines = lines_of(path)
    found, inside_type, procedures = [], None, []
    for line, raw in statements(path):
        text = without_strings(raw)
        low = text.lower()
        if inside_type:
            if re.match(r"end\s*type\b", low):
                name, first, count = inside_type
                if count > COMPONENTS and not is_marked(lines, first, HEADER_RECORD):
                    found.append((first, f"type {name} has {count} components, limit {COMPONENTS}"))
                inside_type = None
            elif "::" in low and not re.match(r"(?:procedure|generic|final)\b", low):
                inside_type[2] += names_of(text)
        elif TYPE.match(low) and not low.startswith("type is"):
            inside_type = [TYPE.match(low).group(1), line, 0]
        elif END_PROCEDURE.match(low):
            procedures.pop()
        elif PROCEDURE.match(low) and not low.startswith("end"):
            name = PROCEDURE.match(low).group(2)
            arguments = re.search(r"\b%s\s*\(([^)]*)\)" % name, low)
            count = len(re.findall(r"\w+", arguments.group(1))) if arguments else 0
            if count > ARGUMENTS and not is_marked(lines, line, LONG_KERNEL):
                found.append((line, f"{name} has {count} arguments, limit {ARGUMENTS}"))
            procedures.append([name, 0])
        elif procedures and opens_block(text):
            procedures[-1][1] += 1
            if procedures[-1][1] > NESTING:
                found.append((line, f"{procedures[-1][0]} nests {procedures[-1][1]} blocks, limit {NESTING}: {text}"))
        elif procedures and CLOSES.match(low):
            procedures[-1][1] -= 1
    return found


class TestStructure:
    """All violations are listed."""

    def offences_in(self, source):
        """Messages on a source that is given as text."""
        path = ROOT / "build" / "sample_of_structure.f90"
        path.parent.mkdir(exist_ok=True)
        path.write_text(source, encoding="utf-8")
        try:
            return [message for _, message in offences_of(path)]
        finally:
            path.unlink()

    def test_samples(self):
        """The gate itself: each limit is found where it is exceeded, and a mark with a reason is accepted."""
        fields = "\n".join(f"real :: a{n}(2, 3), b{n} = 1.0" for n in range(9))
        large = f"type :: large_t\n{fields}\nend type large_t\n"
        assert self.offences_in(large) == ["type large_t has 18 components, limit 16"]
        assert self.offences_in(HEADER_RECORD + "it is the head of a file\n" + large) == []
        many = "subroutine many(a, b, c, d, e, f, g, h, i, j, k)\nend subroutine many\n"
        assert self.offences_in(many) == ["many has 11 arguments, limit 10"]
        assert self.offences_in(LONG_KERNEL + "it is one\n" + many) == []
        deep = "subroutine deep()\n" + "do n = 1, 2\n" * 4 + "{}" + "end do\n" * 4 + "end subroutine deep\n"
        assert self.offences_in(deep.format("domain = 1\nwhere (a > 0) b = c(1)\nif (x) y = 1\n")) == []
        for block, end in (("if (a > b) then", "if"), ("do", "do"), ("select case (n)", "select"),
                           ("associate (x => y)", "associate"), ("where (a > 0)", "where")):
            assert len(self.offences_in(deep.format(f"{block}\nend {end}\n"))) == 1, block

    def test_sources(self):
        paths = [path for folder in COVERED for path in project_files(".f90", under=f"src/{folder}")]
        assert len(paths) > 10
        found = [f"{place(path, line)} {message}" for path in paths
                 for line, message in offences_of(path)]
        assert len(found) == 0, "\n" + "\n".join(found)

    def test_modules_of_a_folder(self):
        """Warns only: a room is divided by its subjects, so a count does not decide where a module goes."""
        counts = Counter(path.parent for path in (ROOT / "src").rglob("*.f90"))
        for folder, count in sorted(counts.items()):
            if count > MODULES:
                warnings.warn(f"{folder} has {count} modules, more than {MODULES}: divide it by subjects", stacklevel=1)
