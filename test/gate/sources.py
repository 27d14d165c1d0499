# SPDX-License-Identifier: BSD-3-Clause
"""The files of the project, and what the gates need to know about Fortran."""

import os
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LEAVE_OUT = {".mypy_cache", ".ruff_cache", ".pytest_cache", ".git", "build", "out", "__pycache__", ".venv"}
# Folders of src/ that the gates on words and on the size of types cover.
COVERED = ("base", "ddmp", "deck", "exact", "io", "material", "mesh", "output", "particle", "program", "run", "sample",
           "scene", "step", "transfer")
TEXT = {".f90", ".pf", ".in", ".py", ".sh", ".cmake", ".txt", ".md", ".nml", ".toml", ""}

PROCEDURE = re.compile(
    r"^(?:(?:pure|impure|elemental|recursive|module|integer|real|complex|logical|character|type|class)"
    r"(?:\s*\([^()]*(?:\([^()]*\)[^()]*)*\))?\s+)*(subroutine|function)\s+(\w+)", re.I)
END_PROCEDURE = re.compile(r"^end\s*(subroutine|function)\b", re.I)
TYPE = re.compile(r"^type\s*(?:,[^:]*)?(?:::)?\s*(\w+)$", re.I)


def project_files(*suffixes, under=""):
    """All files of the project with one of the suffixes (all text files without), sorted."""
    wanted = set(suffixes) or TEXT
    found = []
    for folder, folders, names in os.walk(ROOT / under):
        # not even looked into: tests that run at the same time create and remove folders there
        folders[:] = set(folders) - LEAVE_OUT
        paths = [Path(folder, name) for name in names]
        found += [path for path in paths if path.suffix in wanted and path.is_file()]
    return sorted(found)


def place(path, number):
    """Path and line as text that an editor can follow."""
    return f"{path.relative_to(ROOT)}:{number}"


def lines_of(path):
    """The lines of a file, without their ends."""
    return path.read_text(encoding="utf-8").split("\n")


def code_of(line):
    """A line without its comment and without leading and trailing blanks; quotes are respected."""
    quote = ""
    for position, letter in enumerate(line):
        if quote:
            if letter == quote:
                quote = ""
        elif letter in "\"'":
            quote = letter
        elif letter == "!":
            return line[:position].strip()
    return line.strip()


def statements(path):
    """Pairs (number of the first line, statement) with continuation lines joined."""
    result, text, first = [], "", 0
    for number, line in enumerate(lines_of(path), 1):
        code = code_of(line)
        if not code:
            continue
        if not text:
            first = number
        text += code.lstrip("&").strip() if text else code
        if text.endswith("&"):
            text = text[:-1].rstrip() + " "
            continue
        result.append((first, text))
        text = ""
    return result


def declared_names(text):
    """Names that a declaration declares, without their shapes and values."""
    text = re.sub(r"\"[^\"]*\"|'[^']*'", "", text.split("::", 1)[1])
    bare = ""
    while text != bare:
        text, bare = re.sub(r"\([^()\[\]]*\)|\[[^()\[\]]*\]", "", text), text
    return [re.match(r"\s*(\w+)", part).group(1) for part in text.split(",")]


class Module:
    """One module: its types, its procedures, what is public and what types bind."""

    def __init__(self, path):
        self.path = path
        self.name = ""
        self.public, self.bindings = set(), {}
        self.types = []  # (name, line)
        self.procedures = []  # (name, first line, last line, arguments, statements)
        self.uses = []  # (name, line, statement)
        self.variables = []  # (line, statement) of the specification part
        self.implicit_none = 0
        self.private = False
        self._scan(statements(path))

    def _scan(self, all_statements):
        stack, blocks, contained = [], [], False
        for line, text in all_statements:
            low = text.lower()
            self._global(low, line, stack, blocks)
            if PROCEDURE.match(low) and not low.startswith("end"):
                name = PROCEDURE.match(low).group(2)
                arguments = re.search(r"\b%s\s*\(([^)]*)\)" % name, low)
                names = re.findall(r"\w+", arguments.group(1)) if arguments else []
                stack.append((name, line, names, [], bool(blocks)))
            elif END_PROCEDURE.match(low) and stack:
                name, first, names, body, in_interface = stack.pop()
                if not stack and not in_interface:
                    self.procedures.append((name, first, line, names, body))
            elif stack:
                stack[-1][3].append((line, text))
            elif re.match(r"(abstract\s+)?interface\b", low):
                blocks.append("interface")
            elif TYPE.match(low) and not low.startswith("type is"):
                blocks.append("type")
                self.types.append((TYPE.match(low).group(1), line))
                if ", public" in low or ",public" in low:
                    self.public.add(TYPE.match(low).group(1))
            elif re.match(r"end\s*(interface|type)\b", low) and blocks:
                blocks.pop()
            elif low == "contains" and not blocks:
                contained = True
            elif not blocks and not contained and "::" in low:
                self._declaration(low, line, text)
            elif blocks[-1:] == ["type"] and re.match(r"(procedure|generic|final)\b", low):
                names = re.findall(r"\w+", low.split("=>")[-1].split("::")[-1])
                self.bindings.setdefault(self.types[-1][0], set()).update(names)

    def interface(self):
        """Names of the procedures that other modules can call: public ones, and those bound to public types."""
        names = set(self.public)
        for name, bound in self.bindings.items():
            if name in self.public:
                names |= bound
        return names

    def _global(self, low, line, stack, blocks):
        found = re.match(r"module\s+(\w+)$", low)
        if found and not stack:
            self.name = found.group(1)
        if low == "implicit none":
            self.implicit_none += 1
        if low == "private" and not stack and not blocks:
            self.private = True
        found = re.match(r"use\b(?:\s*,\s*(?:non_)?intrinsic\s*::)?\s*(?:::)?\s*(\w+)", low)
        if found:
            self.uses.append((found.group(1), line, low))

    def _declaration(self, low, line, text):
        if low.startswith("public"):
            self.public |= set(re.findall(r"\w+", low.split("::")[1]))
        elif re.search(r",\s*public\b", low.split("::")[0]):
            self.public |= set(declared_names(low))
        elif not low.startswith(("use", "import", "private")) and "parameter" not in low:
            self.variables.append((line, text))
