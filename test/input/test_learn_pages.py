# SPDX-License-Identifier: BSD-3-Clause
# timeout: 300
"""The pages that explain a deck line by line agree with it, and their pictures, films and scripts can be made.

Would catch a line of a page that is no longer in the deck, an option or a field that no longer exists, and a Python
script that a new user copies and that fails.
"""

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# Deck of each page, and values with which it runs in seconds.
PAGES = {"first_deck": ("two_discs", ("grid.dx=0.05",)),
         "debris_cloud": ("debris_cloud", ("grid.dx=0.775", "time.t_end=4")),
         "brittle_rod": ("glass_rod", ("grid.dx=1", "time.t_end=7")),
         "sand_column": ("column_collapse", ("grid.dx=0.025",))}
ADDED = "&output  name = 'front'"        # a line that a page suggests and that is not in the deck


def text_of(page):
    """Text of a page of doc/learn."""
    return (ROOT / f"doc/learn/{page}.md").read_text(encoding="utf-8")


def blocks(page, language):
    """Contents of the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", text_of(page), re.M | re.S)


def without_comment(line):
    """The part of a line of a deck that the program reads."""
    return re.sub(r"\s*!.*", "", line).strip()


@pytest.mark.parametrize("page", PAGES)
def test_shown_lines(page):
    scene = f"input/{PAGES[page][0]}/scene.nml"
    lines = {without_comment(line) for line in (ROOT / scene).read_text(encoding="utf-8").split("\n")}
    shown = [line for block in blocks(page, "fortran") for line in block.strip().split("\n")
             if not line.startswith(ADDED)]
    assert len(shown) > 20
    assert [f"{scene} does not hold: {line}" for line in shown if without_comment(line) not in lines] == []


@pytest.mark.parametrize("page", PAGES)
def test_commands(page, options):
    """The deck runs, and the commands of scree-post and Python on the page work with its results."""
    name, values = PAGES[page]
    program, folder = options.scree, options.work
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python/src"), "SCREE": str(program), "OMP_NUM_THREADS": "1"}
    (folder / "input").symlink_to(ROOT / "input")

    def call(*words):
        answer = subprocess.run([str(word) for word in words], cwd=folder, env=environment, capture_output=True,
                                text=True, check=False)
        assert answer.returncode == 0, f"{words}: {answer.stdout[-2000:]}{answer.stderr[-2000:]}"

    added = [line for block in blocks(page, "fortran") for line in block.split("\n") if line.startswith(ADDED)]
    deck = folder / f"{name}.nml"
    deck.write_text((ROOT / f"input/{name}/scene.nml").read_text(encoding="utf-8") + "\n".join(added) + "\n",
                    encoding="utf-8")
    call(program, deck, "-q", *(word for value in values for word in ("--set", value)))
    typed = [line.partition("scree-post ")[2] for block in blocks(page, "console")
             for line in block.split("\n") if "scree-post " in line]
    assert len(typed) >= 2
    for line in typed:
        # a film in .mp4 needs ffmpeg
        call(sys.executable, "-m", "scree_post", *shlex.split(line.replace(".mp4", ".gif")))
    for number, script in enumerate(blocks(page, "python")):
        (folder / f"script_{number}.py").write_text(script, encoding="utf-8")
        call(sys.executable, f"script_{number}.py")


def test_ballistic_limit(options):
    """Would catch a script of the page that fails, a striker that does not perforate, and a limit outside of the speeds
    that bound it. With the coarsest cells and four of the speeds."""
    script, = blocks("ballistic_limit", "python")
    for line, shorter in (("CELLS = (1.5, 1.0, 0.75)", "CELLS = (1.5,)"),
                          ("SPEEDS = (120, 140, 160, 180, 200, 220, 300, 400)", "SPEEDS = (160, 180, 220, 300)")):
        assert line in script
        script = script.replace(line, shorter)
    (options.work / "limit.py").write_text(script, encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python/src"), "SCREE": str(options.scree),
                   "OMP_NUM_THREADS": "1"}
    answer = subprocess.run([sys.executable, "limit.py"], cwd=options.work, env=environment, capture_output=True,
                            text=True, check=False)
    assert answer.returncode == 0, answer.stdout[-2000:] + answer.stderr[-2000:]
    limit, least, most = map(float, re.search(r"limit (\d+) m/s.*between (\d+) and (\d+) m/s", answer.stdout).groups())
    assert least == 160 and most == 180 and least < limit < 1.1 * most, answer.stdout
    assert (options.work / "limit.png").is_file()
