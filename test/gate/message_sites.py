# SPDX-License-Identifier: BSD-3-Clause
"""Messages of the program as its sources compose them.

    for site in sites(root): print(site.path, site.line, site.text)

A site is a call that reports an error or a warning, or an assignment of a message to a variable; its text has `...` in
place of each variable. A site is complete without a code if another one gives it the code: it continues a message, it
contains a variable with a message, or the procedure that it calls, or a later statement, adds the code.
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
CODE = re.compile(r" \[([CDFR]\d{3})\]")
# Variables and functions whose texts are messages.
MESSAGE = re.compile(r"(?:^|//|\()\s*(?:fault|problem|message|reason|error%message|\w+_problem|expectation)\b", re.I)
PROCEDURE = re.compile(r"^(?:pure |recursive )*(?:subroutine|function)\s+(\w+).*?^end ", re.I | re.M | re.S)


class Site(NamedTuple):
    """A call that reports a message."""

    path: str
    line: int
    text: str
    complete: bool               # another site gives the code


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


def adders(lines):
    """Procedures of a file that add a code to the text of an argument, and variables that get a code later."""
    whole = "\n".join(text for _, text in lines)
    procedures = {match.group(1).lower() for match in PROCEDURE.finditer(whole)
                  if CODE.search(match.group()) and re.search(r"//what\b|, name\b", match.group())}
    variables = set()
    for _, text in lines:
        called = CALL.search(text)
        if CODE.search(text) or (called and called.group(2).lower() in procedures):
            variables |= set(re.findall(r"//\s*(\w+)\s*(?=//|\))", LITERAL.sub('""', text)))
            variables |= set(re.findall(r"^(\w+) = \1//", text))
    return procedures, variables


def sites(root):
    """All calls that report a message with a text of their own."""
    for path in sorted((root / "src").rglob("*.f90")):
        inside = False
        lines = list(statements(path.read_text(encoding="utf-8")))
        procedures, variables = adders(lines)
        for line, statement in lines:
            for call in CALL.finditer(statement):
                if call.group(2).lower() not in REPORTS:
                    continue
                parts = arguments(statement[call.end():])
                text, part = max(((shape(part), part) for part in parts),
                                 key=lambda one: len(one[0].replace("...", "").split()), default=("", ""))
                if len(re.findall(r"\w{2,}", text)) >= FEWEST:
                    complete = call.group(2).lower() in procedures or bool(MESSAGE.search(LITERAL.sub('""', part)))
                    yield Site(str(path.relative_to(root)), line, text, complete)
            name = FUNCTION.search(statement)
            inside = "fault" in name.group(1) if name else inside
            for words in [*WORDS.finditer(statement), *(RESULT.finditer(statement) if inside else [])]:
                part = statement[words.end():].strip()
                text, variable = shape(part), re.search(r"(\w+)\s*=$", words.group()).group(1)
                if len(re.findall(r"\w{2,}", text)) >= FEWEST:
                    complete = variable in variables or part.startswith(f"{variable}//") or bool(MESSAGE.search(
                        LITERAL.sub('""', part)))
                    yield Site(str(path.relative_to(root)), line, text, complete)
