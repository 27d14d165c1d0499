# SPDX-License-Identifier: BSD-3-Clause
"""Pages of the Fortran modules, a page for each folder of src/, from the comments in the sources.

Shown are public names alone: constants, types with their components, procedures with their arguments, also those bound
to public types, and interfaces.
"""
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PROCEDURE = re.compile(r"^ {3}(?! )[^!\"']*\b(?:subroutine|function)\s+(\w+)", re.I)
TYPE = re.compile(r"^ {3}type\b(?!\s*\()[^:!]*(?:::)?\s*(\w+)\s*(?:!.*)?$", re.I)
TYPE_BODY = re.compile(r"^ {3}type\b(?!\s*\()[^:!\n]*(?:::)?\s*\b(\w+)\s*(?:!.*)?\n(.*?)^ {3}end type", re.M | re.S)
INTERFACE = re.compile(r"^ {3}(abstract )?interface\b\s*(\w*)", re.I)
CONSTANT = re.compile(r"^ {3}\w[^!]*\bparameter\b[^!]*\bpublic\b", re.I)
PAGE = re.compile(r"\bdoc/([\w/]+\.md)")


def folders():
    """Names of the folders of src/."""
    return sorted(path.name for path in (ROOT / "src").iterdir() if path.is_dir())


def modules_of(name):
    """Sources of the modules of a folder and of its subfolders, without the variants of serial builds."""
    return sorted((path for path in (ROOT / "src" / name).rglob("*.f90") if path.parent.name != "serial"),
                  key=lambda path: path.name)


def summary(name):
    """Number of modules of a folder."""
    return len(modules_of(name))


def prose(lines):
    """Text of a comment as Markdown; names of pages become links."""
    text = "\n".join(re.sub(r"^\s*!(>|!) ?", "", line).strip() for line in lines)
    text = re.sub(r"([*$|<])", r"\\\1", text)
    return PAGE.sub(lambda found: f"[{found[0]}](../../{found[1]})" if (ROOT / found[0]).is_file() else found[0], text)


def code(lines):
    """A block of source text without the indentation of a module."""
    return "```fortran\n" + "\n".join(re.sub(r"^ {3}", "", line) for line in lines) + "\n```\n"


def public_names(text):
    """Names in the public statements of a module, and of procedures that its public types bind."""
    joined = re.sub(r"&\s*\n\s*&?", "", text)
    names = {name.lower() for line in re.findall(r"^ {3}public\s*::(.*)$", joined, re.M)
             for name in re.findall(r"\w+", line.split("!")[0])}
    for kind, body in TYPE_BODY.findall(text):
        if kind.lower() in names:
            names |= {name.lower() for name in re.findall(r"^\s*procedure\b[^!\n]*=>\s*(\w+)", body, re.M)}
    return names


def header(lines, at):
    """The first statement of a procedure with its continuation lines, and the declarations of its arguments."""
    shown = [lines[at]]
    while lines[at].split("!")[0].rstrip().endswith("&"):
        at += 1
        shown.append(lines[at])
    comment = []
    for line in lines[at + 1:]:
        if not line.strip() or re.match(r"\s*(contains|end)\b", line):
            break
        if line.strip().startswith("!"):
            comment.append(line)
        elif "intent(" in line or re.search(r"\b(procedure|class|external)\b.*::", line):
            shown += [*comment, line]
            comment = []
        elif not line.rstrip().endswith("&"):
            comment = []
    return shown


def until(lines, at, end):
    """Lines up to the first one that matches."""
    stop = next((n for n in range(at + 1, len(lines)) if re.match(end, lines[n], re.I)), at)
    return lines[at:stop + 1]


def comment_above(lines, at):
    """The comment that ends right above a line."""
    first = at
    while first > 0 and re.match(r"^\s*!(>|!)", lines[first - 1]):
        first -= 1
    return lines[first:at] if first < at and re.match(r"^\s*!>", lines[first]) else []


def entry(lines, at, public):
    """Name, comment and source of the declaration that begins in a line; None if nothing public begins there."""
    line = lines[at]
    for pattern, end in ((TYPE, r"^ {3}end type"), (PROCEDURE, None)):
        found = pattern.match(line)
        if found and not line.strip().lower().startswith("end") and found[1].lower() in public:
            shown = until(lines, at, end) if end else header(lines, at)
            return found[1], comment_above(lines, at), shown
    found = INTERFACE.match(line)
    if found:
        shown = until(lines, at, r"^ {3}end interface")
        names = [found[2].lower(), *re.findall(r"\b(?:subroutine|function)\s+(\w+)", "\n".join(shown).lower())]
        name = next((name for name in names if name in public), None)
        return (name, comment_above(lines, at), shown) if name else None
    return None


def module(path):
    """Section of one module with the module name as heading."""
    lines = path.read_text(encoding="utf-8").split("\n")
    public = public_names("\n".join(lines))
    at = next((n for n, line in enumerate(lines) if re.match(r"(module|program) \w+", line)), None)
    if at is None:
        return ""
    parts = [f"## {path.stem}\n", prose(comment_above(lines, at)) + "\n"]
    constants = [n for n, line in enumerate(lines) if CONSTANT.match(line)]
    if constants:
        parts.append(code(part for n in constants for part in [*comment_above(lines, n), *until(
            lines, n - 1, r"^(?!.*&\s*(!.*)?$)")[1:]]))
    for number in range(at, len(lines)):
        found = entry(lines, number, public)
        if found:
            name, comment, shown = found
            parts.append(f"### {name} {{ #{path.stem}-{name} }}\n\n{prose(comment)}\n\n{code(shown)}")
    return "\n".join(parts)


def page(name):
    """The page of a folder."""
    modules = [module(path) for path in modules_of(name)]
    return f"---\nsearch:\n  boost: 0.05\n---\n# src/{name}\n\n" + "\n".join(modules)
