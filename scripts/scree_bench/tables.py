# SPDX-License-Identifier: BSD-3-Clause
"""Tables of results for the terminal and in Markdown, and comparisons of two files or two programs."""
import os
import re
from pathlib import Path

from scree.errors import ScreeError

BEGIN, END = "<!-- table -->", "<!-- end -->"
ORDER = ("sort", "to nodes", "nodes", "exchange", "to particles", "contact", "conduction", "waiting", "material")
LEAST = 0.005                            # a phase has a column if it takes at least this share of a case's time


def head(whole):
    """Lines that describe the measurement and the machine."""
    here, one = whole["machine"], whole["programs"][0]
    repeats = max((len(program["runs"]) for entry in whole["results"] for program in entry["programs"]), default=0)
    return [f"{here['processor']}, {here['cores']} cores, {here['vectors'] or 'vectors unknown'}, "
            f"{here['memory_gib']:g} GiB; {here['system']}",
            f"scree {one['version']} (git {one['commit']}), {one['compiler']} {one['build']} {one['flags']}, "
            f"{one['mpi']}",
            f"--size {whole['size']}, best of {repeats}, measured {whole['begun']} in "
            f"{whole['seconds'] / 60.0:.1f} minutes"]


def phases_in(entries):
    """Phases that have a column: the usual ones in their order, then others; phases with a negligible time have
    none."""
    seen = {}
    for entry in entries:
        one = entry["programs"][0]
        for name, part in one.get("phases_ns", {}).items():
            seen[name] = max(seen.get(name, 0.0), part / one["ns"])
    names = [*ORDER, *sorted(set(seen) - set(ORDER))]
    return [name for name in names if seen.get(name, 0.0) >= LEAST]


def speed_rows(whole):
    """Heading and rows of the table of speed, as texts. Phases without a column are added to the last one, so that the
    phases of a row add up to its time."""
    phases = phases_in(whole["results"])
    heads = ["case", "M/s core", "M/s wall", "ns", "+%", *phases, "rest", "bytes", "copy", "per MB"]
    rows = []
    for entry in whole["results"]:
        one = entry["programs"][0]
        if "ns" not in one:
            continue
        parts = [one["phases_ns"].get(name, 0.0) for name in phases]
        rows.append([entry["case"], f"{1e-6 * one['updates_per_core_s']:.2f}",
                     f"{1e-6 * one['updates_per_wall_s']:.2f}", f"{one['ns']:.0f}",
                     f"{100.0 * (one['ns_most'] / one['ns'] - 1.0):.0f}", *(f"{part:.0f}" for part in parts),
                     f"{max(sum(one['phases_ns'].values()) - sum(parts), 0.0):.0f}",
                     f"{one['bytes_per_particle']:.0f}", f"{one['copy_gb_s']:.1f}", f"{one['updates_per_mb']:.0f}"])
    rests = heads.index("rest")
    if all(row[rests] == "0" for row in rows):
        heads, rows = heads[:rests] + heads[rests + 1:], [row[:rests] + row[rests + 1:] for row in rows]
    return heads, rows


def remarks(whole):
    """Lines about cases without results, or with results of only one program."""
    lines = []
    for entry in whole["results"]:
        if entry["skipped"]:
            lines.append(f"{entry['case']}: skipped, {entry['skipped']}")
        lines += [f"{entry['case']}: {name}failed, {one['failed']}"
                  for name, one in zip(("", "the other program "), entry["programs"]) if one["failed"]]
    return lines


def plain(heads, rows):
    """A table for the terminal: the first column is left-aligned, numbers are right-aligned."""
    widths = [max(len(line[column]) for line in (heads, *rows)) for column in range(len(heads))]
    lines = [[line[0].ljust(widths[0]), *(cell.rjust(width) for cell, width in zip(line[1:], widths[1:]))]
             for line in (heads, *rows)]
    return "\n".join("  ".join(line).rstrip() for line in lines)


def marked(heads, rows):
    """The same table in Markdown."""
    lines = [heads, ["---", *["--:"] * (len(heads) - 1)], *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def turn_rows(whole):
    """Heading and rows of the table of two programs that alternate."""
    rows = []
    for entry in whole["results"]:
        found = entry.get("turns")
        if found:
            rows.append([entry["case"], *(f"{one['ns']:.1f}" for one in entry["programs"]), f"{found['median']:.3f}",
                         f"{found['least']:.3f}", f"{found['most']:.3f}", f"{found['of_best']:.3f}"])
    return ["case", "ns", "ns other", "speed:other", "least", "most", "of best"], rows


def terminal(whole):
    """All text that is printed after a measurement."""
    lines = [*head(whole), ""]
    lines += [plain(*speed_rows(whole)), "", legend()]
    if len(whole["programs"]) == 2:
        two = whole["programs"][1]
        lines += ["", f"Speed over that of the other program, scree {two['version']} (git {two['commit']}), "
                  f"{two['compiler']} {two['build']}: median, least and most of {whole['repeats']} repeats in turns",
                  plain(*turn_rows(whole))]
    return "\n".join([*lines, *remarks(whole)])


def legend():
    """Explanation of the columns."""
    return ("M/s: million particle updates per second of core time and of wall time. ns: core time of a particle and\n"
            "step, and of its phases; +%: slowest repeat over the best. bytes: of fields per particle. copy: GB/s of\n"
            "a core, measured beside. per MB: updates in the time in which a core copies 1 MB.")


def markdown(whole):
    """The tables as Markdown."""
    lines = ["\n".join(f"{line}  " for line in head(whole)[:-1]), head(whole)[-1] + ".", "", marked(*speed_rows(whole))]
    if len(whole["programs"]) == 2:
        two = whole["programs"][1]
        lines += ["", f"Speed over that of scree {two['version']} (git {two['commit']}), in turns:", "",
                  marked(*turn_rows(whole))]
    told = remarks(whole)
    return "\n".join(lines + ["", *(f"* {line}" for line in told)] if told else lines) + "\n"


def check_page(path):
    """Raise an error before the measurement if the page cannot be written."""
    page = Path(path)
    if not page.is_file():
        if page.is_dir() or not page.parent.is_dir() or not os.access(page.parent, os.W_OK):
            raise ScreeError(f"--markdown {path}: cannot write there; name a file in a folder of yours")
        return
    text = page.read_text(encoding="utf-8", errors="replace")
    if text and (BEGIN not in text or END not in text.partition(BEGIN)[2]):
        raise ScreeError(f"--markdown {path}: the file exists and has no lines {BEGIN} and {END}; add them where the "
                        "table shall be, or name a new file")


def write_page(path, text):
    """Write a new page, or replace the part of an existing one between its two marks."""
    page, whole = Path(path), f"{BEGIN}\n{text}{END}\n"
    check_page(path)
    if page.is_file() and page.stat().st_size:
        old = page.read_text(encoding="utf-8")
        whole = re.sub(rf"{BEGIN}\n.*?{END}\n?", lambda _: whole, old, count=1, flags=re.S)
    try:
        page.write_text(whole, encoding="utf-8")
    except OSError as error:
        raise ScreeError(f"cannot write {path}: {error.strerror}") from error


def compared(first, second, limit):
    """Rows of a comparison, sentences about cases that are slower than the limit, and sentences about cases that only
    one file contains.

    A case is slower if its updates per MB copied are less than 1/limit of those of the first file.
    """
    old = {entry["case"]: entry for entry in first["results"]}
    new = {entry["case"]: entry for entry in second["results"]}
    rows, slower, lacking, differing = [], [], {"first": [], "second": []}, []
    for name in [*old, *(name for name in new if name not in old)]:
        pair = [held.get(name, {"programs": [{}]})["programs"][0] for held in (old, new)]
        for which, one in zip(lacking, pair):
            if "ns" not in one:
                lacking[which].append(name)
        if all("ns" in one for one in pair) and old[name]["deck"] != new[name]["deck"]:
            differing.append(name)
        elif all("ns" in one for one in pair):
            speed = pair[0]["ns"] / pair[1]["ns"]
            ratio = pair[1]["updates_per_mb"] / pair[0]["updates_per_mb"]
            is_slower = ratio * limit < 1.0
            rows.append([name, f"{pair[0]['ns']:.0f}", f"{pair[1]['ns']:.0f}", f"{speed:.2f}",
                         f"{pair[0]['updates_per_mb']:.0f}", f"{pair[1]['updates_per_mb']:.0f}", f"{ratio:.2f}",
                         "slower" if is_slower else ""])
            if is_slower:
                slower.append(f"{name}: {1.0 / ratio:.2f} times slower per MB copied, limit {limit:g}")
    missing = [f"no numbers in the {which} file: {', '.join(names)}" for which, names in lacking.items() if names]
    return rows, slower, missing + ([f"not compared, the decks differ: {', '.join(differing)}"] if differing else [])


COMPARED = ["case", "ns A", "ns B", "speed B:A", "per MB A", "per MB B", "B:A", ""]


def slower_in_turns(whole, limit):
    """Sentences about cases in which the first program is slower than the second by more than the limit."""
    medians = {entry["case"]: entry["turns"]["median"] for entry in whole["results"] if entry.get("turns")}
    return [f"{case}: {1.0 / median:.2f} times slower than the other program, limit {limit:g}"
            for case, median in medians.items() if median * limit < 1.0]
