# SPDX-License-Identifier: BSD-3-Clause
"""Figures in the READMEs of scenes agree with results of the program, and the gallery shows them.

Would catch a change of the method that leaves old figures in a README, a scene without figures or that no longer
runs, a comparison that accepts all differences, a number that is updated in the wrong position or not at all, a failed
run that is not reported, a verdict of the program that no page shows, and a gallery that is out of date. Tier full: the
scenes that take seconds; tier long: all scenes with measured figures, which takes about half an hour.
"""
# tiers: full, long
# timeout: 900
# timeout long: 7200
# cores: 2

import os
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

import gallery
import scree_scene
import tier
from scree import study
from scree.errors import ScreeError

ROOT = Path(__file__).resolve().parents[3]
SHORT = ("cell_crossing", "driven_plate", "taylor_copper", "two_discs")    # the others take minutes
#: Scenes of minutes whose README gets its table of verdicts with the next run of their measure.py.
LATER = ("brittle_and_ductile",)
SCENES = sorted(script.parent.name for script in (ROOT / "input").glob("*/measure.py"))


@pytest.mark.parametrize("scene", tier.choose(SHORT, long=SCENES))
def test_scene(options, sheet, scene):
    """Run a scene and compare its README with the results."""
    shutil.rmtree(options.work / scene, ignore_errors=True)     # runs of another program with the same version
    answer = subprocess.run(
        [sys.executable, ROOT / "input" / scene / "measure.py", "--scree", options.scree, "--out",
         options.work / scene, "--check"], capture_output=True, text=True, check=False,
        # one thread for each run, and one run for each core
        env={**os.environ, "OMP_NUM_THREADS": "1"})
    sheet.require(answer.returncode == 0,
                  f"{scene}: figures of the README {(answer.stdout + answer.stderr)[-600:]}")


def test_comparison(sheet):
    """Differences that are accepted or reported."""
    told = "| plain | 0.025 | 1e-14 |\n| DDMP | 12.0 | stands |"
    for found, wrong, words in ((told, 0, "equal"), (told.replace("12.0", "12.1"), 0, "within the share"),
                                (told.replace("1e-14", "3e-15"), 0, "rounding"),
                                (told.replace("12.0", "12.5"), 1, "a number"),
                                (told.replace("1e-14", "1e-4"), 1, "no rounding"),
                                (told.replace("stands", "12"), 1, "a word"), (told + "\n| x |", 1, "a line")):
        lines = scree_scene.differences(told, found, 0.02)
        sheet.require(len(lines) == wrong, f"comparison, {words}: {lines}")


def refused(action, *words):
    """True if an action ends with an error message for the user."""
    try:
        action(*words)
    except ScreeError:
        return True
    return False


def test_numbers(sheet):
    """Numbers of a text that are updated, marks without a value, and values without a mark."""
    told = "In 2 runs the front\nis <!--=front-->0.9<!--=--> of 1.1 m; <!--=seconds-->3<!--=--> s."
    now = scree_scene.with_numbers("README.md", told, {"front": "0.85", "seconds": None})
    sheet.require(now == told.replace("0.9", "0.85"), f"numbers: {now!r}")
    for values in ({"front": "0.85"}, {"front": "0.85", "back": "1", "seconds": None}):
        sheet.require(refused(scree_scene.with_numbers, "README.md", told, values), f"{values} are refused")


def test_documents(options, sheet):
    """Old numbers in a table or a sentence make --check fail; --write would leave the new ones."""
    folder = options.work
    told = ("# A scene\n\nIt takes <!--=steps-->30<!--=--> steps.\n\n"
            "<!-- figures -->\n\n| a |\n| --- |\n| 1.5 |\n\n<!-- end of figures -->\n")
    (folder / "README.md").write_text(told, encoding="utf-8")
    for steps, value, wrong in ((30, 1.5, 0), (31, 1.5, 1), (30, 2.5, 1)):
        scene = scree_scene.Study(folder / "measure.py", {}, None, {},
                                  numbers={"README.md": lambda _, steps=steps: {"steps": str(steps)}})
        texts = scene.documents({}, scree_scene.Table(["a"], [[value]]).text())
        _, now = texts[(folder / "README.md").resolve()]
        sheet.require(scene.check(texts) == wrong and now == told.replace("30", str(steps)).replace("1.5", str(value)),
                      f"{steps} steps and {value} in the table: {now!r}")


def test_verdicts(sheet):
    """The table of verdicts names the worst first, with its reasons and their range; no run is left out."""
    def run(noise, energy, verdict):
        rows = {"energy": energy, "noise": noise}
        trust = {name: {"value": value, "verdict": word} for name, (value, word) in rows.items()}
        return SimpleNamespace(verdict=scree_scene.Run.verdict.fget(
            SimpleNamespace(summary={"trust": {**trust, "verdict": verdict}})))
    good, low, high = run((0.1, "ok"), (0.0, "ok"), "ok"), *(
        run((noise, "bad"), (0.03, "check"), "bad") for noise in (0.75, 0.98))
    rows = scree_scene.verdicts({"a": good, "b": high, "c": low}).rows
    sheet.require(rows == [["bad", "energy 0.03, noise 0.75 to 0.98", "`b`, `c`"], ["ok", "", "`a`"]], f"{rows}")
    rows = scree_scene.verdicts({"a": good, "b": good}).rows
    sheet.require(rows == [["ok", "", "all"]], f"{rows}")


def test_failures(sheet):
    """Failed runs that count as results."""
    scene = scree_scene.Study(__file__, {}, None, {}, may_fail={"bad": 4})
    for name, code, wrong in (("bad", 4, False), ("bad", 0, False), ("bad", 3, True), ("good", 4, True)):
        sheet.require(refused(scene.refuse_failed, study.Combination({}, "", name, code)) == wrong,
                      f"{name} with exit code {code} is {'refused' if wrong else 'a result'}")


def test_complete(sheet):
    """Each scene folder has figures, the commands that make them, and the time that this takes."""
    folders = sorted(path.parent for path in (ROOT / "input").glob("*/README.md"))
    sheet.require(len(folders) > 8, f"{len(folders)} scenes are found")
    for folder in folders:
        text = (folder / "README.md").read_text(encoding="utf-8")
        sheet.require("| verdict of the program |" in text or folder.name in LATER,
                      f"{folder.name}: the README shows the verdict")
        sheet.require((folder / "measure.py").is_file() and text.count(scree_scene.BEGIN) == 1
                      and len(gallery.WORKED.findall(text)) == 1, f"{folder.name}: measured, with figures and times")


def test_gallery(sheet):
    sheet.require(gallery.PAGE.read_text(encoding="utf-8") == gallery.page(),
                  "gallery: scripts/gallery.py --page changes nothing")
    sheet.require(set(SHORT) < set(SCENES), "the short scenes are there")
