# SPDX-License-Identifier: BSD-3-Clause
"""Draw the folders of src/ and their dependencies, from the `use` lines of the sources.

    python3 scripts/document_rooms.py             write doc/developer/rooms.svg
    python3 scripts/document_rooms.py --check     exit code 1 if the drawing is out of date

An arrow A -> B means that A uses modules of B. Arrows that follow from others (A -> B -> C implies A -> C) are omitted.
Only the standard library is needed.
"""
import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DRAWING = ROOT / "doc/developer/rooms.svg"
USE = re.compile(r"^\s*use\s+(\w+)", re.M)
# Content of each folder in a few words; the subfolders of src/ are added.
CONTENT = {
    "base": "errors, MPI, files, exact sums", "deck": "text of a deck to checked values",
    "mesh": "grid, tiles, patches, walls", "material": "laws and their update",
    "particle": "stores, shapes, migration", "transfer": "particles to nodes and back",
    "sample": "fields, gauges, fragments", "io": "HDF5, tables, checkpoints", "ddmp": "dual gradient",
    "exact": "exact solutions", "grains": "periodic cell of grains", "step": "one time step",
    "scene": "deck to first state", "output": "streams, summary", "run": "a run from deck to end",
    "program": "command line", "library": "runs in other programs",
}
VARIANTS = ("serial", "parallel")                     # subfolders for different builds, of which one is compiled
BOX_WIDTH, BOX_HEIGHT, GAP_X, GAP_Y, MARGIN = 200, 62, 40, 46, 12


def uses():
    """{folder: folders whose modules it uses}"""
    sources = [path for path in sorted((ROOT / "src").rglob("*")) if path.name.endswith((".f90", ".f90.in"))]
    folder_of = {path.name.split(".")[0]: path.relative_to(ROOT / "src").parts[0] for path in sources}
    found = {folder: set() for folder in folder_of.values()}
    for path in sources:
        names = USE.findall(path.read_text(encoding="utf-8"))
        folder = path.relative_to(ROOT / "src").parts[0]
        found[folder] |= {folder_of[name] for name in names if name in folder_of} - {folder}
    return found


def reach(used, folder):
    """All folders that a folder depends on."""
    found = set()
    for lower in used[folder]:
        found |= {lower} | reach(used, lower)
    return found


def reduced(used):
    """The same dependencies without those that follow from others."""
    return {folder: {lower for lower in lowers
                     if not any(lower in reach(used, other) for other in lowers - {lower})}
            for folder, lowers in used.items()}


def rows_below(used):
    """{folder: row of the drawing}: each folder is in the row below the lowest folder that uses it."""
    row = {}
    while len(row) < len(used):
        for folder in used:
            users = [user for user, lowers in used.items() if folder in lowers]
            if folder not in row and all(user in row for user in users):
                row[folder] = 1 + max((row[user] for user in users), default=-1)
    return row


def steps(used, row):
    """{folder: places directly below it}, where the place of an arrow that passes a row is (folder, lower, row)."""
    below = {}
    for folder, lowers in reduced(used).items():
        for lower in lowers:
            path = [folder, *((folder, lower, number) for number in range(row[folder] + 1, row[lower])), lower]
            for upper, place in zip(path, path[1:]):
                below.setdefault(upper, set()).add(place)
    return below


def corners(used):
    """{folder, or place of an arrow: upper left corner}: rows are centred, and in a row each place is as near as
    possible to those above that use it, so that arrows are short and pass no box."""
    row = rows_below(used)
    below = steps(used, row)
    row.update({place: place[2] for places in below.values() for place in places if isinstance(place, tuple)})
    rows = [sorted((place for place in row if row[place] == number), key=str)
            for number in range(max(row.values()) + 1)]
    widest = max(len(line) for line in rows)
    x = {}
    for line in rows:
        def wanted(place):
            users = [x[user] for user, places in below.items() if place in places]
            return (sum(users)/len(users) if users else 0.0, str(place))

        left = (widest - len(line))/2
        x.update({place: left + number for number, place in enumerate(sorted(line, key=wanted))})
    return {place: (MARGIN + x[place]*(BOX_WIDTH + GAP_X), MARGIN + row[place]*(BOX_HEIGHT + GAP_Y)) for place in row}


def subfolders(folder):
    """Names of the subfolders that divide a folder by subjects."""
    return [path.name for path in sorted((ROOT / "src" / folder).iterdir())
            if path.name not in VARIANTS and any(path.glob("*.f90"))]


def drawing(used):
    """Text of the SVG file."""
    corner = corners(used)
    width = max(x for x, _ in corner.values()) + BOX_WIDTH + MARGIN
    height = max(y for _, y in corner.values()) + BOX_HEIGHT + MARGIN
    lines = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" '
             f'width="{width:.0f}" height="{height:.0f}" font-family="sans-serif" text-anchor="middle">',
             '<!-- Written by scripts/document_rooms.py; do not edit it. -->',
             '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="8" markerHeight="8" '
             'orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#555"/></marker></defs>',
             f'<rect width="{width:.0f}" height="{height:.0f}" fill="white"/>']
    for upper, places in sorted(steps(used, rows_below(used)).items(), key=str):
        x, y = corner[upper]
        for place in sorted(places, key=str):
            to_x, to_y = corner[place]
            # an arrow that passes a row is a vertical line there
            shift = max(-0.35, min(0.35, (to_x - x)/width))*BOX_WIDTH
            from_x = x + BOX_WIDTH/2 + (0 if isinstance(upper, tuple) else shift)
            passes = isinstance(place, tuple)
            to_x += BOX_WIDTH/2 - (0 if passes else shift)
            points = f"{from_x:.0f},{y + BOX_HEIGHT:.0f} {to_x:.0f},{to_y:.0f}"
            points += f" {to_x:.0f},{to_y + BOX_HEIGHT:.0f}" if passes else ""
            head = "" if passes else ' marker-end="url(#head)"'
            lines.append(f'<polyline points="{points}" fill="none" stroke="#555" stroke-width="1.2"{head}/>')
    for folder in sorted(used):
        x, y = corner[folder]
        lines.append(f'<rect x="{x:.0f}" y="{y:.0f}" width="{BOX_WIDTH}" height="{BOX_HEIGHT}" rx="6" fill="#e8f0f8" '
                     'stroke="#34597f"/>')
        texts = [(folder, 'font-size="15" font-weight="bold"'), (CONTENT[folder], 'font-size="12"'),
                 (" ".join(subfolders(folder)), 'font-size="11" fill="#555"')]
        lines += [f'<text x="{x + BOX_WIDTH/2:.0f}" y="{y + 18*line + 18:.0f}" {style}>{text}</text>'
                  for line, (text, style) in enumerate(texts) if text]
    return "\n".join([*lines, "</svg>"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true",
                        help="compare without writing; exit code 1 if the drawing differs")
    options = parser.parse_args()
    text = drawing(uses())
    if not options.check:
        DRAWING.write_text(text, encoding="utf-8")
    elif not DRAWING.exists() or DRAWING.read_text(encoding="utf-8") != text:
        sys.exit("doc/developer/rooms.svg is out of date: run python3 scripts/document_rooms.py")


if __name__ == "__main__":
    main()
