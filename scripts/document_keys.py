# SPDX-License-Identifier: BSD-3-Clause
"""Write doc/reference/keys.md, the tables of all groups and keys of a deck and of the fields of single models, from the
output of scree.

    python3 scripts/document_keys.py build/bin/scree             write the file
    python3 scripts/document_keys.py build/bin/scree --check     exit code 1 if it is out of date

Only the standard library is needed.
"""
import argparse
import itertools
import re
import subprocess
import sys
from pathlib import Path

TARGET = Path(__file__).resolve().parents[1] / "doc" / "reference" / "keys.md"
HEAD = """# Groups and keys

This file is written by [scripts/document_keys.py](../../scripts/document_keys.py) from
`scree --explain`; do not edit it. [The deck](../guide/deck.md) describes the syntax of decks.
`scree --template` prints the same keys as a deck, `scree --explain GROUP.KEY` explains one key.

The units are those of SI; with `&units system` numbers are in the units of that system. **must** in
the column of defaults marks keys that have no default and must be given. *Needs* lists the settings
that a key requires; it is an error to give a key without them.
"""


def ask(program, *arguments):
    """Output of the program as lines."""
    answer = subprocess.run([program, *arguments], capture_output=True, text=True, check=True)
    return answer.stdout.strip("\n").split("\n")


def cell(text):
    """Text that can stand in a cell of a Markdown table."""
    return text.replace("|", "\\|")


def code(text):
    """Text as code, empty if there is none."""
    return f"`{cell(text)}`" if text else ""


def sentence(text):
    """The text with a capital letter at the beginning and a full stop at the end."""
    return text[0].upper() + text[1:] + "."


def row(program, group, key):
    """The line of a key in the table of its group."""
    head, *rest = ask(program, "--explain", f"{group}.{key}")
    meaning = head.split(None, 1)[1]
    about, needs = {}, []
    for line in rest:
        name, _, value = line.strip().partition(": ")
        if name == "needs":
            needs.append(code(value))
        else:
            about[name] = value
    kind = about["kind"]
    unit = about.get("unit", "").replace(", or that of &units system", "")
    if unit:
        kind += f" [{unit}]"
    if "range" in about:
        kind += f" {about['range']}"
    if "one of" in about:
        meaning += "; one of " + ", ".join(code(word) for word in about["one of"].split())
    if "refers to" in about:
        meaning += f"; the {about['refers to']}"
    if needs:
        meaning += ". *Needs* " + " and ".join(needs)
    default = "**must**" if "must be given" in about else code(
        "" if about["default"] == "none" else about["default"])
    return f"| `{key}` | {cell(kind)} | {default} | {meaning} |"


def document(program):
    """The whole file."""
    groups = re.findall(r"^(?:! )?&(\w+)", "\n".join(ask(program, "--template")), re.M)
    lines = [HEAD]
    for group in groups:
        said = ask(program, "--explain", group)
        # if a key has the same name as a group, the program explains both
        place = next(n for n, line in enumerate(said) if line.startswith(f"&{group} "))
        lines += [f"## &{group}", "", sentence(said[place].split(None, 1)[1]), ""]
        keys = [line.split()[0] for line in itertools.takewhile(lambda line: line.startswith(" "), said[place + 1:])]
        if not keys:
            continue
        lines += ["| key | kind, range | default | meaning |", "|---|---|---|---|"]
        lines += [row(program, group, key) for key in keys]
        lines.append("")
    lines += ["## Fields of single models", "", "Words of `fields` in addition to those of "
              "[Output](output.md#snapshots), each stored only with its models.", "",
              "| field | unit | meaning | models |", "|---|---|---|---|"]
    lines += [f"| `{name}` | {unit} | {cell(meaning)} | {cell(models)} |" for name, unit, meaning, models in
              re.findall(r"^   (\w+) \[(.*?)\]  (.*); (.*)$", "\n".join(ask(program, "--list", "fields")), re.M)]
    lines.append("")
    return "\n".join(lines)


def main():
    """Write the file, or compare it."""
    parser = argparse.ArgumentParser(prog="document_keys.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("program", metavar="SCREE", help="path of the program")
    parser.add_argument("--check", action="store_true", help="compare the file without writing")
    arguments = parser.parse_args()
    text = document(arguments.program)
    if not arguments.check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    if TARGET.exists() and TARGET.read_text(encoding="utf-8") == text:
        return 0
    print(f"{TARGET.name} is out of date; run scripts/document_keys.py", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main())
