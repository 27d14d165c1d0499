# SPDX-License-Identifier: BSD-3-Clause
"""The command scree-deck: decks of before in the names of today."""
import argparse
import sys

from . import __version__
from .command import Parser
from .deck_migrate import check_writing, table_of, with_includes, write
from .errors import EXIT_DIFFERENT, EXIT_USAGE, PostError, readable, unknown
from .errors import run as run_main
from .study import find_program

OVERVIEW = """usage: scree-deck COMMAND [options]

Rewrites decks of Scree.

  migrate      keys and words that are called otherwise now

scree-deck migrate --help lists its options, with examples."""
CODES = ("exit codes: 0 done, 1 somebody must decide and nothing is written, 2 command line wrong, "
         "3 file problem")
EXAMPLES = """examples:
  scree-deck migrate old.nml                 tell what would change
  scree-deck migrate old.nml --out new.nml   write it into another file
  scree-deck migrate old.nml --write         rewrite the deck and the files that it includes"""


def parser():
    """The parser of scree-deck migrate."""
    result = Parser(
        prog="scree-deck migrate", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Writes a deck in the names that keys and words have now, and its deck_version.\n"
        "Comments, layout and ends of lines stay. What the names were is asked of the program\n"
        "(scree --list former). Without --out and --write nothing is written.",
        epilog=f"{EXAMPLES}\n\n{CODES}")
    result.add_argument("deck", metavar="DECK", help="deck of before")
    way = result.add_mutually_exclusive_group()
    way.add_argument("--out", metavar="NEW.nml", help="file that is written; it must not be there yet")
    way.add_argument("--write", action="store_true", help="rewrite the deck and what it includes")
    result.add_argument("--scree", metavar="PROGRAM",
                        help="the program; default build/bin/scree or in the path")
    return result


def migrate(words):
    """scree-deck migrate; the result is the exit code."""
    arguments = parser().parse_args(words)
    files = with_includes(readable(arguments.deck), table_of(find_program(arguments.scree)))
    for one in files:
        for line, what in sorted(one.changes, key=lambda change: change[0]):
            print(f"{one.deck.path}:{line}: {what}")
    refused = [(one.deck.path, *why) for one in files for why in sorted(one.refused)]
    for path, line, why in refused:
        print(f"{path}:{line}: error: {why}", file=sys.stderr)
    changed = [one for one in files if one.changes]
    if refused:
        print(f"{arguments.deck}: nothing is written", file=sys.stderr)
        return EXIT_DIFFERENT
    if not changed:
        print(f"{arguments.deck}: nothing to change")
    if arguments.out:
        check_writing(files, arguments.out)
        write(files[0], arguments.out)
        print(f"wrote {arguments.out}")
    elif arguments.write:
        for one in changed:
            write(one, one.deck.path)
            print(f"wrote {one.deck.path}")
    elif changed:
        print("nothing is written; --write rewrites the deck, --out NEW.nml writes another file")
    return 0


def main(words=None):
    """Run a subcommand; the result is the exit code."""
    words = list(sys.argv[1:] if words is None else words)
    if words[:1] in (["-V"], ["--version"]):
        print(f"scree-deck {__version__}")
        return 0
    if words[:1] in (["-h"], ["--help"], ["help"]) and not words[1:]:
        print(f"{OVERVIEW}\n{CODES}")
        return 0
    if not words:
        raise PostError("which command? scree-deck --help lists them", EXIT_USAGE)
    if words[0] != "migrate":
        raise unknown("command", words[0], ["migrate"])
    return migrate(words[1:])


def run():
    """The program: errors are one line on standard error."""
    run_main(main, " ".join(["scree-deck", *sys.argv[1:2]]) if sys.argv[1:2] == ["migrate"] else "scree-deck")
