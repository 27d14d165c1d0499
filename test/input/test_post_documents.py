# SPDX-License-Identifier: BSD-3-Clause
# timeout: 900
"""Every command of scree-post that a document or a help text shows is run on small runs.

Would catch an option that was renamed, an example that does not work, and a command of a document
that fails.
"""

import os
import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

import case
import report
from post_command import INPUT, call, run_cases
from scree.errors import ScreeError
from scree_post import film
from scree_post.command import load
from scree_post.commands import COMMANDS

DOCUMENTS = ("README.md", "doc/learn/first_deck.md", "doc/guide/post_processing.md", "doc/guide/accuracy.md",
             "doc/guide/fragments.md", "doc/reference/matter_outputs.md", "doc/guide/grain_cell.md",
             "doc/reference/materials.md", "doc/guide/shapes.md", "input/debris_cloud/README.md")
LEAST = 20               # least number of commands in the documents
BEGIN = {"taylor_copper": 20, "two_discs": 1}            # of runs by the folder of their deck, in units of the deck
DRAWING = ("picture", "movie", "radiograph")


@pytest.fixture(scope="module")
def options(file_options):
    """Small runs in a folder that all tests use, and the decks of the documents."""
    run_cases(file_options, "two_discs", "coarse", "debris_cloud", "debris_cloud_3d", "grain_cell")
    shutil.copytree(file_options.work / "out" / "two_discs", file_options.work / "out" / "again")
    (file_options.work / "input").symlink_to(INPUT)
    page = (case.ROOT / "doc/guide/fragments.md").read_text(encoding="utf-8")
    deck = re.search(r"^```fortran\n(.*?)^```", page, re.M | re.S)[1]
    (file_options.work / "bar.nml").write_text(deck, encoding="utf-8")
    return file_options


def shown(path):
    """Commands of scree-post in the console blocks of a document."""
    text = (case.ROOT / path).read_text(encoding="utf-8")
    found = []
    for block in re.findall(r"^```(?:console|bash)\n(.*?)^```", text, re.M | re.S):
        for line in block.replace("\\\n", " ").splitlines():
            place = re.search(r"(?:^|/|\s)scree-post (.*)", line)
            if place:                                    # without a comment or a redirection after it
                found.append(re.sub(r"\s+[#>] .*", "", place.group(1)))
    return found


def words_of(line, options):
    """The words of a command, with the program of this test, and a film in a format that can be written."""
    words = shlex.split(line)
    if words[0] == "sweep":
        words += ["--scree", str(options.scree), "--threads", "1"]
        if "two_discs" not in line and "--list" not in words:
            words.append("--list")                       # a long run
    if "--seeds" in words:
        words[words.index("--seeds") + 1] = "2"
    if words[0] in ("accuracy", "validate") or "--seeds" in words:
        words += ["--scree", str(options.scree)]
    if words[0] == "accuracy":                           # the begin of the run, with the cells of the document
        words += ["--set", f"time.t_end={BEGIN[Path(words[1]).parent.name]}"]
    if words[0] in DRAWING and "--dpi" not in words and not line.endswith((".pdf", ".nml")):
        words += ["--dpi", "80"]                         # test_post_pictures draws with the default
    try:
        film.encoder()
    except ScreeError:
        if any(word.endswith(".mp4") for word in words):
            report.skipped(f"the film of '{line}'", "there is no ffmpeg; it is made as a .gif")
        words = [re.sub(r"\.mp4$", ".gif", word) for word in words]
        if words[0] == "movie" and "--out" not in words:
            words += ["--out", "film.gif"]
    return words


def write_rasters(folder):
    """The rasters of the examples; False without the package that writes and reads them."""
    try:
        import rasterio
    except ImportError:
        return False
    heights = np.add.outer(np.arange(500.0), np.arange(1000.0)).astype("f4")
    where = rasterio.transform.from_origin(702300, 5181000, 1, 1)
    with rasterio.open(folder / "dem.tif", "w", driver="GTiff", width=1000, height=500, count=1, dtype="float32",
                       crs=rasterio.CRS.from_epsg(25832), transform=where) as target:
        target.write(heights, 1)
    (folder / "dem.asc").write_text("ncols 20\nnrows 10\nxllcorner 0\nyllcorner 0\ncellsize 5\n" +
                                    "\n".join(10 * [" ".join(20 * ["1.5"])]) + "\n", encoding="utf-8")
    return True


def test_all(options):
    """An example that does not work as written."""
    commands = [line for path in DOCUMENTS for line in shown(path)]
    assert len(commands) >= LEAST, f"only {len(commands)} commands were found"
    examples = [line for name in COMMANDS for line in load(name).EXAMPLES]
    assert {line.split()[0] for line in commands} == set(COMMANDS), "a command that no page shows"
    rasters = write_rasters(options.work)
    for line in dict.fromkeys([*commands, *examples]):
        if line.startswith("terrain ") and not rasters:
            report.skipped(f"'{line}'", "the package rasterio is not installed")
            continue
        answer = call(*words_of(line, options), folder=options.work)
        # other meshes differ; the package vtk may be missing
        if line.startswith("check ") and answer.returncode == report.NOT_RUN:
            report.skipped(f"the readers of VTK in '{line}'", "the package vtk is not installed")
        # the short run has too few grains for an accurate measurement; the command must say so, and print all its
        # results before
        if line.startswith("grains ") and answer.returncode == 2 and "not above twice its error" in answer.stderr:
            report.skipped(f"the block of '{line}'", "the small cell does not resolve the measure")
            continue
        allowed = {"compare": (0, 1) if "coarse" in line else (0,), "check": (0, report.NOT_RUN)}
        said = re.sub(r"^(accuracy|validate): \d+ of \d+ runs.*\n", "", answer.stderr, flags=re.M)     # the progress
        assert answer.returncode in allowed.get(line.split()[0], (0,)) and not said, (
            f"scree-post {line}: exit {answer.returncode} {answer.stderr}{answer.stdout[-300:]}")


def test_scripts(options):
    """The scripts of the page."""
    text = (case.ROOT / "doc/guide/post_processing.md").read_text(encoding="utf-8")
    here, found = os.getcwd(), {}
    try:
        os.chdir(options.work)
        for script in re.findall(r"^```python\n(.*?)^```", text, re.M | re.S):
            exec(compile(script, "post_processing.md", "exec"), found)
    finally:
        os.chdir(here)
    ends = found["run"].history["kinetic"].iloc[-1], found["table"]["kinetic [J]"].iloc[-1]
    assert ends[0] == ends[1] > 0.0 and len(found["mass"]) > 100
