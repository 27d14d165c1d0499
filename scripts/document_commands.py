# SPDX-License-Identifier: BSD-3-Clause
"""Write the man pages of scree and scree-bench and their completion for bash and zsh from the output of --help.

    python3 scripts/document_commands.py build/bin/scree             write the files
    python3 scripts/document_commands.py build/bin/scree --check     exit code 1 if they are out of date

The files are doc/man/scree.1, scripts/completion/scree.bash and scripts/completion/_scree, and those of scree-bench
(scripts/document_bench.py), which `cmake --install` copies to the folders of man, bash and zsh, and
doc/reference/command_line.md, a page of the manual. Only the standard library is needed.
"""
import argparse
import re
import subprocess
import sys
from pathlib import Path

import document_bench

ROOT = Path(__file__).resolve().parents[1]
MAN = ROOT / "doc/man/scree.1"
BASH = ROOT / "scripts/completion/scree.bash"
ZSH = ROOT / "scripts/completion/_scree"
PAGE = ROOT / "doc/reference/command_line.md"
POST = ROOT / "python/src/scree_post/commands"
OPTION = re.compile(r"(?:-(\w), )?--([a-z][a-z-]*)((?: \[?[A-Z][\w.=:-]*\]?)*)")
#: What the program completes by itself, and words that it knows; all other values are files or free text.
WORDS = {"nodes": "", "ranks": "", "threads": "", "time": "", "case": ""}
FOLDERS = ("outdir",)

BASH_TEXT = """# Completion of scree for bash, written by scripts/document_commands.py; do not edit it.
_scree() {
   local program="${COMP_WORDS[0]}" word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" words
   local IFS=$' \\t\\n'
   COMPREPLY=()
   case "${before}" in
      --list) words="@LISTS@" ;;
      --new) words="$("${program}" --list examples 2> /dev/null | cut -d ' ' -f 1)" ;;
      --explain | -s | --set | --unset)
         words="$("${program}" --template 2> /dev/null \\
            | awk '/^&/ {g = substr($1, 2); if ("'"${before}"'" == "--explain") print g}
                   g != "" && /^[! ] *[a-z_0-9]+ *=/ {sub(/^! */, ""); print g "." $1} /^\\/$/ {g = ""}')"
         if [[ "${before}" == --explain ]]; then
            words+=" $("${program}" --list messages 2> /dev/null | cut -d ' ' -f 1)"
         fi ;;
@CASES@      *)
         if [[ "${word}" == -* ]]; then
            words="@OPTIONS@"
         else
            mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.nml' -- "${word}"
               case "${before}" in -r | --restart | --digest) compgen -f -X '!*.h5' -- "${word}" ;; esac)
            compopt -o filenames 2> /dev/null
            return
         fi ;;
   esac
   mapfile -t COMPREPLY < <(compgen -W "${words}" -- "${word}")
}
complete -F _scree scree
"""


def ask(program, *words):
    """Output of the program as lines."""
    answer = subprocess.run([program, *words], capture_output=True, text=True, check=True)
    return answer.stdout.rstrip("\n").split("\n")


def sections(program):
    """Lines of the help: of options, of exit codes, of examples."""
    lines = ask(program, "--help")
    codes = next(n for n, line in enumerate(lines) if line.startswith("exit codes"))
    examples = lines.index("examples:")
    return lines[1:codes], lines[codes:examples], [line for line in lines[examples + 1:] if line.startswith("  ")]


def entries(lines):
    """Pairs of an option as the user types it, and its meaning; a line with deep indentation continues the previous
    entry."""
    found = []
    for line in lines:
        if line.startswith(" " * 20):
            found[-1][1] += " " + line.strip()
        elif line.strip():
            typed, _, meaning = line.strip().partition("  ")
            found.append([typed, meaning.strip()])
    return found


def options(pairs):
    """All options: a dictionary from the long name to the letter, the value and the meaning."""
    found = {}
    for typed, meaning in pairs:
        for text in (typed, meaning):
            for letter, name, value in OPTION.findall(text):
                if name not in found:
                    found[name] = (letter, value.strip(), meaning)
    return found


def roff(text):
    """Text with the special characters of roff escaped."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return f"\\&{text}" if text.startswith(".") else text


def man_page(program):
    """The page of man."""
    lines, codes, examples = sections(program)
    version = ask(program, "--version")[0].split()[1]
    text = ['.\\" Written by scripts/document_commands.py from scree --help; do not edit it.',
            f'.TH SCREE 1 "" "scree {version}" "Scree"', ".SH NAME",
            "scree \\- dual domain material points for solids that break, fragment and flow",
            ".SH SYNOPSIS", ".B scree", "[\\fIoptions\\fR] \\fIDECK.nml\\fR", ".br", ".B mpirun \\-n",
            "\\fIN\\fR", ".B scree", "[\\fIoptions\\fR] \\fIDECK.nml\\fR", ".SH DESCRIPTION",
            "Reads a deck, a text file that describes bodies, materials and a grid, computes how the bodies move",
            "and break, and writes snapshots and tables into a folder. The result has the same bits for any number",
            "of ranks and threads, and after a restart. To print a deck with all keys use",
            ".BR \"scree \\-\\-template\" ,",
            "to copy an example use", ".BR \"scree \\-\\-new\" .", ".SH OPTIONS"]
    for typed, meaning in entries(lines):
        text += [".TP", f".B {roff(typed)}", roff(meaning)]
    text += [".SH EXIT STATUS", ".nf"]
    joined = " ".join(line.strip() for line in codes).partition(":")[2]
    text += [f"{roff(item.strip())}" for item in re.split(r", (?=\d)", joined) if item.strip()]
    text += [".fi", ".SH ENVIRONMENT", ".TP", ".B OMP_NUM_THREADS", "threads of each rank", ".SH EXAMPLES", ".nf"]
    text += [roff(line.strip()) for line in examples]
    text += [".fi", ".SH SEE ALSO", ".BR mpirun (1)", ".PP"]
    text += ["The pages of doc/guide and doc/reference explain decks, runs and outputs.", ""]
    return "\n".join(text)


def listed(program):
    """The names that `scree --list` prints."""
    return [line.split()[0] for line in ask(program, "--list") if line.startswith("   ")]


def known_words(known):
    """The values of options that are fixed words: constant ones, and the schedulers in the meaning of --job."""
    schedulers = re.search(r"job script for (.*?), with", known["job"][2])[1]
    return {**WORDS, "job": " ".join(re.split(r", | or ", schedulers))}


def bash_text(program):
    """Completion for bash."""
    known = options(entries(sections(program)[0]))
    fixed = known_words(known)
    words = [word for name, (letter, _, _) in known.items() for word in (f"--{name}", f"-{letter}" if letter else "")]
    cases = ""
    for name, (letter, _, _) in known.items():
        typed = f"--{name}" + (f" | -{letter}" if letter else "")
        if name in fixed:
            cases += f'      {typed}) words="{fixed[name]}" ;;\n'
        elif name in FOLDERS:
            cases += (f'      {typed})\n         mapfile -t COMPREPLY < <(compgen -d -- "${{word}}")\n'
                      "         compopt -o filenames 2> /dev/null\n         return ;;\n")
    return (BASH_TEXT.replace("@LISTS@", " ".join(listed(program))).replace("@CASES@", cases)
            .replace("@OPTIONS@", " ".join(word for word in words if word)))


def zsh_value(name, value, program, fixed):
    """The value part of an option in the syntax of the zsh function _arguments."""
    if not value:
        return ""
    if name == "list":
        return f"::list:({' '.join(listed(program))})"
    if name in fixed:
        return f":{name}:({fixed[name]})" if fixed[name] else f":{name}:"
    if name in FOLDERS:
        return ":folder:_files -/"
    if name in ("restart", "digest"):
        return ("::" if value.startswith("[") else ":") + "checkpoint:_files -g '*.h5'"
    return f":{name}:"


def zsh_text(program):
    """Completion for zsh."""
    known = options(entries(sections(program)[0]))
    fixed = known_words(known)
    rows = []
    for name, (letter, value, meaning) in known.items():
        meaning = re.sub(r"[\[\]:\"`$\\]", " ", meaning)
        forms = [f"--{name}"] + ([f"-{letter}"] if letter else [])
        rows += [f'  "{form}[{meaning}]{zsh_value(name, value, program, fixed)}"' for form in forms]
    return ("#compdef scree\n# Completion of scree for zsh, written by scripts/document_commands.py; do not edit it.\n"
            "_arguments -s \\\n" + " \\\n".join(rows) + " \\\n  \"*:deck:_files -g '*.nml'\"\n")


def table(heading, rows):
    """A table of Markdown; a bar in a cell is escaped."""
    text = "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |\n" for row in rows)
    return f"| {' | '.join(heading)} |\n|{'---|' * len(heading)}\n{text}"


def post_commands():
    """Names of the subcommands of scree-post."""
    text = (POST / "__init__.py").read_text(encoding="utf-8")
    return re.findall(r'"(\w+)"', text.partition("COMMANDS = (")[2])


def post_summary(name):
    """The summary of a subcommand of scree-post in its help."""
    return re.search(r'^SUMMARY = "(.*)"$', (POST / f"{name}.py").read_text(encoding="utf-8"), re.M)[1]


def page(program):
    """The page doc/reference/command_line.md."""
    lines, codes, examples = sections(program)
    joined = " ".join(line.strip() for line in codes).partition(":")[2]
    ends = [item.strip().partition(" ") for item in re.split(r", (?=\d)", joined) if item.strip()]
    posts = [(f"`{name}`", post_summary(name)) for name in post_commands()]
    return "\n".join((
        "# Command line", "",
        "This page is written by `scripts/document_commands.py` from the help of the commands; do not edit it.",
        "[Running](../guide/running.md) explains the use of the program.", "", "## scree", "", "```text",
        "scree [options] DECK.nml", "mpirun -n N scree [options] DECK.nml", "```", "",
        table(("option", "meaning"), [(f"`{typed}`", meaning) for typed, meaning in entries(lines)]),
        "### Exit codes", "", table(("code", "meaning"), [(code, meaning) for code, _, meaning in ends]),
        "### Examples", "", "```text", *(line.strip() for line in examples), "```", "", "## scree-post", "",
        "`scree-post COMMAND --help` lists options and examples of a command;",
        "[Post-processing](../guide/post_processing.md) explains the commands.", "",
        table(("command", "purpose"), posts),
        "## scree-bench", "", "`scree-bench` measures the speed of a machine ([Speed](../guide/speed.md)).", "",
        table(("option", "meaning"), document_bench.rows())))


def main():
    """Write the files, or compare them."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scree", type=Path, help="path of the program")
    parser.add_argument("--check", action="store_true", help="compare the files without writing")
    chosen = parser.parse_args()
    program = str(chosen.scree.resolve())
    stale = []
    texts = [(path, write(program)) for path, write in ((MAN, man_page), (BASH, bash_text), (ZSH, zsh_text),
                                                       (PAGE, page))]
    for path, text in texts + [(path, write()) for path, write in document_bench.files()]:
        if path.is_file() and path.read_text(encoding="utf-8") == text:
            continue
        stale.append(str(path.relative_to(ROOT)))
        if not chosen.check:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
    if chosen.check and stale:
        print(f"out of date: {', '.join(stale)}; call python3 scripts/document_commands.py {chosen.scree}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
