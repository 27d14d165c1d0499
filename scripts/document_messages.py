# SPDX-License-Identifier: BSD-3-Clause
"""Write doc/reference/messages/, a page for each row of the tables of messages, and link the rows to them.

    python3 scripts/document_messages.py --scree build/bin/scree             write the pages
    python3 scripts/document_messages.py --scree build/bin/scree --check     exit code 1 if out of date

A page has cause and remedy of its row, sentences of scripts/messages/*.txt, and an example: the
program is run on a wrong deck, and what it prints is shown. The deck is that of a row of the tables
of test/input (broken_values.py, broken_scenes.py) with this message, unless scripts/messages holds
another one (examples.py: decks; situations.py: commands, files and runs).

A new message: write its row into doc/reference/errors.md or errors_runs.md without a link, run this script, look at
the page. Only the standard library is needed.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GUIDE = ROOT / "doc" / "reference"
TABLES = [GUIDE / "errors.md", GUIDE / "errors_runs.md"]
PAGES = GUIDE / "messages"
NOTES = ROOT / "scripts" / "messages"
sys.path[:0] = [str(ROOT / "scripts" / "messages"), str(ROOT / "test" / "input")]
import broken_scenes as scenes   # noqa: E402
import broken_values as values   # noqa: E402
import examples                  # noqa: E402
import situations                # noqa: E402

FAULTS = [values.KINDS, values.NUMBERS, values.UNKNOWN, values.MARKS, scenes.CONTRADICTIONS, scenes.CELLS,
          scenes.NAMES, scenes.ORPHANS, scenes.BODIES, scenes.ANGLES, scenes.SIZES, scenes.INCLUDES,
          scenes.RARE, scenes.WARNINGS]
DECK = "scene.nml"
CHECK = f"scree --check {DECK}"
# In a table: the link, what stands behind it in the first cell, cause, remedy.
LINKED = re.compile(r"\| \[(`.+`)\]\(messages/([a-z0-9-]+)\.md\)(.*?) \| (.*) \| (.*) \|$")
PLAIN = re.compile(r"\| ((?:`[^`]+`(?:, )?)+)(.*?) \| (.*) \| (.*) \|$")
# What the run time library of a Debug build adds.
DEBUG = re.compile(r"At line \d+ of file |Fortran runtime warning: An array temporary")
WORDS = 7                        # of a message that become the name of its page
WIDEST = 110                     # columns of a line of a deck that is shown whole
FEW = 4                          # lines of a deck that are shown in a row
# Where to read on: about a group, besides its keys, or where there is none about a kind of messages.
ABOUT = {
    "run": "../guide/deck.md#dimension", "units": "../guide/deck.md#units", "include": "../guide/deck.md#rules", "grid": "../guide/deck.md#dimension",
    "region": "../guide/shapes.md", "body": "../guide/deck.md#shapes-and-bodies", "material": "materials.md",
    "boundary": "../guide/deck.md#faces", "effects": "effects.md", "contact": "../guide/deck.md#contact", "output": "../guide/deck.md#output",
    "time": "../guide/running.md#how-a-run-ends", "checkpoint": "../guide/running.md#checkpoints-and-restart",
    "Letters and groups": "../guide/deck.md#rules", "Units": "../guide/deck.md#units", "Command line": "../guide/running.md",
    "Runs that end early": "../guide/running.md#how-a-run-ends", "Files": "../guide/running.md#checkpoints-and-restart"}
# Keys that are words of prose as well: they count only before an equals sign.
PROSE = {"at", "axis", "bodies", "body", "fields", "file", "law", "material", "name", "of", "region", "shape",
         "solution", "type", "scale", "velocity", "stress", "spin"}

class Row:
    """A row of a table."""

    def __init__(self, heading, messages, name, behind, cause, remedy):
        self.heading, self.name = heading, name
        self.messages = re.findall("`([^`]+)`", messages)
        self.behind, self.cause, self.remedy = behind, cause, remedy

    def pattern(self):
        """What fits one of the messages: three points stand for anything."""
        return re.compile("|".join(".*?".join(map(re.escape, text.split("..."))) for text in self.messages))


def name_of(messages):
    """Name of a page: the first words of the message."""
    first = re.findall("`([^`]+)`", messages)[0].lower()
    return "-".join(re.findall(r"[a-z0-9]+", first)[:WORDS])


def linked(text):
    """The text of a table with a link in each row."""
    lines = []
    for line in text.splitlines():
        found = PLAIN.match(line)
        if found:
            messages, behind, cause, remedy = found.groups()
            line = f"| [{messages}](messages/{name_of(messages)}.md){behind} | {cause} | {remedy} |"
        lines.append(line)
    return "\n".join(lines) + "\n"


def rows(text):
    """Rows of a table, all with links."""
    heading, found = "", []
    for line in text.splitlines():
        if line.startswith("## "):
            heading = line[3:]
        match = LINKED.match(line)
        if match:
            found.append(Row(heading, *match.groups()))
    return found


def notes():
    """Further sentences by the name of the page."""
    found = {}
    for path in sorted(NOTES.glob("*.txt")):
        parts = re.split(r"^\[([a-z0-9-]+)\]\n", path.read_text(encoding="utf-8"), flags=re.M)
        found.update((name, text.strip()) for name, text in zip(parts[1::2], parts[2::2]))
    return found


class Runner:
    """Runs commands as a shell does, in a folder of their own, with `scree` as the program."""

    def __init__(self, program, folder):
        self.folder, self.right = Path(folder), {}
        commands = self.folder / "bin"
        commands.mkdir()
        (commands / "scree").symlink_to(Path(program).resolve())
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("SLURM_", "PBS_"))}
        # one thread, messages in English, and lines that come when they are written
        self.environment.update(
            PATH=f"{commands}:{os.environ['PATH']}", LC_ALL="C", OMP_NUM_THREADS="1",
            OMP_WAIT_POLICY="passive", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
            OMPI_MCA_btl_vader_single_copy_mechanism="none", GFORTRAN_UNBUFFERED_ALL="1")
        self.count = count()
        self.version = "scree X.Y.Z"
        head = self.run(folder, "scree --version")[1][0]
        self.version, self.traps = " ".join(head.split()[:2]), " Debug " in head

    def place(self, files):
        """A new folder with some files."""
        place = self.folder.resolve() / str(next(self.count))
        place.mkdir()
        for name, content in files.items():
            (place / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return place

    def run(self, place, command):
        """Exit code and lines that a command prints. Of a check only the verdict on the deck is wanted."""
        checks = command.startswith("scree --check")
        words = ["/bin/sh", "-c", f"exec {command}" if checks else command]
        process = subprocess.Popen(words, cwd=place, env=self.environment, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT)
        lines = []
        with process:
            for line in process.stdout:
                line = line.decode(errors="replace").rstrip("\n")
                if DEBUG.match(line):
                    continue
                lines.append(line)
                if checks and re.search(r" \d+ groups, 0 errors, \d+ warnings$", lines[-1]):
                    process.kill()   # sizes and estimates come next, which differ among machines
                    lines.append("...")
                    break
        code = 0 if lines and lines[-1] == "..." else process.returncode
        return code, [line.replace(str(place), "/opt/programs").replace(self.version, "scree X.Y.Z")
                      for line in lines]

    def succeed(self, row, place, command):
        """Run a command that must not fail."""
        code, said = self.run(place, command)
        if code not in (0, 75) or any(" 1 warnings" in line for line in said):
            raise ValueError(f"{row.name}: {command} has exit code {code}:\n" + "\n".join(said))

    def faults(self, files):
        """What is said of a deck that should have neither errors nor warnings; empty if it has none."""
        key = repr(sorted(files.items()))
        if key not in self.right:
            said = self.run(self.place(files), CHECK)[1]
            self.right[key] = "" if any(" 0 errors, 0 warnings" in line for line in said) else "\n".join(said)
        return self.right[key]


def visible(line):
    """A line of the program, with numbers for letters that cannot be shown."""
    return "".join(letter if letter >= " " else f"<{ord(letter)}>" for letter in line)


def shorter(line):
    """A line of a deck that can be shown."""
    line = visible(line)
    return line if len(line) <= WIDEST else line[:WIDEST // 2] + " ... " + line[-WIDEST // 3:]


def changed(old, new):
    """Places of lines from the first to behind the last that differ, in both texts."""
    first = 0
    while first < min(len(old), len(new)) and old[first] == new[first]:
        first += 1
    last = 0
    while last < min(len(old), len(new)) - first and old[-1 - last] == new[-1 - last]:
        last += 1
    return first, len(old) - last, len(new) - last


def excerpt(lines, first, last, told=0):
    """Lines of a deck with marks: those that differ, that of the message, and one more if there is none."""
    chosen = set(range(first, last))
    if told:
        chosen.add(told - 1)
    if not any(lines[place] for place in chosen):
        chosen = {max(first - 1, 0), min(last, len(lines) - 1)}
    if max(chosen) - min(chosen) < FEW:
        chosen = set(range(min(chosen), max(chosen) + 1))
    shown, before = [], min(chosen) - 1
    for place in sorted(chosen):
        if place > before + 1:
            shown.append("...")
        mark = f"   ! <-- line {place + 1}" if place + 1 == told else ""
        shown.append(shorter(lines[place]) + mark)
        before = place
    return shown


def block(language, lines):
    """A fenced block."""
    return "\n".join([f"```{language}", *lines, "```"])


def deck_example(row, runner):
    """The line with the message, and text of a deck that brings it; None if there is none."""
    given = examples.DECKS.get(row.name)
    if given is None:
        given = next(((deck, old, new, None) for table in FAULTS for deck, old, new, _, said in table
                      if row.pattern().search(said)), None)
    if given is None:
        return None
    deck, old, new, better = given
    text = values.DECKS.get(deck, deck)
    if old not in text:
        raise ValueError(f"{row.name}: the deck does not hold {old!r}")
    wrong = text.replace(old, new, 1)
    right = text.replace(old, old if better is None else better, 1)
    files = examples.FILES.get(row.name, {})
    faults = runner.faults({**files, DECK: right})
    if faults:
        raise ValueError(f"{row.name}: the deck that should be right is not:\n{right}{faults}")
    code, said = runner.run(runner.place({**files, DECK: wrong}), CHECK)
    told = next((line for line in said if row.pattern().search(line)), None)
    if told is None:
        raise ValueError(f"{row.name}: the example does not bring the message, but\n" + "\n".join(said))
    line = re.match(rf"{DECK}:(\d+):", told)
    line = int(line.group(1)) if line else 0
    wrong_lines, right_lines = (re.split("\r?\n", part.rstrip("\n")) for part in (wrong, right))
    first, wrong_last, right_last = changed(wrong_lines, right_lines)
    parts = [f"Wrong, in `{DECK}`:", block("fortran", excerpt(wrong_lines, first, wrong_last, line)),
             f"What the program says{' as a warning' if code == 0 else ''}; its exit code is {code}:",
             block("console", [f"$ {CHECK}", *map(visible, said)]),
             "Right:", block("fortran", excerpt(right_lines, max(0, first - (wrong_last == first)), right_last))]
    return told, "\n\n".join(parts)


def situation_example(row, runner):
    """The line with the message, and text of commands and what they print; None if there are none."""
    situation = situations.SITUATIONS.get(row.name)
    if situation is None:
        return None
    place, language = runner.place(situation.get("files", {})), situation.get("language", "fortran")
    for command in situation.get("before", []):
        runner.succeed(row, place, command)
    lines, everything, code = [], [], 0
    for command in situation["commands"]:
        shown, command = (command, command) if isinstance(command, str) else command
        code, said = runner.run(place, command)
        everything += said
        if len(said) > situation.get("last", len(said)):
            said = ["...", *said[-situation["last"]:]]
        lines += [f"$ {shown}", *map(visible, said)]
    told = next((line for line in everything if row.pattern().search(line)), None)
    if told is None:
        raise ValueError(f"{row.name}: the example does not bring the message, but\n" + "\n".join(everything))
    text = situation.get("text", "")
    parts = [text if "shows" in situation else text.rstrip(":") + "."] if text else []
    if "shows" in situation:
        parts.append(block(language, situation["shows"].strip("\n").split("\n")))
    parts += [f"What the program says{' as a warning' if ' warning: ' in told else ''}; its exit code is {code}:",
              block("console", lines)]
    better = []
    for command in situation.get("then", []):
        shown, command = (command, command) if isinstance(command, str) else command
        steps = re.search(r"time\.max_steps=(\d+)", " ".join(everything))
        if steps:
            shown, command = (text.format(max_steps=steps.group(1)) for text in (shown, command))
        runner.succeed(row, place, command)
        better.append(f"$ {shown}")
    if better:
        parts += ["Right:", block("console", better)]
    if "right" in situation:
        parts += ["Right:", block(language, situation["right"].strip("\n").split("\n"))]
    if "right_files" in situation:
        place = runner.place({**situation["files"], **situation["right_files"]})
        for command in [*situation.get("before", []), situation["commands"][-1]]:
            runner.succeed(row, place, command)
    return told, "\n\n".join(parts)


def keys():
    """Names of keys by groups, from keys.md."""
    found, group = {}, ""
    for line in (GUIDE / "keys.md").read_text(encoding="utf-8").splitlines():
        if line.startswith("## &"):
            group = line[4:]
            found[group] = []
        elif group and re.match(r"\| `\w+` \|", line):
            found[group].append(line.split("`")[1])
    return found


def title_of(target):
    """What a link to a document, or to a section of it, is called."""
    name, _, anchor = target.partition("#")
    headings = re.findall(r"^#+ (.*)", (GUIDE / name).read_text(encoding="utf-8"), re.M)
    if not anchor:
        return headings[0]
    slugs = {re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-"): heading for heading in headings}
    if anchor not in slugs:
        raise ValueError(f"{target} is no heading")
    return f"{headings[0]}, {slugs[anchor]}"


def see_also(row, told, known):
    """Links to keys and pages that concern a message."""
    links, about = [], row.heading
    found = re.search(r"&(\w+)", told or "")
    group = found.group(1) if found and found.group(1) in known else None
    text = re.sub("'[^']*'", "", told.split(f"&{group}", 1)[1]) if group else " ".join(row.messages)
    words = dict.fromkeys(re.findall(r"\b[a-z]\w*\b", text))
    if not group:    # a message of no group may name a key that only one group has
        owners = [name for name in known for key in known[name] if key in words and "_" in key]
        group = owners[0] if len(set(owners)) == 1 else None
    if group:
        named = [f"`{key}`" for key in words
                 if key in known[group] and (key not in PROSE or re.search(rf"\b{key} =", text))][:3]
        links.append((f"{' and '.join(named)} of " if named else "") + f"[&{group}](../keys.md#{group})")
        about = group
    targets = re.findall(r"\]\(([^)\s]+)\)", row.cause + row.remedy)
    targets += situations.SITUATIONS.get(row.name, {}).get("see", [])
    about = row.heading if row.heading in ("Letters and groups", "Units") else about
    targets += [ABOUT[about]] if about in ABOUT and not targets else []
    links += [f"[{title_of(target)}](../{target})" for target in dict.fromkeys(targets) if target != "keys.md"]
    return f"See {', '.join(links + ['[all messages](../errors.md)'])}."


def sentence(text):
    """A capital in front, a stop behind, links as seen from a folder below."""
    text = re.sub(r"\]\((?!http)", "](../", text.strip())
    return text[0].upper() + text[1:] + ("" if text.endswith((".", "?")) else ".")


def page(row, runner, more, known):
    """The whole page of a row."""
    example = situation_example(row, runner) or deck_example(row, runner)
    parts = ["# " + ", ".join(f"`{text.strip()}`" for text in row.messages) + row.behind,
             f"**What is wrong.** {sentence(row.cause)}", f"**What to do.** {sentence(row.remedy)}"]
    if row.name in more:
        parts.append(more[row.name])
    if example:
        parts.append(example[1])
    parts.append(see_also(row, example and example[0], known))
    return "\n\n".join(parts) + "\n"


def documents(program):
    """Texts by path: the tables with their links, and all pages."""
    tables = {path: linked(path.read_text(encoding="utf-8")) for path in TABLES}
    for path, table in tables.items():
        if not 0 < len(rows(table)) == len(re.findall(r"^\| \[?`", table, re.M)):
            raise ValueError(f"a row of {path.name} is no row of three cells")
    found, more, known = [row for table in tables.values() for row in rows(table)], notes(), keys()
    names = [row.name for row in found]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise ValueError(f"pages of two rows: {twice}; write the link of one by hand")
    strange = set(more).union(situations.SITUATIONS, examples.DECKS, examples.FILES) - set(names)
    if strange:
        raise ValueError(f"sentences or examples of no row: {sorted(strange)}")
    faults = []
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        runner = Runner(program, folder)

        def write(row):
            path = PAGES / f"{row.name}.md"
            if runner.traps and situations.SITUATIONS.get(row.name, {}).get("traps"):
                return path, path.read_text(encoding="utf-8")
            try:
                return path, page(row, runner, more, known)
            except ValueError as fault:
                faults.append(str(fault))
                return path, ""

        # most of the time goes into the start of message passing, which waits
        with ThreadPoolExecutor(4) as pool:
            texts = {**tables, **dict(pool.map(write, found))}
    if faults:
        raise ValueError("\n\n".join(faults))
    return texts


def out_of_date(texts):
    """Files that are not as they should be, each with why."""
    there = {path: path.read_text(encoding="utf-8") for path in [*TABLES, *sorted(PAGES.glob("*"))]}
    return ([f"{path.name} is missing" for path in texts if path not in there]
            + [f"{path.name} belongs to no row of a table" for path in there if path not in texts]
            + [f"{path.name} differs" for path in texts if path in there and there[path] != texts[path]])


def main():
    """Write the files, or compare them."""
    parser = argparse.ArgumentParser(prog="document_messages.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--scree", metavar="PROGRAM", default=ROOT / "build/bin/scree", help="the program")
    parser.add_argument("--check", action="store_true", help="only compare")
    arguments = parser.parse_args()
    if not Path(arguments.scree).is_file():
        parser.error(f"there is no program {arguments.scree}")
    try:
        texts = documents(arguments.scree)
    except ValueError as faults:
        print(faults, file=sys.stderr)
        return 1
    if arguments.check:
        wrong = out_of_date(texts)
        if wrong:
            print(*wrong, "run scripts/document_messages.py", sep="\n", file=sys.stderr)
        return 1 if wrong else 0
    PAGES.mkdir(exist_ok=True)
    for path in PAGES.glob("*.md"):
        if path not in texts:
            path.unlink()
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
