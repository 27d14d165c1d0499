# SPDX-License-Identifier: BSD-3-Clause
"""Choose places of the sources where one operator, sign, index, comparison or constant is changed."""

import random
import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, Iterator, List, Sequence, Tuple

#: Statements without an effect on results, or whose change would change a module file.
SKIPPED = re.compile(
    r"^(use|implicit|import|public|private|type|class|interface|procedure|generic|contains|end|else$|return|exit|cycle|"
    r"pure|elemental|impure|recursive|subroutine|function|module|program|block|associate|select|case|nullify|"
    r"allocate|deallocate|write|print|open|close|inquire|rewind|flush|read ?\(|character|integer|real|logical|"
    r"complex|format|continue|critical)\b", re.I)
# Statements that are not changed: declarations, descriptions of keys, measured times, and texts of messages.
SILENT = re.compile(
    r"::|schema%|timer|cost\b|record_cost|progress|capacity|reserve|%add_error|%line\(|log%|message|unit_of|"
    r"wall_time|width|write_|hint|text_of", re.I)
# The statements from here on only compose the text of a message.
MESSAGE = re.compile(r"\bcall (fail\w*|\w*%?error|\w*%add_error|command_line_error|agree|\w*report\w*)\b", re.I)
#: Files that only write texts or measure times.
SILENT_FILES = re.compile(
    r"_(help|information|progress|lists|cost_report|examples|messages?|log|timer|tile_cost|run_time_estimate|"
    r"job_time|batch_job|advice|preview|expected_steps|trial_steps|unit_warnings|description|echo|log_files|"
    r"loop_clock|version|diagnostics|main)\.f90$|/main\.f90$|/serial/")

COMPARISONS = {"<": ("<=", ">"), "<=": ("<", ">"), ">": (">=", "<"), ">=": (">", "<"), "==": ("/=",), "/=": ("==",)}
BEFORE, AFTER = r"(?<=[\w)\]])", r"(?=[\w(.])"


@dataclass(frozen=True)
class Mutant:
    """One change of one line."""
    file: str                   # relative to the root of the project
    line: int                   # line number, from 1
    before: str                 # the original line without its end
    after: str                  # the changed line
    kind: str = "by hand"
    hints: Tuple[str, ...] = ()  # tests that run first after the unit tests

    @property
    def layer(self) -> str:
        """Folder of src/."""
        return self.file.split("/")[1]

    @property
    def place(self) -> str:
        """File and line."""
        return f"{self.file}:{self.line}"

    @property
    def module(self) -> str:
        """Name of the module, which is that of the file."""
        return Path(self.file).stem


def masked(line: str, quote: str = "") -> Tuple[str, str]:
    """The line with blanks in place of strings and comments, of the same length, and the quotation mark that is still
    open at its end."""
    result = []
    for position, letter in enumerate(line):
        if quote:
            result.append(" ")
            if letter == quote:
                quote = ""
        elif letter in "\"'":
            result.append(" ")
            quote = letter
        elif letter == "!":
            result.append(" " * (len(line) - position))
            break
        else:
            result.append(letter)
    text = "".join(result)
    return text, quote if line.rstrip().endswith("&") else ""


def body_lines(path: Path) -> Iterator[Tuple[int, str, str]]:
    """(number, line, masked line) of those statements in procedures whose change can change a result."""
    inside, quote = False, ""
    statement: List[Tuple[int, str, str]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8").split("\n"), 1):
        text, quote = masked(line, quote)
        if line.rstrip() == "contains":
            inside = True
            continue
        if not inside or not text.strip():
            continue
        statement.append((number, line, text))
        if text.rstrip().endswith("&"):
            continue
        joined = " ".join(part.strip(" &") for _, _, part in statement)
        if not SKIPPED.match(joined) and not SILENT.search(joined):
            talk = False
            for one, code, part in statement:
                match = MESSAGE.search(part)
                if not talk:
                    yield one, code, part[:match.start()] if match else part
                talk = talk or bool(match)
        statement = []


def real_change(text: str) -> str:
    """A real constant that differs from the given one."""
    value = float(text[:-3])
    if value == 0.0:
        return "1.0_wp"
    return f"{2.0 * value}_wp"


def changes(code: str) -> Iterator[Tuple[int, int, str, str]]:
    """(begin, end, new text, kind) of all changes of a masked line."""
    for match in re.finditer(BEFORE + r" ([+-]) " + AFTER, code):
        yield match.start(1), match.end(1), "-" if match[1] == "+" else "+", "operator"
    for match in re.finditer(BEFORE + r" ?(?<![*/])([*/])(?![*/=)]) ?" + AFTER, code):
        yield match.start(1), match.end(1), "/" if match[1] == "*" else "*", "operator"
    for match in re.finditer(r"(?<= )(<=|>=|==|/=|<|>)(?= )", code):
        for new in COMPARISONS[match[1]]:
            yield match.start(1), match.end(1), new, "comparison"
    for match in re.finditer(r"\.(and|or)\.", code):
        yield match.start(), match.end(), ".or." if match[1] == "and" else ".and.", "operator"
    for match in re.finditer(r"\.not\. ?", code):
        yield match.start(), match.end(), "", "sign"
    for match in re.finditer(r"\.(true|false)\.", code):
        yield match.start(), match.end(), ".false." if match[1] == "true" else ".true.", "constant"
    for match in re.finditer(r"(?:(?<=[=(,]) ?|(?<=[=(,] ))-(?=[\w(])", code):
        yield match.end() - 1, match.end(), "", "sign"
    for match in re.finditer(r"(?<![\w.%])\d+\.\d+(e[+-]?\d+)?_wp", code):
        if not match[1] or abs(int(match[1][1:])) < 5:
            yield match.start(), match.end(), real_change(match.group()), "constant"
    for match in re.finditer(r"(?<![\w.%])(\d+)(?![\w.])", code):
        yield match.start(), match.end(), str(int(match[1]) + 1), "index"
    for match in re.finditer(r"\b(min|max)(?=\()", code):
        yield match.start(), match.end(), "max" if match[1] == "min" else "min", "operator"


def candidates(root: Path, file: Path) -> List[List[Mutant]]:
    """All changes of a file, grouped by line."""
    found = []
    for number, line, text in body_lines(file):
        here = [Mutant(str(file.relative_to(root)), number, line, line[:begin] + new + line[end:], kind)
                for begin, end, new, kind in changes(text)]
        if here:
            found.append(here)
    return found


def choose(root: Path, count: int, least: int, seed: int) -> List[Mutant]:
    """At least `count` mutants. Each folder of src/ gets a number in proportion to its lines that can be changed, and
    at least `least`. The same sources and the same seed give the same list."""
    lines: Dict[str, List[List[Mutant]]] = defaultdict(list)
    loops = random.Random(f"{seed}:loops")
    for file in sorted((root / "src").rglob("*.f90")):
        name = file.relative_to(root).as_posix()
        if not SILENT_FILES.search(name):
            # Of the changes of loop heads only a third is used: all change the lower bound, and they would be a fifth
            # of all changes.
            lines[name.split("/")[1]] += [here for here in candidates(root, file)
                                          if not here[0].before.lstrip().startswith("do ") or loops.random() < 0.33]
    total = sum(len(found) for found in lines.values())
    chosen = []
    for layer, found in sorted(lines.items()):
        draw = random.Random(f"{seed}:{layer}")
        number = min(len(found), max(least, -(-count * len(found) // total)))
        chosen += [draw.choice(here) for here in draw.sample(found, number)]
    # The order is independent of the folders, so that an interrupted run has tried mutants of all folders.
    random.Random(seed).shuffle(chosen)
    return chosen


def read_list(root: Path, file: Path) -> List[Mutant]:
    """Mutants of a file: blocks of lines `file: ...`, `- line before`, `+ line after` and, if wanted, `in: procedure`,
    for a line that others have too, and `tests: ...`."""
    found = []
    fields: Dict[str, str] = {}
    for number, line in enumerate([*file.read_text(encoding="utf-8").split("\n"), ""], 1):
        key, _, rest = line.partition(" ")
        if key in ("file:", "in:", "-", "+", "tests:"):
            fields[key] = rest.strip()
        elif key and not key.startswith("#"):
            raise ValueError(f"{file}:{number}: '{key}' is none of: file:, in:, -, +, tests:, #")
        elif not line.strip() and fields:
            found.append(located(root, f"{file}:{number - 1}", fields))
            fields = {}
    return found


def procedure(lines: Sequence[str], name: str) -> Tuple[int, int]:
    """First and last line of a procedure; no lines if there is none."""
    here = [number for number, line in enumerate(lines, 1) if re.search(rf"\b(subroutine|function) {name}\b", line)]
    return (here[0], here[-1]) if here else (1, 0)


def located(root: Path, where: str, fields: Dict[str, str]) -> Mutant:
    """The mutant of one block; the line before the change must occur exactly once in the file, or in the procedure."""
    missing = [key for key in ("file:", "-", "+") if key not in fields]
    if missing:
        raise ValueError(f"{where}: the block has no line '{missing[0]}'")
    lines = (root / fields["file:"]).read_text(encoding="utf-8").split("\n")
    first, last = procedure(lines, fields["in:"]) if "in:" in fields else (1, len(lines))
    at = [number for number in range(first, last + 1) if lines[number - 1].strip() == fields["-"]]
    if len(at) != 1:
        place = f"{fields['in:']} of {fields['file:']}" if "in:" in fields else fields["file:"]
        raise ValueError(f"{where}: '{fields['-']}' is {len(at)} times in {place}, not once")
    before = lines[at[0] - 1]
    indent = before[:len(before) - len(before.lstrip())]
    return Mutant(fields["file:"], at[0], before, indent + fields["+"], hints=tuple(fields.get("tests:", "").split()))
