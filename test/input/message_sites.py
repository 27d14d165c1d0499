# SPDX-License-Identifier: BSD-3-Clause
"""Messages of the program as its sources compose them.

    for site in sites(root): print(site.path, site.line, site.text)

A site is a call that reports an error or a warning, or an assignment of a message to a variable; its text has `...` in
place of each variable.
"""

import re
from typing import NamedTuple

# Procedures that report or create an error or a warning.
REPORTS = {"add_error", "warn", "error", "warning", "fail", "command_line_error", "fail_reading", "fail_path",
           "fail_at", "fail_check", "refuse", "refuse_key", "set_fault", "warn_of_particle"}
CALL = re.compile(r"\bcall\s+((?:\w+(?:\([^()]*\))?\s*%\s*)*)(\w+)\s*\(", re.I)
# Variables that hold the text of a message until it is reported.
WORDS = re.compile(r"(?:^|\)\s*)(?:fault|problem|doubt)\s*=(?!=)", re.I)
# The result variables of functions with these names.
RESULT = re.compile(r"(?:^|\)\s*)text\s*=(?!=)", re.I)
FUNCTION = re.compile(r"^(?!end).*\bfunction\s+(\w+)", re.I)
LITERAL = re.compile(r'"((?:[^"]|"")*)"')
FEWEST = 2                       # a text with at least this many words in quotes is a message


class Site(NamedTuple):
    """A call that reports a message."""

    path: str
    line: int
    text: str


def statements(source):
    """Statements of a source with the numbers of their first lines, continuation lines joined, comments removed."""
    joined, first = "", 0
    for number, line in enumerate(source.splitlines(), 1):
        code = re.sub(r"""^((?:[^"'!]|"[^"]*"|'[^']*')*)!.*""", r"\1", line).strip()
        if not code:
            continue
        first = first or number
        code = code.removeprefix("&").lstrip() if joined else code
        if code.endswith("&"):
            joined += code[:-1]
            continue
        yield first, joined + code
        joined, first = "", 0


def arguments(text):
    """Arguments of a call, from the position after its opening bracket."""
    found, depth, start, quote = [], 0, 0, ""
    for place, letter in enumerate(text):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in "([":
            depth += 1
        elif letter in ")]" and depth:
            depth -= 1
        elif letter == ")" or (letter == "," and not depth):
            found.append(text[start:place])
            start = place + 1
            if letter == ")":
                break
    return found


def shape(argument):
    """A concatenation with `...` in place of all parts that are not in quotes."""
    parts, depth, start, quote = [], 0, 0, ""
    for place, letter in enumerate(argument):
        if quote:
            quote = "" if letter == quote else quote
        elif letter in "\"'":
            quote = letter
        elif letter in "([":
            depth += 1
        elif letter in ")]":
            depth -= 1
        elif argument[place:place + 2] == "//" and not depth:
            parts.append(argument[start:place].strip())
            start = place + 2
    parts.append(argument[start:].strip())
    text = ""
    for part in parts:
        whole = LITERAL.fullmatch(part)
        text += whole.group(1).replace('""', '"') if whole else "..."
    return re.sub(r"(\.\.\.){2,}", "...", text)


def sites(root):
    """All calls that report a message with a text of their own."""
    for path in sorted((root / "src").rglob("*.f90")):
        inside = False
        for line, statement in statements(path.read_text(encoding="utf-8")):
            for call in CALL.finditer(statement):
                if call.group(2).lower() not in REPORTS:
                    continue
                shapes = [shape(part) for part in arguments(statement[call.end():])]
                text = max(shapes, key=lambda one: len(one.replace("...", "").split()), default="")
                if len(re.findall(r"\w{2,}", text)) >= FEWEST:
                    yield Site(str(path.relative_to(root)), line, text)
            name = FUNCTION.search(statement)
            inside = "fault" in name.group(1) if name else inside
            for words in [*WORDS.finditer(statement), *(RESULT.finditer(statement) if inside else [])]:
                text = shape(statement[words.end():].strip())
                if len(re.findall(r"\w{2,}", text)) >= FEWEST:
                    yield Site(str(path.relative_to(root)), line, text)
