# SPDX-License-Identifier: BSD-3-Clause
"""The page of messages and the examples of `scree --explain` show what the program prints now.

Would catch a message that was reworded and is shown with its old text, an example that causes another message, another
code or none, a deck shown as correct that has an error, a record that is not on the page, and a message whose example
was lost.
"""
# timeout: 200

import re

import pytest

import document_messages as messages

MOST_LINES = 13.3            # of the page for each message
# Messages without an example: no deck causes them, no deck causes them twice with the same text, or the message is one
# of several that need no example.
ALONE = {"D224", "D226", "D227", "D228", "D229", "D350", "D351", "D360", "D361", "D362", "D365", "D447", "D451",
         "R134", "R135", "R136", "C111", "C117", "C118", "R118", "R124", "R127", "R128", "R129", "R130", "F123", "F124"}


class TestPage:
    """The generator runs the program on all examples."""

    @pytest.fixture(autouse=True, scope="class")
    @classmethod
    def made(cls, file_options):
        cls.texts = messages.documents(file_options.scree)

    def test_page_is_that_of_the_program(self):
        """Would catch a page or examples that are out of date."""
        assert messages.out_of_date(self.texts) == [], "run scripts/document_messages.py and look at the changes"

    def test_what_is_out_of_date_is_seen(self):
        """Would catch a comparison that never finds a difference."""
        changed = {messages.PAGE: self.texts[messages.PAGE] + "more\n", messages.PAGE.with_name("new.md"): "text"}
        assert messages.out_of_date(changed) == ["messages.md differs", "new.md is missing"]

    def test_records(self):
        """Would catch fields that are lost, and a pattern that matches too little or too much."""
        text = "says: it ... is: so\nsays: or so\nwhen: warning\ncause: Why\n  this.\nremedy: What.\nnote: More.\n"
        one = messages.Message("values", "D299", text)
        assert (one.says, one.when, one.cause, one.remedy, one.notes) == (
            ["it ... is: so", "or so"], "warning", "Why this.", "What.", ["More."])
        assert one.pattern().search("it surely is: so") and not one.pattern().search("it was")
        assert one.told(["a", "it surely is: so [D299]"]) == "it surely is: so [D299]"
        with pytest.raises(ValueError, match="another code"):
            one.told(["it surely is: so [D298]"])
        for wrong in (text.replace("cause", "reason"), text.replace("remedy: What.\n", ""), "cause: a\nremedy: b\n"):
            with pytest.raises(ValueError):
                messages.Message("values", "D299", wrong)

    def test_each_message_has_its_place_and_example(self):
        """Would catch a code without an anchor, and a message whose example was lost."""
        page = self.texts[messages.PAGE]
        codes = [message.code for _, part in messages.sections().values() for message in part]
        assert re.findall(r"^### (\w+)$", page, re.M) == codes
        shown = dict(messages.records(self.texts[messages.EXAMPLES]))
        assert list(shown) == codes
        assert {code for code in codes if f"[{code}]" not in shown[code]} == ALONE
        assert str(messages.ROOT) not in page
        assert page.count("\n") < MOST_LINES * len(codes)
