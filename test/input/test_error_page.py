# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The pages of messages against the messages: each that the tests know is on it, and none is made up. The pages
behind its rows are those of test_message_pages.

Would catch a message that was reworded, or is new, and is not explained; and a row of the page that
no message fits any more.
"""

import re

import broken_scenes as scenes
import broken_values as values
import case

PAGE = "".join((case.ROOT / f"doc/reference/{name}.md").read_text(encoding="utf-8")
               for name in ("errors", "errors_runs"))
TABLES = [values.KINDS, values.NUMBERS, values.UNKNOWN, values.MARKS, scenes.CONTRADICTIONS, scenes.CELLS,
          scenes.NAMES, scenes.ORPHANS, scenes.BODIES, scenes.ANGLES, scenes.SIZES,
          scenes.INCLUDES, scenes.WARNINGS]


def rows():
    """Messages of the page with the name of the page behind them."""
    found = []
    for line in PAGE.splitlines():
        cells = line.split(" | ")
        if line.startswith(("| `", "| [`")) and len(cells) == 3:
            name = re.search(r"\]\((messages/[a-z0-9-]+\.md)\)", cells[0])
            found += [(name and name.group(1), text) for text in re.findall("`([^`]+)`", cells[0])]
    return found


def shown(name):
    """What the program prints on a page; test_message_pages compares that with the program."""
    text = (case.ROOT / "doc/reference" / name).read_text(encoding="utf-8")
    return re.findall(r"^```console\n(.*?)^```", text, re.M | re.S)


def pattern(message):
    """What a message of the page fits: three points stand for anything."""
    return re.compile(".*?".join(re.escape(part) for part in message.split("...")))


class TestPage:
    """Texts are compared; test_bad_decks compares them with the program."""

    def test_each_row_is_said(self, sheet):
        """Would catch a row that no message fits: decks by the tables, others by their pages or the source."""
        said = [row[4] for table in TABLES for row in table]
        source = "".join(path.read_text(encoding="utf-8")
                         for path in sorted((case.ROOT / "src").rglob("*.f90")))
        source = re.sub(r'" *// *(&\s*)?"', "", source)
        assert len(rows()) > 60
        for name, message in rows():
            with sheet.part(message):
                assert name, "the row has no page; run scripts/document_messages.py"
                if any(pattern(message).search(text) for text in said + shown(name)):
                    continue
                for part in message.split("..."):
                    part = part.strip(" '=()")
                    assert part in source, f"nobody says '{part}'"

    def test_each_message_is_explained(self, sheet):
        """Would catch a message of the tables that the page does not have."""
        patterns = [pattern(message) for _, message in rows()]
        for table in TABLES:
            for row in table:
                with sheet.part(row[4]):
                    assert any(one.search(row[4]) for one in patterns), (
                        "neither in doc/reference/errors.md nor in errors_runs.md"
                    )
