# SPDX-License-Identifier: BSD-3-Clause
"""Extension of mkdocstrings: rows "name   meaning" of a docstring become a list, indented lines a block of code."""
import re

import griffe

ROW = re.compile(r"^(\w+) {2,}(\S.*)$")


def written(docstring):
    """The text with the line breaks of the source, indented relative to its first line."""
    lines = docstring.parent.filepath.read_text(encoding="utf-8").split("\n")
    lines = lines[docstring.lineno - 1:docstring.endlineno]
    edge = len(lines[0]) - len(lines[0].lstrip())
    text = "\n".join([lines[0].strip(), *(line[edge:] for line in lines[1:])])
    return re.sub(r'^r?"""|"""\s*$', "", text).rstrip()


def as_markdown(text):
    """The text of a docstring with its rows as a list."""
    lines, within = [], False
    for line in text.split("\n"):
        row = ROW.match(line)
        if row:
            lines += ([] if within else [""]) + [f"* `{row[1]}`: {row[2]}"]
            within = True
        elif within and line.startswith("     "):
            lines.append("  " + line.strip())
        else:
            within = False
            lines.append(line)
    return "\n".join(lines)


class Rows(griffe.Extension):
    """Extension that changes the docstrings after the sources have been read."""

    def on_object(self, *, obj, **_):
        """Change the docstring of one function, class or module."""
        if obj.docstring and obj.docstring.lineno:
            obj.docstring.value = as_markdown(written(obj.docstring))
