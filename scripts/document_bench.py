# SPDX-License-Identifier: BSD-3-Clause
"""Generate the man page of scree-bench and its completion for bash and zsh from the options of scripts/scree_bench.

scripts/document_commands.py writes these files together with those of scree.
"""
import argparse
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "scripts"), str(ROOT / "python/src")]
from scree_bench import __version__, cases, command  # noqa: E402

MAN = ROOT / "doc/man/scree-bench.1"
BASH = ROOT / "scripts/completion/scree-bench.bash"
ZSH = ROOT / "scripts/completion/_scree-bench"
NOTICE = "written by scripts/document_commands.py; do not edit it."
# Options whose values are names of files, and the pattern of these names.
FILES = {"show": "*.json", "compare": "*.json", "out": "*.json", "markdown": "*.md", "scree": "*", "turns": "*"}
FOLDERS = ("work",)
BASH_TEXT = """# Completion of scree-bench for bash, @NOTICE@
_scree_bench() {
   local word="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" words=""
   local IFS=$' \\t\\n'
   COMPREPLY=()
   if [[ "${word}" == -* ]]; then
      words="@OPTIONS@"
   else
      case "${before}" in
         --size) words="@SIZES@" ;;
         --only) words="@CASES@" ;;
         --work) mapfile -t COMPREPLY < <(compgen -d -- "${word}") ;;
         --scree | --turns) mapfile -t COMPREPLY < <(compgen -f -- "${word}") ;;
         --markdown) mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.md' -- "${word}") ;;
         --repeat | --layouts | --mpiexec | --limit) ;;
         *) mapfile -t COMPREPLY < <(compgen -d -- "${word}"; compgen -f -X '!*.json' -- "${word}") ;;
      esac
   fi
   if [[ -z "${words}" ]]; then
      compopt -o filenames 2> /dev/null
      return
   fi
   mapfile -t COMPREPLY < <(compgen -W "${words}" -- "${word}")
}
complete -F _scree_bench scree-bench
"""


def actions():
    """The options of the argument parser."""
    return [action for action in command.parser()._actions if action.option_strings]


def roff(text):
    """Text with the special characters of roff escaped."""
    return re.sub(r"^([.'])", r"\\&\1", text.replace("\\", "\\e").replace("-", "\\-"))


def value_of(action):
    """The value of an option as the user types it."""
    if action.nargs == 0 or isinstance(action, argparse._StoreTrueAction):
        return ""
    if action.choices:
        return "|".join(action.choices)
    return " ".join(action.metavar) if isinstance(action.metavar, tuple) else action.metavar


def rows():
    """Pairs of an option as the user types it, and its meaning."""
    return [("`" + f"{', '.join(action.option_strings)} {value_of(action)}".strip() + "`", action.help)
            for action in actions()]


def man_page():
    """The page of man."""
    lines = [f'.\\" {NOTICE.capitalize()}', f'.TH SCREE-BENCH 1 "" "scree {__version__}" "Scree"', ".SH NAME",
             "scree\\-bench \\- how fast scree is on this machine", ".SH SYNOPSIS",
             ".B scree\\-bench", "[\\fIoptions\\fR]", ".SH DESCRIPTION",
             *map(roff, command.parser().description.split("\n")), ".SH OPTIONS"]
    for action in actions():
        typed = f"{', '.join(action.option_strings)} {value_of(action)}".strip()
        lines += [".TP", f".B {roff(typed)}", roff(action.help)]
    codes = re.split(r", (?=\d)", command.CODES.partition(": ")[2])
    lines += [".SH EXIT STATUS", ".nf", *map(roff, codes), ".fi", ".SH ENVIRONMENT", ".TP", ".B SCREE",
              "the program, without \\-\\-scree", ".SH EXAMPLES", ".nf",
              *(roff(line.strip()) for line in command.EXAMPLES.strip().split("\n")[1:]), ".fi", ".SH SEE ALSO",
              ".BR scree (1)", ""]
    return "\n".join(lines)


def bash_text():
    """Completion for bash."""
    words = " ".join(word for action in actions() for word in action.option_strings)
    names = " ".join(run.key for run in cases.plan())
    return (BASH_TEXT.replace("@NOTICE@", NOTICE).replace("@OPTIONS@", words).replace("@SIZES@", " ".join(cases.SIZES))
            .replace("@CASES@", names))


def zsh_value(name, action):
    """The value part of an option in the syntax of the zsh function _arguments."""
    if not value_of(action):
        return ""
    if action.choices:
        return f":{name}:({' '.join(action.choices)})"
    if name == "only":
        return f":case:({' '.join(run.key for run in cases.plan())})"
    if name in FOLDERS:
        return ":folder:_files -/"
    if name in FILES:
        return f":file:_files -g '{FILES[name]}'" * (2 if name == "compare" else 1)
    return f":{name}:"


def zsh_text():
    """Completion for zsh."""
    rows = []
    for action in actions():
        name = action.option_strings[-1].lstrip("-")
        meaning = re.sub(r"[\[\]:\"`$\\]", " ", action.help)
        rows += [f'  "{form}[{meaning}]{zsh_value(name, action)}"' for form in action.option_strings]
    head = f"#compdef scree-bench\n# Completion of scree-bench for zsh, {NOTICE}\n_arguments -s \\\n"
    return head + " \\\n".join(rows) + "\n"


def files():
    """Pairs of a file and the function that makes its text."""
    return (MAN, man_page), (BASH, bash_text), (ZSH, zsh_text)
