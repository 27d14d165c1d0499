# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The diagram of the folders of src/ in doc/developer/architecture.md agrees with the sources.

Would catch a diagram with arrows for dependencies that no longer exist, a diagram that lacks new dependencies, and a
folder without a box.
"""

from unittest import mock

import document_rooms


class TestRoomGate:
    """The diagram and its parts."""

    def test_drawing(self):
        assert document_rooms.DRAWING.read_text(encoding="utf-8") == document_rooms.drawing(document_rooms.uses()), (
            "run python3 scripts/document_rooms.py"
        )

    def test_arrows_follow_the_sources(self):
        used = document_rooms.uses()
        assert used["base"] == set()
        assert "mesh" in used["particle"]
        assert "scene" not in used["step"]

    def test_reduction(self):
        """Only arrows that follow from other arrows are left out."""
        used = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
        assert document_rooms.reduced(used) == {"a": {"b"}, "b": {"c"}, "c": set()}
        assert document_rooms.rows_below(used) == {"a": 0, "b": 1, "c": 2}

    def test_a_new_arrow_is_seen(self):
        used = document_rooms.uses()
        changed = {**used, "exact": used["exact"] | {"mesh"}}
        with mock.patch.object(document_rooms, "uses", return_value=changed):
            assert document_rooms.drawing(document_rooms.uses()) != document_rooms.drawing(used)
