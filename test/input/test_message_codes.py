# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Codes of messages: `scree --explain` finds each message by its code and by its words.

Would catch two codes that fit the words of a message equally well; a pattern that no message matches any more; a code
that was removed or renumbered. That each message has a code is checked in test/gate/test_texts.py.
"""

import re
import subprocess

import pytest

import broken_instruments as instruments
import broken_values as values
import case
import document_messages as messages

TABLES = [*messages.FAULTS, instruments.INSTRUMENTS]
# The number of codes in each hundred: codes are only added, at the end.
FEWEST = {"D1": 16, "D2": 29, "D3": 66, "D4": 47, "D5": 12, "C1": 16, "C2": 6, "R1": 36, "F1": 24}


def all_messages():
    """All records of messages."""
    return [message for _, part in messages.sections().values() for message in part]


def best(text, known):
    """Codes that fit a text best; there should be exactly one."""
    found = messages.scores(text, known)
    return {code for letters, code in found if letters == found[0][0]}


def ask(options, *arguments, expect=0):
    """Output of the program."""
    answer = subprocess.run([options.scree, *arguments], text=True, timeout=60, stdout=subprocess.PIPE,
                            stderr=subprocess.STDOUT, check=False)
    assert answer.returncode == expect, f"{arguments}: exit code {answer.returncode}: {answer.stdout}"
    return answer.stdout


class TestCodes:
    """Words of the messages, which `scree --explain` searches, against the tables of invalid decks and the sources."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls):
        cls.known, cls.patterns = all_messages(), messages.patterns(all_messages())

    def test_each_message_of_the_tables_has_one_code(self, sheet):
        """Would catch a message that `scree --explain` does not find by its words."""
        for table in TABLES:
            for row in table:
                with sheet.part(row[4]):
                    assert len(best(row[4], self.patterns)) == 1, messages.scores(row[4], self.patterns)[:3]

    def test_each_pattern_is_said(self, sheet):
        """Would catch a pattern that no message matches any more."""
        said = [row[4] for table in TABLES for row in table]
        said += re.findall(r"^prints: (.*(?:\n         .*)*)", messages.EXAMPLES.read_text(encoding="utf-8"), re.M)
        said = [" ".join(text.split()) for text in said]
        source = "".join(path.read_text(encoding="utf-8") for path in sorted((case.ROOT / "src").rglob("*.f90")))
        source = re.sub(r" \[[A-Z]\d{3}\]", "", re.sub(r'" *// *(&\s*)?"', "", source))
        for message in self.known:
            for pattern in message.says:
                with sheet.part(f"{message.code}: {pattern}"):
                    parts = re.compile(".*?".join(map(re.escape, pattern.split("..."))))
                    if any(parts.search(text) for text in said):
                        continue
                    for part in pattern.split("..."):
                        assert part.strip(" '=()") in source

    def test_codes_are_not_removed(self):
        """Would catch a code that is missing in its hundred, and so might be assigned again."""
        for start, count in FEWEST.items():
            numbers = [int(message.code[2:]) for message in self.known if message.code.startswith(start)]
            assert numbers == list(range(1, len(numbers) + 1)), start
            assert len(numbers) >= count, start
        assert {message.code[:2] for message in self.known} == set(FEWEST)


class TestExplanations:
    """The program against the records."""

    def test_list(self, options):
        """Would catch a program that was built with other records, or lacks some."""
        listed = [line.split("  ")[0] for line in ask(options, "--list", "messages").splitlines()]
        assert listed == [message.code for message in all_messages()]

    def test_code_and_line_give_the_same(self, options):
        """Would catch a line from a log, with file, line and code or without, that is not recognised."""
        line = "scene.nml:4: error: &material: density = -2700  <- must be > 0 kg/m3"
        wanted = ask(options, "--explain", "D214")
        assert ask(options, "--explain", line) == wanted
        assert ask(options, "--explain", f"{line} [D214]") == wanted
        assert ask(options, "--explain", "d214") == wanted
        assert ask(options, "--explain", "words of an older program [D214]") == wanted
        for part in ("D214  must be >", "cause:  The number is out of range.", "remedy: ", "wrong:  &material",
                     "prints: scene.nml:4: error:", "right:  &material", "keys:   scree --explain material.density"):
            assert part in wanted

    def test_explanations_are_text(self, options):
        """Would catch Markdown syntax, lines wider than a screen, and fields of a record that are lost."""
        for code in ("D201", "D214", "R101", "F113"):
            text = ask(options, "--explain", code)
            assert "](" not in text
            assert all(len(line) <= 80 for line in text.split("wrong:")[0].splitlines()), text

    def test_unknown(self, options):
        """Would catch an unknown text or code without a hint, and keys that are taken for messages."""
        said = ask(options, "--explain", "the density must be larger", expect=2)
        assert "similar messages:\n" in said
        assert "scree --list messages" in said
        assert "no message has the code 'D999'" in ask(options, "--explain", "D999", expect=2)
        assert "&grid" in ask(options, "--explain", "grid")

    def test_hint_comes_once(self, options):
        """Would catch a hint after each message, or a message without its code."""
        folder = options.work / "hint"
        folder.mkdir(parents=True, exist_ok=True)
        deck = folder / "deck.nml"
        deck.write_text(values.DECKS["plain"].replace("2700", "-2700").replace("0.3", "x"), encoding="ascii")
        said = ask(options, "--check", str(deck), expect=2)
        assert len(re.findall(r": error: .* \[D\d{3}\]$", said, re.M)) == 2, said
        assert said.count("scree --explain") == 1, said
