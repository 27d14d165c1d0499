# SPDX-License-Identifier: BSD-3-Clause
"""Write doc/reference/messages.md and the examples of `scree --explain CODE` from src/run/messages.

    python3 scripts/document_messages.py --scree build/bin/scree             write both
    python3 scripts/document_messages.py --scree build/bin/scree --check     exit code 1 if out of date

The files src/run/messages/*.txt contain the code, text, cause and remedy of each message. The build includes them
in the program. In the sources the text of a message ends with its code. This script generates an example of each
message: it runs the program on a wrong deck and checks that the message is printed with its code. The deck is that of
a row of the tables of test/input (broken_*.py) with this message, unless scripts/messages contains another one
(examples.py: decks; situations.py: commands, files and runs). Examples are written to the page and to
src/run/messages/examples.txt, which the build also includes in the program.

For a new message add its code at its call and a record with the next free code of its section, build, run this script,
check the page, and build again. A code is never used for another message. Only the standard library is needed.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
import textwrap
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
GUIDE = ROOT / "doc" / "reference"
PAGE = GUIDE / "messages.md"
SOURCES = ROOT / "src" / "run" / "messages"
EXAMPLES = SOURCES / "examples.txt"
SECTIONS = ["format", "values", "keys", "scene", "units", "command_line", "jobs", "runs", "files"]
sys.path[:0] = [str(ROOT / "scripts" / "messages"), str(ROOT / "test" / "input")]
import broken_instruments as instruments  # noqa: E402
import broken_scenes as scenes   # noqa: E402
import broken_values as values   # noqa: E402
import examples                  # noqa: E402
import situations                # noqa: E402

FAULTS = [values.KINDS, values.NUMBERS, values.UNKNOWN, values.MARKS, scenes.CONTRADICTIONS, scenes.CELLS,
          scenes.NAMES, scenes.ORPHANS, scenes.BODIES, scenes.ANGLES, scenes.SIZES, scenes.INCLUDES,
          scenes.RARE, scenes.WARNINGS, instruments.INSTRUMENTS]
DECK = "scene.nml"
CHECK = f"scree --check {DECK}"
RECORD = re.compile(r"^\[([A-Z]\d{3})\]\n", re.M)
FIELDS = ("says", "when", "cause", "remedy", "note")
# Lines that the run time library of a Debug build prints in addition.
DEBUG = re.compile(r"At line \d+ of file |Fortran runtime warning: An array temporary")
WIDEST = 110                     # columns of a line that is not shortened
FEW = 4                          # lines of a deck that are shown in sequence
LABEL = 8                        # width of the labels of an example in columns
# Pages for further reading by group, in addition to the keys of the group, and by section for messages without a group.
ABOUT = {
    "run": "../guide/deck.md#dimension", "units": "../guide/deck.md#units", "include": "../guide/deck.md#rules",
    "grid": "../guide/deck.md#dimension", "region": "../guide/shapes.md", "body": "../guide/deck.md#shapes-and-bodies",
    "material": "materials.md", "boundary": "../guide/deck.md#boundary-conditions", "effects": "effects.md",
    "contact": "../guide/deck.md#contact", "output": "../guide/deck.md#output",
    "time": "../guide/running.md#how-a-run-ends", "checkpoint": "../guide/running.md#checkpoints-and-restart",
    "section format": "../guide/deck.md#rules", "section units": "../guide/deck.md#units",
    "section command_line": "../guide/running.md", "section runs": "../guide/running.md#how-a-run-ends",
    "section files": "../guide/running.md#checkpoints-and-restart"}
# Keys that are also common words: they count only before an equals sign.
PROSE = {"at", "axis", "bodies", "body", "fields", "file", "law", "material", "name", "of", "region", "shape",
         "solution", "type", "scale", "velocity", "stress", "spin"}
HEAD = """# Messages

Every error and warning of the program ends with a code such as `[D209]`. `scree --explain D209`, or `scree --explain`
with the printed line, prints cause, remedy and example as on this page; `scree --list messages` lists all codes.

A message on a deck has the form `FILE:LINE: error: &GROUP 'NAME': ... [CODE]`, with `command line` in place of file
and line for values of `--set`. All errors of a deck are reported together, in the order of the lines; nothing is
computed and no file is changed. Checks that depend on faulty input are skipped, so one mistake does not cause
follow-up errors. The program ends with exit code 2 after an error in the deck or on the command line, 3 after an error
with a file, 4 if a run had to stop, 5 after a bug in the program, 75 if `--restart` continues the run. Warnings do not
stop a run.

Below, `...` stands for names and numbers. Examples show a wrong deck, file or command, the message, and the correction.
[scripts/document_messages.py](../../scripts/document_messages.py) writes this page from
[src/run/messages](../../src/run/messages) and runs the examples.
"""


class Message:
    """A message of a section: code, text, cause and remedy."""

    def __init__(self, section, code, text):
        self.section, self.code = section, code
        fields = {name: [] for name in FIELDS}
        for field in re.split(r"\n(?=\S)", text.strip()):
            name, colon, value = field.partition(": ")
            if name not in fields or not colon:
                raise ValueError(f"{code}: no field of a message: {field!r}")
            fields[name].append(" ".join(value.split()))
        for name in ("cause", "remedy"):
            if len(fields[name]) != 1:
                raise ValueError(f"{code} needs one {name}")
        if not fields["says"]:
            raise ValueError(f"{code} says nothing")
        self.says, self.notes = fields["says"], fields["note"]
        self.cause, self.remedy = fields["cause"][0], fields["remedy"][0]
        self.when = fields["when"][0] if fields["when"] else ""

    def pattern(self):
        """Regular expression for one of the texts of a message; three points match any text."""
        return re.compile("|".join(".*?".join(map(re.escape, text.split("..."))) for text in self.says))

    def told(self, lines):
        """The first line that contains the message, which must end with the code; None if there is none."""
        line = next((line for line in lines if self.pattern().search(line)
                     and line.endswith(f"[{self.code}]")), None)
        other = next((line for line in lines if self.pattern().search(line)), None)
        if line is None and other is not None:
            raise ValueError(f"{self.code}: the program prints another code: {other}")
        return line


def patterns(known):
    """For each text of some messages: the code, the number of letters, and the regular expression."""
    return [(message.code, len(text.replace("...", "")), re.compile(".*?".join(map(re.escape, text.split("...")))))
            for message in known for text in message.says]


def scores(text, fitting):
    """Pairs (number of matching letters, code) of all texts that match a line; the longest match comes first."""
    return sorted({(letters, code) for code, letters, pattern in fitting if pattern.search(text)}, reverse=True)


def records(text):
    """Pairs of a code and the text of its record."""
    parts = RECORD.split(text)
    return list(zip(parts[1::2], parts[2::2]))


def sections():
    """Headings and messages of each section."""
    found = {}
    for name in SECTIONS:
        text = (SOURCES / f"{name}.txt").read_text(encoding="utf-8")
        found[name] = (text.split("\n", 2)[1][2:], [Message(name, *record) for record in records(text)])
    codes = [message.code for _, messages in found.values() for message in messages]
    if len(codes) != len(set(codes)):
        raise ValueError(f"codes of two messages: {sorted(code for code in codes if codes.count(code) > 1)}")
    return found


class Runner:
    """Runs commands with a shell in a folder of their own, with `scree` as the program."""

    def __init__(self, program, folder):
        self.folder, self.right = Path(folder), {}
        commands = self.folder / "bin"
        commands.mkdir()
        (commands / "scree").symlink_to(Path(program).resolve())
        self.environment = {name: value for name, value in os.environ.items()
                            if not name.startswith(("SLURM_", "PBS_"))}
        # one thread, messages in English, and unbuffered output
        self.environment.update(
            PATH=f"{commands}:{os.environ['PATH']}", LC_ALL="C", OMP_NUM_THREADS="1",
            OMP_WAIT_POLICY="passive", OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
            OMPI_MCA_btl_vader_single_copy_mechanism="none", GFORTRAN_UNBUFFERED_ALL="1")
        self.count = count()
        self.version = "scree X.Y.Z"
        head = self.run(folder, "scree --version")[1][0]
        self.version, self.traps = " ".join(head.split()[:2]), " Debug " in head

    def place(self, files):
        """A new folder that contains some files."""
        place = self.folder.resolve() / str(next(self.count))
        place.mkdir()
        for name, content in files.items():
            (place / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return place

    def run(self, place, command):
        """Exit code and printed lines of a command. For a check, only the lines up to the result of the deck are
        returned."""
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
                    process.kill()   # the following sizes and estimates differ between machines
                    lines.append("...")
                    break
        code = 0 if lines and lines[-1] == "..." else process.returncode
        return code, [line.replace(str(place), "/opt/programs").replace(self.version, "scree X.Y.Z")
                      for line in lines]

    def succeed(self, message, place, command):
        """Run a command that must not fail."""
        code, said = self.run(place, command)
        if code not in (0, 75) or any(" 1 warnings" in line for line in said):
            raise ValueError(f"{message.code}: {command} has exit code {code}:\n" + "\n".join(said))

    def faults(self, files):
        """Errors and warnings of a deck that should have none; empty if it has none."""
        key = repr(sorted(files.items()))
        if key not in self.right:
            said = self.run(self.place(files), CHECK)[1]
            self.right[key] = "" if any(" 0 errors, 0 warnings" in line for line in said) else "\n".join(said)
        return self.right[key]


def visible(line):
    """A line of the program in which characters that cannot be displayed are replaced by their codes."""
    return "".join(letter if letter >= " " else f"<{ord(letter)}>" for letter in line)


def shorter(line):
    """A line of a deck, shortened if it is too long."""
    line = visible(line)
    return line if len(line) <= WIDEST else line[:WIDEST // 2] + " ... " + line[-WIDEST // 3:]


def changed(old, new):
    """Ranges of the lines that differ in two texts, as first line and line after the last one, for each text."""
    first = 0
    while first < min(len(old), len(new)) and old[first] == new[first]:
        first += 1
    last = 0
    while last < min(len(old), len(new)) - first and old[-1 - last] == new[-1 - last]:
        last += 1
    return first, len(old) - last, len(new) - last


def excerpt(lines, first, last):
    """The lines of a deck that differ, with one more line as context if no line remains."""
    chosen = set(range(first, last))
    if not any(lines[place] for place in chosen):
        chosen = {max(first - 1, 0), min(last, len(lines) - 1)}
    if max(chosen) - min(chosen) < FEW:
        chosen = set(range(min(chosen), max(chosen) + 1))
    shown, before = [], min(chosen) - 1
    for place in sorted(chosen):
        if place > before + 1:
            shown.append("...")
        shown.append(shorter(lines[place]))
        before = place
    return shown


def labelled(label, lines):
    """Lines with a label before the first one; long lines are broken."""
    broken = [part for line in lines for part in textwrap.wrap(
        line, WIDEST, subsequent_indent="  ", drop_whitespace=True, replace_whitespace=False,
        break_long_words=False, break_on_hyphens=False) or [""]]
    return [((f"{label}:" if n == 0 else "").ljust(LABEL) + line).rstrip() for n, line in enumerate(broken)]


def first_fault(message, fitting):
    """The first wrong deck of the tables that produces the message with this code; None if there is none."""
    for table in FAULTS:
        for deck, old, new, _, said in table:
            if message.pattern().search(said) and scores(said, fitting)[0][1] == message.code:
                return deck, old, new, None
    return None


def deck_example(message, runner, fitting):
    """The line with the message, and lines that show a deck that produces it; None if there is none."""
    given = examples.DECKS.get(message.code)
    if given is None:
        given = first_fault(message, fitting)
    if given is None:
        return None
    deck, old, new, better = given
    text = values.DECKS.get(deck, deck)
    if old not in text:
        raise ValueError(f"{message.code}: the deck does not hold {old!r}")
    wrong = text.replace(old, new, 1)
    right = text.replace(old, old if better is None else better, 1)
    files = examples.FILES.get(message.code, {})
    faults = runner.faults({**files, DECK: right})
    if faults:
        raise ValueError(f"{message.code}: the deck that should be right is not:\n{right}{faults}")
    said = runner.run(runner.place({**files, DECK: wrong}), CHECK)[1]
    told = message.told(said)
    if told is None:
        raise ValueError(f"{message.code}: the example does not bring the message, but\n" + "\n".join(said))
    wrong_lines, right_lines = (re.split("\r?\n", part.rstrip("\n")) for part in (wrong, right))
    first, wrong_last, right_last = changed(wrong_lines, right_lines)
    return told, [*labelled("wrong", excerpt(wrong_lines, first, wrong_last)), *labelled("prints", [visible(told)]),
                  *labelled("right", excerpt(right_lines, max(0, first - (wrong_last == first)), right_last))]


def situation_example(message, runner):
    """The line with the message, and lines with commands and their output; None if there are none."""
    situation = situations.SITUATIONS.get(message.code)
    if situation is None:
        return None
    place = runner.place(situation.get("files", {}))
    for command in situation.get("before", []):
        runner.succeed(message, place, command)
    lines, everything = [], []
    for command in situation["commands"]:
        shown, command = (command, command) if isinstance(command, str) else command
        everything += runner.run(place, command)[1]
        lines.append(shown)
    told = message.told(everything)
    if told is None:
        raise ValueError(f"{message.code}: the example does not bring the message, but\n" + "\n".join(everything))
    parts = []
    if "text" in situation:
        text = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", situation["text"]).replace("`", "").rstrip(":.")
        parts += labelled("case", textwrap.wrap(text, WIDEST - LABEL))
    if "shows" in situation:
        parts += labelled("wrong", situation["shows"].strip("\n").split("\n"))
    parts += [*labelled("run", lines), *labelled("prints", [visible(told)])]
    better = []
    for command in situation.get("then", []):
        shown, command = (command, command) if isinstance(command, str) else command
        steps = re.search(r"time\.max_steps=(\d+)", " ".join(everything))
        if steps:
            shown, command = (text.format(max_steps=steps.group(1)) for text in (shown, command))
        runner.succeed(message, place, command)
        better.append(shown)
    better += situation["right"].strip("\n").split("\n") if "right" in situation else []
    if better:
        parts += labelled("right", better)
    if "right_files" in situation:
        place = runner.place({**situation["files"], **situation["right_files"]})
        for command in [*situation.get("before", []), situation["commands"][-1]]:
            runner.succeed(message, place, command)
    return told, parts


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
    """The title of a document, or of a section of it, as text of a link."""
    name, _, anchor = target.partition("#")
    headings = re.findall(r"^#+ (.*)", (GUIDE / name).read_text(encoding="utf-8"), re.M)
    if not anchor:
        return headings[0]
    slugs = {re.sub(r"[^a-z0-9 -]", "", heading.lower()).replace(" ", "-"): heading for heading in headings}
    if anchor not in slugs:
        raise ValueError(f"{target} is no heading")
    return f"{headings[0]}, {slugs[anchor]}"


def related_keys(message, told, known):
    """The group that a message concerns, or None, and up to three of its keys."""
    found = re.search(r"&(\w+)", told)
    group = found.group(1) if found and found.group(1) in known else None
    text = re.sub("'[^']*'", "", told.split(f"&{group}", 1)[1]) if group else " ".join(message.says)
    words = dict.fromkeys(re.findall(r"\b[a-z]\w*\b", text))
    if not group:    # a message without a group may name a key that occurs in only one group
        owners = [name for name in known for key in known[name] if key in words and "_" in key]
        group = owners[0] if len(set(owners)) == 1 else None
    named = [key for key in words if key in known.get(group, [])
             and (key not in PROSE or re.search(rf"\b{key} =", text))][:3]
    return group, named


def see_also(message, group, named):
    """Links to keys and pages that explain the subject of a message; empty if there are none."""
    links = []
    if group:
        links.append((" and ".join(f"`{key}`" for key in named) + " of " if named else "")
                     + f"[&{group}](keys.md#{group})")
    given = re.findall(r"\]\(([^)\s]+)\)", " ".join([message.cause, message.remedy, *message.notes]))
    targets = list(situations.SITUATIONS.get(message.code, {}).get("see", []))
    section = f"section {message.section}"
    about = section if message.section in ("format", "units") or not group else group
    if about in ABOUT and not targets and not given:
        targets = [ABOUT[about]]
    links += [f"[{title_of(target)}]({target})" for target in dict.fromkeys(targets)
              if target != "keys.md" and target not in given]
    return f" See {', '.join(links)}." if links else ""


def record(message, runner, known, fitting):
    """The text for a message on the page, and its example for the program."""
    example = situation_example(message, runner) or deck_example(message, runner, fitting)
    told, lines = example or ("", [])
    group, named = related_keys(message, told, known)
    when = f" ({message.when})" if message.when else ""
    text = (", ".join(f"`{one}`" for one in message.says) + when + f"  \n**Cause:** {message.cause}"
            f"  \n**Remedy:** {message.remedy}")
    text += "".join(f" {note}" for note in message.notes) + see_also(message, group, named)
    block = "\n".join(["", "```text", *lines, "```", ""]) if lines else ""
    wanted = [f"{group}.{key}" for key in named] or ([group] if group else [])
    more = [f"keys:   scree --explain {name}" for name in wanted[:1]]
    more += [f"        scree --explain {name}" for name in wanted[1:]]
    return f"\n### {message.code}\n\n{text}\n{block}", "\n".join([f"[{message.code}]", *lines, *more, ""])


def old_record(message):
    """Both texts as the files contain them, for messages that a Debug build cannot produce."""
    page = re.search(rf"\n### {message.code}\n.*?(?=\n##|\Z)", PAGE.read_text(encoding="utf-8"), re.S)
    old = dict(records(EXAMPLES.read_text(encoding="utf-8")))[message.code]
    return page.group(), f"[{message.code}]\n{old.rstrip()}\n"


def documents(program):
    """The page and the file of examples as a dictionary from path to text."""
    found, known, faults = sections(), keys(), []
    messages = [message for _, part in found.values() for message in part]
    fitting = patterns(messages)
    strange = (set(situations.SITUATIONS).union(examples.DECKS, examples.FILES)
               - {message.code for message in messages})
    if strange:
        raise ValueError(f"examples of no message: {sorted(strange)}")
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        runner = Runner(program, folder)

        def write(message):
            if runner.traps and situations.SITUATIONS.get(message.code, {}).get("traps"):
                return message.code, old_record(message)
            try:
                return message.code, record(message, runner, known, fitting)
            except ValueError as fault:
                faults.append(str(fault))
                return message.code, ("", "")

        # most of the time is waiting in the start of MPI
        with ThreadPoolExecutor(4) as pool:
            made = dict(pool.map(write, messages))
    if faults:
        raise ValueError("\n\n".join(faults))
    page = HEAD
    for heading, part in found.values():
        page += f"\n## {heading}\n" + "".join(made[message.code][0] for message in part)
    shown = ("# SPDX-License-Identifier: BSD-3-Clause\n"
             "# Examples of messages, written by scripts/document_messages.py; do not edit them.\n\n"
             + "\n".join(made[message.code][1] for message in messages))
    return {PAGE: page, EXAMPLES: shown}


def out_of_date(texts):
    """Files whose content is out of date, each with the reason."""
    return [f"{path.name} differs" if path.is_file() else f"{path.name} is missing" for path, text in texts.items()
            if not path.is_file() or path.read_text(encoding="utf-8") != text]


def main():
    """Write the files, or compare them."""
    parser = argparse.ArgumentParser(prog="document_messages.py", description=__doc__.split("\n\n")[0])
    parser.add_argument("--scree", metavar="PROGRAM", default=ROOT / "build/bin/scree",
                        help="path of the program")
    parser.add_argument("--check", action="store_true", help="compare the files without writing")
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
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
