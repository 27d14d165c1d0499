# SPDX-License-Identifier: BSD-3-Clause
"""Figures in the READMEs of scenes are those that the program finds, and the gallery shows them.

Would catch a change of the method that leaves old figures in a README, a scene that no longer runs, a comparison that
takes anything for equal, and a gallery that was not renewed.
"""
# timeout: 400

import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "test/support"), str(ROOT / "scripts")]
import case         # noqa: E402
import gallery      # noqa: E402
import report       # noqa: E402
import scree_scene  # noqa: E402

SHORT = ("cell_crossing",)             # the others take minutes: test_all_scenes


def check(options, sheet, scene):
    """Run a scene and hold its README against it."""
    shutil.rmtree(options.work / scene, ignore_errors=True)     # runs of another program of this version
    answer = subprocess.run(
        [sys.executable, ROOT / "input" / scene / "measure.py", "--scree", options.scree, "--out",
         options.work / scene, "--check"], capture_output=True, text=True, check=False)
    sheet.require(answer.returncode == 0,
                  f"{scene}: figures of the README {(answer.stdout + answer.stderr)[-600:]}")


def comparison(sheet):
    """What counts as a difference."""
    told = "| plain | 0.025 | 1e-14 |\n| DDMP | 12.0 | stands |"
    for found, wrong, words in ((told, 0, "equal"), (told.replace("12.0", "12.1"), 0, "within the share"),
                                (told.replace("1e-14", "3e-15"), 0, "rounding"),
                                (told.replace("12.0", "12.5"), 1, "a number"),
                                (told.replace("1e-14", "1e-4"), 1, "no rounding"),
                                (told.replace("stands", "12"), 1, "a word"), (told + "\n| x |", 1, "a line")):
        lines = scree_scene.differences(told, found, 0.02)
        sheet.require(len(lines) == wrong, f"comparison, {words}: {lines}")


def main():
    """The short scenes, the comparison, the gallery."""
    options = case.arguments()
    sheet = report.Report()
    comparison(sheet)
    sheet.require(gallery.PAGE.read_text(encoding="utf-8") == gallery.page(),
                  "gallery: scripts/gallery.py --page changes nothing")
    for scene in SHORT:
        check(options, sheet, scene)
    sheet.end()


if __name__ == "__main__":
    main()
