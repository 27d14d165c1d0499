# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Sizes of files, procedures, argument lists, types and folders, and the depth of nesting.

These tests warn: a size above its limit asks for a division by subjects, and no rule or mark excuses it. The last line
has the counts; pytest lists the places. Would catch (as a failure) only a counter that no longer counts.
"""

import re
import warnings
from collections import Counter

from sources import END_PROCEDURE, PROCEDURE, ROOT, TYPE, Module, lines_of, project_files, statements

LIMITS = {"lines of a file": 500, "lines of a procedure": 60, "arguments": 8, "arguments of a kernel": 10,
          "components": 16, "nested blocks": 4, "modules of a folder": 40}
OPENS = re.compile(
    r"^(?:\w+\s*:\s*)?(?:do(?:\s|$)|if\s*\(.*\)\s*then$|select\s|associate\s*\(|block$|critical$)"
    r"|^(?:where|forall)\s*\([^=]*\)$", re.I)
CLOSES = re.compile(r"^end\s*(?:do|if|select|associate|block|critical|where|forall)\b", re.I)


def without_strings(text):
    """A statement with empty strings, so that brackets and keywords in strings are not counted."""
    return re.sub(r'"[^"]*"|\'[^\']*\'', '""', text)


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


def types_and_nesting(path):
    """(line, name, measure, size) of the types of a file, and of its procedures the greatest depth of blocks."""
    inside_type, procedures = None, []
    for line, raw in statements(path):
        text = without_strings(raw)
        low = text.lower()
        if inside_type:
            if re.match(r"end\s*type\b", low):
                yield inside_type[1], inside_type[0], "components", inside_type[2]
                inside_type = None
            elif "::" in low and not re.match(r"(?:procedure|generic|final)\b", low):
                inside_type[2] += names_of(text)
        elif TYPE.match(low) and not low.startswith("type is"):
            inside_type = [TYPE.match(low).group(1), line, 0]
        elif END_PROCEDURE.match(low):
            name, first, _, deepest = procedures.pop()
            yield first, name, "nested blocks", deepest
        elif PROCEDURE.match(low) and not low.startswith("end"):
            procedures.append([PROCEDURE.match(low).group(2), line, 0, 0])
        elif procedures and (opens_block(text) or CLOSES.match(low)):
            procedures[-1][2] += 1 if opens_block(text) else -1
            procedures[-1][3] = max(procedures[-1][2:])


def too_large(path):
    """(line, name, measure, size) of what is above its limit in a file."""
    found = [(1, path.name, "lines of a file", len(lines_of(path)) - 1), *types_and_nesting(path)]
    for name, first, last, arguments, body in Module(path).procedures:
        kernel = any("contiguous" in text.lower() for _, text in body)
        found += [(first, name, "lines of a procedure", last - first + 1),
                  (first, name, "arguments of a kernel" if kernel else "arguments", len(arguments))]
    return [size for size in sorted(found) if size[3] > LIMITS[size[2]]]


def measures_in(source):
    """Measures and sizes above their limits of a source that is given as text."""
    path = ROOT / "build" / "sample_of_structure.f90"
    path.parent.mkdir(exist_ok=True)
    path.write_text(source, encoding="utf-8")
    try:
        return [(measure, size) for _, _, measure, size in too_large(path)]
    finally:
        path.unlink()


def test_counters():
    """Each measure is counted: it is found where it exceeds its limit, and not where it does not."""
    fields = "\n".join(f"real :: a{n}(2, 3), b{n} = 1.0" for n in range(9))
    assert measures_in(f"type :: large_t\n{fields}\nend type large_t\n") == [("components", 18)]
    many = "subroutine many(a, b, c, d, e, f, g, h, i)\n{}end subroutine many\n"
    assert measures_in(many.format("real, intent(in) :: a(:)\n")) == [("arguments", 9)]
    assert measures_in(many.format("real, contiguous, intent(in) :: a(:)\n")) == []
    assert measures_in(many.replace("i)", "i, j, k)").format("real, contiguous, intent(in) :: a(:)\n")) == [
        ("arguments of a kernel", 11)]
    assert measures_in(many.replace("h, i", "h").format("a = 1\n" * 59)) == [("lines of a procedure", 61)]
    assert measures_in("! a comment\n" * 501) == [("lines of a file", 501)]
    deep = "subroutine deep()\n" + "do n = 1, 2\n" * 4 + "{}" + "end do\n" * 4 + "end subroutine deep\n"
    assert measures_in(deep.format("domain = 1\nwhere (a > 0) b = c(1)\nif (x) y = 1\n")) == []
    for block, end in (("if (a > b) then", "if"), ("do", "do"), ("select case (n)", "select"),
                       ("associate (x => y)", "associate"), ("where (a > 0)", "where")):
        assert measures_in(deep.format(f"{block}\nend {end}\n")) == [("nested blocks", 5)], block


def test_sources():
    """Warn about what is too large, and print one line with the counts."""
    paths = project_files(".f90", under="src")
    assert len(paths) > 10
    found = [(path, *size) for path in paths for size in too_large(path)]
    found += [(folder, 1, folder.name, "modules of a folder", count)
              for folder, count in Counter(path.parent for path in paths).items()
              if count > LIMITS["modules of a folder"]]
    for path, line, name, measure, size in found:
        warnings.warn_explicit(f"{name}: {size} {measure}, more than {LIMITS[measure]}", UserWarning,
                               str(path.relative_to(ROOT)), line)
    counts = Counter(measure for *_, measure, _ in found)
    print("WARNING  " + ", ".join(f"{measure} > {limit}: {counts[measure]}" for measure, limit in LIMITS.items()),
          flush=True)
