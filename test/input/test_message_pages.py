# SPDX-License-Identifier: BSD-3-Clause
"""The pages behind the page of messages: each shows what the program says today, and each row has one.

Would catch a message that was reworded and is shown with its old words, an example that brings another message or
none, a deck shown as right that is wrong, a row without a page, a page that no row leads to, and a page that says
no more than its row.
"""
# timeout: 200

import pytest

import document_messages as messages

SHORTEST, LONGEST = 8, 45    # lines of a page
# No deck brings these about, or no two times with the same words.
ALONE = {"declaration-of-the-deck", "s-of-wall-time-and-s-of"}


class TestPages:
    """The generator runs the program on all examples."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.texts = messages.documents(file_options.scree)

    def test_pages_are_those_of_the_program(self):
        """Would catch a page that differs, is missing, or belongs to no row."""
        assert len(self.texts) > 100
        wrong = messages.out_of_date(self.texts)
        assert wrong == [], "run scripts/document_messages.py and look at what has changed"

    def test_what_is_out_of_date_is_seen(self):
        """Would catch a comparison that finds nothing."""
        name, text = next((path, text) for path, text in self.texts.items() if path not in messages.TABLES)
        changed = {**self.texts, name: text + "more\n", messages.PAGES / "new.md": text}
        del changed[messages.PAGES / "expects-a-number.md"]
        assert set(messages.out_of_date(changed)) == {
            f"{name.name} differs",
            "new.md is missing",
            "expects-a-number.md belongs to no row of a table",
        }

    def test_a_new_row(self):
        """Would catch a row that gets no link, or a link made anew where there is one."""
        table = "| `it ... is: ... so`, `or so` (warning) | why | what |\n"
        linked = messages.linked(table)
        assert linked == "| [`it ... is: ... so`, `or so`](messages/it-is-so.md) (warning) | why | what |\n"
        assert messages.linked(linked) == linked
        row = messages.rows("## Head\n" + linked)[0]
        assert (row.heading, row.name, row.messages) == ("Head", "it-is-so", ["it ... is: ... so", "or so"])
        assert row.pattern().search("it surely is: just so") and not row.pattern().search("it was")

    def test_pages_say_more(self, sheet):
        """Would catch pages without an example, and such as nobody reads."""
        for path, text in self.texts.items():
            if path in messages.TABLES:
                continue
            with sheet.part(path.name):
                lines = text.count("\n")
                assert SHORTEST < lines < LONGEST, f"{lines} lines"
                assert ("```console" in text) == (path.stem not in ALONE)
                assert "[all messages](../errors.md)" in text
                assert str(messages.ROOT) not in text
