# SPDX-License-Identifier: BSD-3-Clause
"""The command scree-post: finds the subcommand, reads its options, runs it."""
from __future__ import annotations

import argparse
import importlib
import re
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NoReturn

from scree.errors import EXIT_USAGE, ScreeError, modules, unknown

from . import __version__
from .commands import COMMANDS
from .errors import run as run_main

if TYPE_CHECKING:
    from types import ModuleType

CODES = "exit codes: 0 success, 1 a difference or a failure, 2 wrong command line, 3 file problem"


class Parser(argparse.ArgumentParser):
    """A parser that reports errors in one line, and accepts -10mm as a number."""

    def __init__(self, *words: Any, **options: Any) -> None:
        super().__init__(*words, **{"allow_abbrev": False, **options})
        self._negative_number_matcher = re.compile(r"-\.?\d")

    def error(self, message: str) -> NoReturn:
        """Raise a one-line error, with the closest option for an unknown one."""
        wrong = re.match(r"unrecognized arguments: (--[\w-]+)", message)
        if wrong:
            known = [text for action in self._actions for text in action.option_strings]
            raise unknown("option", wrong.group(1), [text for text in known if text[:2] == "--"])
        raise ScreeError(f"{message}; see {self.prog} --help", EXIT_USAGE)


def load(name: str) -> ModuleType:
    """The module of a subcommand."""
    modules("numpy", "h5py")
    return importlib.import_module(f"{__package__}.commands.{name}")


def overview() -> str:
    """Text of scree-post --help."""
    lines = ["usage: scree-post COMMAND [options]", "",
             "Reads, draws and compares what Scree writes.", ""]
    lines += [f"  {name:<12} {load(name).SUMMARY}" for name in COMMANDS]
    lines += ["", "scree-post COMMAND --help lists the options of one, with examples.", CODES]
    return "\n".join(lines)


def parser_of(name: str, module: ModuleType) -> Parser:
    """The parser of a subcommand."""
    examples = "\n".join(f"  scree-post {line}" for line in module.EXAMPLES)
    result = Parser(prog=f"scree-post {name}", description=module.__doc__,
                    formatter_class=argparse.RawDescriptionHelpFormatter,
                    epilog=f"examples:\n{examples}\n\n{CODES}")
    module.add_arguments(result)
    return result


def name_in(words: Sequence[str]) -> str:
    """The subcommand at the start of the words, if there is one."""
    return words[0] if words and words[0] in COMMANDS else ""


def main(words: list[str] | None = None) -> int | None:
    """Run a subcommand; the result is the exit code."""
    words = list(sys.argv[1:] if words is None else words)
    if words[:1] in (["-V"], ["--version"]):
        print(f"scree-post {__version__}")
        return 0
    if words[:1] in (["-h"], ["--help"], ["help"]) and not words[1:]:
        print(overview())
        return 0
    if not words:
        raise ScreeError("which command? scree-post --help lists them", EXIT_USAGE)
    if not name_in(words):
        raise unknown("command", words[0], COMMANDS)
    name, *rest = words
    module = load(name)
    code: int | None = module.run(parser_of(name, module).parse_args(rest))
    return code


def run() -> None:
    """The program: errors are one line on standard error."""
    words = sys.argv[1:]
    run_main(main, f"scree-post {name_in(words)}".strip())
