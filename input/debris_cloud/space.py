# SPDX-License-Identifier: BSD-3-Clause
"""The debris cloud in space: a picture, a film, and radiographs of the cloud for the documents.

    python input/debris_cloud/space.py --scree build/bin/scree

runs a quarter in three dimensions with eight cells through the sheet and a jittered start (817 000 particles, a quarter
of an hour on one core), unless its results are there, and writes doc/learn/debris_cloud_space.png,
doc/learn/debris_cloud.mp4 and doc/learn/debris_cloud.png. Mirror images at x = 0 and y = 0 complete the quarter.
"""
import argparse
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python/src")]
import scree_post                      # noqa: E402
from scree_post.command import main    # noqa: E402

HERE, PAGES = Path(__file__).resolve().parent, ROOT / "doc/learn"
#: Deck and what is changed: case names of the results.
RUNS = {"quarter": ("quarter_3d.nml", {
            "grid.dx": 1.55 / 8.0, "time.t_end": 8.75, "region[plate].hi": "20.15,20.15,1.55", "output[cloud].dt": 0.25,
            "body[sphere].packing": "jitter", "body[sheet].packing": "jitter",
            "output[cloud].fields": "'mass','volume','velocity','body','failed','damage'"})}
TITLE = "Aluminium sphere, 9.53 mm, through an aluminium sheet at 6.71 km/s"
LOOK = ("--colour", "velocity", "--map", "plasma", "--range", "0", "7km/s", "--up", "x", "--title", TITLE,
        "--surface", "--view", "-46mm", "62mm", "-42mm", "46mm")


def results(name, options):
    """Folder of a run, which is made if it is not there."""
    folder = options.out / name
    if not list(folder.glob("*.summary.json")):
        deck, values = RUNS[name]
        words = [word for key, value in values.items() for word in ("--set", f"{key}={value}")]
        subprocess.run([options.scree, HERE / deck, *words, "--outdir", folder, "--overwrite"], check=True)
    return str(folder)


def work():
    """Run and draw."""
    parser = argparse.ArgumentParser(description="Draw the debris cloud in space.")
    parser.add_argument("--scree", type=Path, default=ROOT / "build/bin/scree", help="the program")
    parser.add_argument("--out", type=Path, default=Path("out/space"), help="folder of the results")
    parser.add_argument("--only", choices=("picture", "film", "radiograph"), help="one of the three")
    options = parser.parse_args()
    if options.only in (None, "picture"):
        main(["picture", results("quarter", options), *LOOK, "--camera", "-54,14", "--dpi", "214",
              "--out", str(PAGES / "debris_cloud_space.png")])
        scree_post.make_small(PAGES / "debris_cloud_space.png", dither=True)
    if options.only in (None, "film"):
        main(["movie", results("quarter", options), *LOOK, "--camera", "-65,18", "--turn", "35", "--dpi", "107",
              "--rate", "12", "--quality", "30", "--out", str(PAGES / "debris_cloud.mp4")])
    if options.only in (None, "radiograph"):
        main(["radiograph", results("quarter", options), "--time", "2", "4.25", "6.5", "8.75", "--dpi", "130",
              "--view", "-36mm", "66mm", "-33mm", "33mm", "--out", str(PAGES / "debris_cloud.png")])
        scree_post.make_small(PAGES / "debris_cloud.png", 800000)
    return 0


if __name__ == "__main__":
    scree_post.run(work, "space")
