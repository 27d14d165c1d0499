# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""The diagram of the folders of src/ in doc/developer/architecture.md agrees with the sources.

Would catch a diagram with arrows for dependencies that no longer exist, a diagram that lacks new dependencies, and a
folder without a box; and a unit test in the folder of another room, or with a mark of a room that it does not need.
"""

import re
from unittest import mock

import document_rooms
from sources import ROOT, place, project_files


def rooms_of_modules():
    """Room of each module, the generated ones included, and the rooms in the order of the build."""
    order = re.findall(r"^add_subdirectory\(src/(\w+)\)", (ROOT / "CMakeLists.txt").read_text("utf-8"), re.M)
    return {path.name.split(".")[0]: path.relative_to(ROOT / "src").parts[0]
            for path in (ROOT / "src").rglob("*.f90*")}, order


def misplaced(stem, folder, text, rooms, order):
    """What is wrong with the place and the mark of a unit test, as a list of sentences."""
    found = []
    named = [name for name in rooms if stem == name or stem.startswith(name + "_")]
    if named and rooms[max(named, key=len)] != folder:
        found.append(f"belongs to {max(named, key=len)} in the room {rooms[max(named, key=len)]}")
    used = {rooms[name] for name in re.findall(r"^\s*use +(\w+)", text, re.M) if name in rooms}
    top = max(used | {folder}, key=order.index)
    marks = re.findall(r"^! layer: *(\w+)", text, re.M)
    if marks != ([top] if top != folder else []):
        found.append(f"uses modules up to {top} and has the mark `! layer: {' '.join(marks)}`")
    return found


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

    def test_places_of_unit_tests(self):
        """A unit test is in the folder of its module; `! layer: X` names the highest room that it uses, if higher."""
        rooms, order = rooms_of_modules()
        tests = project_files(".pf", under="test/unit")
        assert len(tests) > 100
        found = [f"{place(path, 1)} {what}" for path in tests
                 for what in misplaced(path.stem.removeprefix("test_"), path.parent.name, path.read_text("utf-8"),
                                       rooms, order)]
        assert not found, "\n" + "\n".join(found)

    def test_a_misplaced_test_is_seen(self):
        """The rule itself: a wrong folder, a missing mark, and a mark that is not needed."""
        rooms, order = {"mesh_grid": "mesh", "step_clock": "step"}, ["mesh", "step"]
        assert misplaced("mesh_grid_edges", "mesh", "use mesh_grid\n", rooms, order) == []
        assert misplaced("mesh_grid", "mesh", "! layer: step\n use step_clock\n", rooms, order) == []
        for stem, folder, text in (("mesh_grid", "step", "use step_clock\n"), ("mesh_grid", "mesh", "use step_clock\n"),
                                   ("mesh_grid", "mesh", "! layer: step\nuse mesh_grid\n")):
            assert len(misplaced(stem, folder, text, rooms, order)) == 1
