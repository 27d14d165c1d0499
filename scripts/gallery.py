# SPDX-License-Identifier: BSD-3-Clause
"""Generate the gallery: one page with the pictures and the first table of every scene.

    build/venv/bin/python scripts/gallery.py --scree build/bin/scree    # run the scenes, update all
    build/venv/bin/python scripts/gallery.py --page                     # update only the page

Scenes with a script input/SCENE/measure.py are run first, unless their results already exist; their
tables and pictures are written to their folders. Then doc/gallery.md is assembled from the READMEs.
"""
import argparse
import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "doc" / "gallery.md"
PICTURE = re.compile(r"!\[([^\]]*)\]\(([^)]+)\)")
WORKED = re.compile(r"<!--=seconds_all-->([\d.]+)<!--=-->")
FIGURES = re.compile(r"<!-- figures -->\n\n((?:\|.*\n)+)")
HEAD = """# Gallery

This page shows the scenes of `input`. The README of each scene gives the sources of its data, the results, and
known deviations. The page and its pictures are made by

```console
build/venv/bin/python scripts/gallery.py
```

This command runs all scenes without results. On one core the steps of all scenes take {minutes} minutes.
"""


def arguments():
    """The options."""
    parser = argparse.ArgumentParser(description="Run the scenes and make doc/gallery.md.")
    parser.add_argument("--scree", type=Path, default=ROOT / "build/bin/scree", help="path of the program")
    parser.add_argument("--out", type=Path, default=Path("out/scenes"), help="folder for the results")
    parser.add_argument("--only", nargs="+", metavar="SCENE", help="run only these scenes")
    parser.add_argument("--pictures", action="store_true", help="update only the pictures, not the numbers")
    parser.add_argument("--page", action="store_true", help="update only the page, without runs")
    return parser.parse_args()


def scenes():
    """Folders of scenes with a picture."""
    return [readme.parent for readme in sorted((ROOT / "input").glob("*/README.md"))
            if PICTURE.search(readme.read_text(encoding="utf-8"))]


def run(options):
    """Run the scenes that have a script measure.py. Returns the names of scenes that failed."""
    chosen = [folder for folder in scenes() if (folder / "measure.py").is_file()
              and (not options.only or folder.name in options.only)]
    failed = []
    for number, folder in enumerate(chosen, 1):
        begin = time.time()
        print(f"{number} of {len(chosen)}: {folder.name}", flush=True)
        answer = subprocess.run(
            [sys.executable, folder / "measure.py", "--scree", options.scree, "--out",
             options.out / folder.name, "--pictures" if options.pictures else "--write"], check=False,
            stdout=subprocess.DEVNULL)
        print(f"   {'done' if answer.returncode == 0 else 'failed'} in {time.time() - begin:.0f} s",
              flush=True)
        if answer.returncode:
            failed.append(folder.name)
    return failed


def section(folder):
    """Section of a scene: title, first paragraph in one line, pictures, first table, and a link to the scene."""
    text = (folder / "README.md").read_text(encoding="utf-8")
    paragraphs = [part.strip() for part in text.split("\n\n")]
    title = paragraphs[0].removeprefix("# ")
    lines = [f"## {title}", re.sub(r"\]\((?!http)([^)]+)\)", lambda link: relink(folder, link[1]),
                                   re.sub(r"\n(?![|*-])", " ", paragraphs[1]))]
    lines += [f"![{words}{relink(folder, place)}"
              for words, place in PICTURE.findall(text)]
    found = FIGURES.search(text)
    if found:
        lines.append(found[1].strip())
    lines.append(f"[More](../input/{folder.name}/README.md)")
    return "\n\n".join(lines)


def relink(folder, target):
    """A link in the README of a scene, rewritten so that it is valid in the page."""
    return f"]({os.path.relpath((folder / target).resolve(), PAGE.parent)})"


def minutes():
    """Processor time of all scenes by their READMEs [min]."""
    seconds = sum(float(found) for folder in scenes()
                  for found in WORKED.findall((folder / "README.md").read_text(encoding="utf-8")))
    return f"{float(f'{seconds / 60.0:.1g}'):g}"


def page():
    """The whole page."""
    return HEAD.format(minutes=minutes()) + "\n" + "\n\n".join(section(folder) for folder in scenes()) + "\n"


def main():
    """Run and write; exit code 1 if a scene failed."""
    options = arguments()
    failed = [] if options.page else run(options)
    PAGE.write_text(page(), encoding="utf-8")
    print(PAGE.relative_to(ROOT))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
