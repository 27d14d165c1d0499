#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Translate pFUnit files (.pf) to plain Fortran, for machines without pFUnit.

    translate.py FOLDER PROGRAM test_a.pf test_b.pf ...

writes into FOLDER each module with its directives expanded, line by line, and PROGRAM.f90, which runs the tests of all
modules, or of those that its arguments name. A file whose content is the same as before is not written.
Supported are @test, @test(npes=[1,2]), @before, @after, @assertEqual, @assertTrue, @assertFalse,
@assertLessThan and @assertGreaterThan, as pFUnit 4 has them: a directive stands on one line, and
the subroutine that it marks begins on the next line. Everything else is an error.
`translate.py --check FILE ...` only looks for errors.
"""

import re
import sys
from pathlib import Path

OPERANDS = {"equal": 2, "true": 1, "false": 1, "lessthan": 2, "greaterthan": 2}
KEYWORDS = {"equal": {"tolerance", "message"}}
SUBROUTINE = re.compile(r"\s*subroutine\s+(\w+)\s*(?:\(\s*(\w*)\s*\))?\s*(?:!.*)?$", re.I)
LONGEST = 128  # so that the code that pFUnit generates for a directive fits in the 132 columns of Fortran


class TranslationError(Exception):
    """A line that the translator does not understand."""


def split_arguments(text):
    """Split at the commas that are in no bracket and no quotes."""
    parts, depth, quote, start = [], 0, "", 0
    for place, letter in enumerate(text):
        if quote:
            if letter == quote:
                quote = ""
        elif letter in "\"'":
            quote = letter
        elif letter in "([":
            depth += 1
        elif letter in ")]":
            depth -= 1
            if depth < 0:
                raise TranslationError("a bracket is closed that was not opened")
        elif letter == "," and depth == 0:
            parts.append(text[start:place].strip())
            start = place + 1
    if quote or depth:
        raise TranslationError("a bracket or a quote is not closed")
    parts.append(text[start:].strip())
    return parts


class Translator:
    """Reads the lines of one file."""

    def __init__(self, path):
        self.path = Path(path)
        self.module = ""
        self.tests = []  # (name, list of ranks or None)
        self.fixtures = {}  # "before" and "after"
        self.pending = None  # role of the subroutine in the next line
        self.lines = []

    def run(self):
        """Translate all lines and check the whole."""
        text = self.path.read_text(encoding="utf-8")
        for number, line in enumerate(text.splitlines(), 1):
            try:
                self.lines.append(self.translate(line, number))
            except TranslationError as error:
                raise TranslationError(f"{self.path}:{number}: {error}") from None
        try:
            self.check_whole()
        except TranslationError as error:
            raise TranslationError(f"{self.path}: {error}") from None

    def translate(self, line, number):
        """Translate one line into one line, so that line numbers are kept."""
        if self.pending:
            return self.marked_subroutine(line)
        if not line.lstrip().startswith("@"):
            found = re.match(r"\s*module\s+(\w+)\s*$", line, re.I)
            if found and found.group(1).lower() != "procedure":
                self.module = found.group(1)
            return line
        if len(line) > LONGEST:
            raise TranslationError(f"a directive has at most {LONGEST} columns")
        return self.directive(line, number)

    def directive(self, line, number):
        """Expand one directive."""
        found = re.match(r"\s*@(\w+)\s*(?:\((.*)\))?\s*$", line)
        if not found:
            raise TranslationError(f"not a directive on one line: {line.strip()}")
        name, arguments = found.group(1).lower(), found.group(2)
        if name == "test":
            self.pending = ("test", self.ranks(arguments))
            return ""
        if name in ("before", "after"):
            if arguments is not None:
                raise TranslationError(f"@{name} has no arguments")
            if name in self.fixtures:
                raise TranslationError(f"@{name} stands twice in this file")
            self.pending = (name, None)
            return ""
        if name.startswith("assert") and name[6:] in OPERANDS:
            return self.assertion(found.group(1), arguments or "", number)
        raise TranslationError(f"the directive @{found.group(1)} is not supported")

    @staticmethod
    def ranks(arguments):
        """The numbers of ranks in @test(npes=[1,2])."""
        if arguments is None:
            return None
        found = re.match(r"\s*npes\s*=\s*\[([\d,\s]+)\]\s*$", arguments, re.I)
        if not found:
            raise TranslationError("only @test and @test(npes=[1,2]) are supported")
        ranks = [int(number) for number in found.group(1).split(",")]
        if min(ranks) < 1 or max(ranks) > 16:
            raise TranslationError("a test runs on 1 to 16 ranks")
        return ranks

    def assertion(self, name, arguments, number):
        """The call of the assertion, and the return from the test if it has failed."""
        kind = name[6:].lower()
        parts = split_arguments(arguments)
        operands = OPERANDS[kind]
        if len(parts) < operands or not all(parts):
            raise TranslationError(f"@{name} has {operands} arguments")
        for part in parts[operands:]:
            keyword = re.match(r"(\w+)\s*=(?!=)", part)
            allowed = KEYWORDS.get(kind, {"message"})
            if not keyword or keyword.group(1).lower() not in allowed:
                raise TranslationError(f"@{name}: '{part}' is none of: {', '.join(sorted(allowed))}")
        place = f'location=sourcelocation("{self.path.name}", {number})'
        return f"call {name}({arguments}, {place}); if (anyexceptions()) return"

    def marked_subroutine(self, line):
        """The line after @test, @before or @after."""
        kind, ranks = self.pending
        self.pending = None
        found = SUBROUTINE.match(line)
        if not found:
            raise TranslationError(f"the line after @{kind} must begin a subroutine")
        name, argument = found.group(1), found.group(2)
        if kind == "test":
            if bool(argument) != (ranks is not None):
                raise TranslationError("a test has one argument if, and only if, it has npes")
            if name.lower() in (known.lower() for known, _ in self.tests):
                raise TranslationError(f"there are two tests {name}")
            self.tests.append((name, ranks))
        else:
            self.fixtures[kind] = name
        return line

    def check_whole(self):
        """Checks that need the whole file."""
        if self.pending:
            raise TranslationError(f"nothing follows @{self.pending[0]}")
        if self.module.lower() != self.path.stem.lower():
            raise TranslationError(f"the module must be named {self.path.stem}")
        if not self.tests:
            raise TranslationError("there is no test in this file")
        if self.fixtures and len({ranks is None for _, ranks in self.tests}) == 2:
            raise TranslationError("with @before or @after all tests have npes, or none has")

    def module_text(self):
        """The module; messages of the compiler refer to lines of the .pf file."""
        return f'# 1 "{self.path}"\n' + "\n".join(self.lines) + "\n"


def program_text(name, translators):
    """The program that runs the tests of all modules."""
    parallel = any(ranks for one in translators for _, ranks in one.tests)
    uses, calls = [], []
    for one in translators:
        # tests of two modules may have the same name
        local = {known: f"t{len(uses) + number}_{known}"[:63] for number, known in
                 enumerate([known for known, _ in one.tests] + list(one.fixtures.values()))}
        uses += [f"   use {one.module}, only: {alias} => {known}" for known, alias in local.items()]
        fixtures = "".join(f", {kind}={local[known]}" for kind, known in one.fixtures.items())
        calls.append(f'   if (is_wanted("{one.module}")) then')
        for known, ranks in one.tests:
            if ranks is None:
                call = "run_on_root" if parallel else "run_test"
                calls.append(f'      call {call}(summary, "{known}", {local[known]}{fixtures})')
            calls += [f'      call run_on_ranks(summary, "{known}", {local[known]}, {number}{fixtures})'
                      for number in ranks or []]
        calls.append("   end if")
    text = ["! SPDX-License-Identifier: BSD-3-Clause", f"program {name}"]
    if parallel:
        text.append("   use pfunit_runner, only: finish_ranks, run_on_ranks, run_on_root, start_ranks")
        text.append("   use funit_runner, only: is_wanted, summary_t")
    else:
        text.append("   use funit_runner, only: finish_tests, is_wanted, run_test, summary_t")
    text += [*uses, "   implicit none", "   type(summary_t) :: summary", ""]
    if parallel:
        text.append("   call start_ranks()")
    text += calls
    text += ["   call finish_ranks(summary)" if parallel else "   call finish_tests(summary)", f"end program {name}"]
    return "\n".join(text) + "\n"


def write(path, text):
    """Write a file if its content changes, so that only then it is compiled."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def main(arguments):
    """Translate, or check, from the command line."""
    check = arguments[:1] == ["--check"]
    if not check and len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    translators, errors = [], 0
    for source in arguments[1:] if check else arguments[2:]:
        translator = Translator(source)
        try:
            translator.run()
        except (TranslationError, OSError) as error:
            print(error, file=sys.stderr)
            errors += 1
            continue
        translators.append(translator)
    if errors:
        return 1
    if not check:
        folder, name = Path(arguments[0]), arguments[1]
        for translator in translators:
            write(folder / f"{translator.module}.f90", translator.module_text())
        write(folder / f"{name}.f90", program_text(name, translators))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
