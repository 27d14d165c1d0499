# SPDX-License-Identifier: BSD-3-Clause
"""Renumber the equations of doc/theory in the order of their pages, and update all citations.

    python3 scripts/number_equations.py            in the folder of the project, or with --root FOLDER

Give a new equation between (Y.5) and (Y.6) the number \\tag{Y.5a} and cite it as (Y.5a). The script renumbers
it to (Y.6) and the following one to (Y.7), in documents and in the comments of the sources. If a citation has no
equation, for example after an equation was deleted, the exit code is 1 and no file is changed.

Only the standard library is needed.
"""
import argparse
import re
import sys
from pathlib import Path

TAG = re.compile(r"\\tag\{([A-Z])\.(\d+[a-z]?)\}")
CITED = re.compile(r"\(([A-Z])\.(\d+[a-z]?)\)")
LEAVE_OUT = {".git", "build", "out", "node_modules", ".venv"}


def new_numbers(pages):
    """New number of each equation by its former one, and the letters of the pages."""
    numbers, count = {}, {}
    for page in pages:
        for letter, old in TAG.findall(page.read_text(encoding="utf-8")):
            count[letter] = count.get(letter, 0) + 1
            if (letter, old) in numbers:
                sys.exit(f"{page}: ({letter}.{old}) is given twice")
            numbers[letter, old] = str(count[letter])
    return numbers, set(count)


def renumber(path, numbers, letters, lost):
    """Text of a file with the new numbers. Citations without an equation are appended to `lost`."""
    def put(found, form):
        letter, old = found.groups()
        if letter not in letters:
            return found.group()
        if (letter, old) not in numbers:
            lost.append(f"{path}: ({letter}.{old}) is not there")
            return found.group()
        return form.format(letter, numbers[letter, old])

    def all_of(text):
        text = TAG.sub(lambda found: put(found, "\\tag{{{}.{}}}"), text)
        return CITED.sub(lambda found: put(found, "({}.{})"), text)

    text = path.read_text(encoding="utf-8")
    if path.suffix == ".f90":
        # only comments are changed: statements contain no citations, and texts of the program must stay the same
        return "\n".join(head + mark + all_of(tail) for head, mark, tail in
                         (line.partition("!") for line in text.split("\n")))
    # examples in documents are not changed either
    return "".join(part if part.startswith("`") else all_of(part) for part in re.split(r"(`[^`\n]*`)", text))


def main():
    """Renumber the pages, then all citations."""
    parser = argparse.ArgumentParser(prog="number_equations.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--root", type=Path, default=Path(__file__).resolve().parents[1])
    root = parser.parse_args().root
    numbers, letters = new_numbers(sorted((root / "doc" / "theory").glob("*.md")))
    files = sorted((root / "src").rglob("*.f90")) + sorted(
        path for path in root.rglob("*.md") if not LEAVE_OUT & set(path.relative_to(root).parts))
    lost = []
    changed = {path: renumber(path, numbers, letters, lost) for path in files}
    if lost:
        sys.exit("\n".join(lost))
    for path, text in changed.items():
        if text != path.read_text(encoding="utf-8"):
            path.write_text(text, encoding="utf-8")
            print(path.relative_to(root))


if __name__ == "__main__":
    main()
