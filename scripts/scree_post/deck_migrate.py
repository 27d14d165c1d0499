# SPDX-License-Identifier: BSD-3-Clause
"""Decks of before in the names of today.

What a key was called is known to the program alone: `scree --list former` is the table that is
followed here, and the same that its messages are made of. Only the names and words concerned are
replaced; comments, layout, ends of lines and all other letters stay as they are.
"""
import os
import re
import shutil
import subprocess
from dataclasses import dataclass, field
from pathlib import Path

from .deck_text import DeckText
from .errors import EXIT_DIFFERENT, PostError

LINE = re.compile(r"(?P<group>\w+)\.(?P<key>\w+)(?: = '(?P<words>[^>]*)')? -> (?P<new>.*?)"
                  r"(?:; since deck_version (?P<since>\d+))?(?:  ! (?P<why>.*))?")
SWITCHES = {".t.": ".true.", "true": ".true.", "t": ".true.",
            ".f.": ".false.", "false": ".false.", "f": ".false."}
PATHS = {"file", "table"}                                # keys that name files beside the deck


@dataclass
class Former:
    """A key of before, or some words of one."""

    group: str
    key: str
    words: tuple                                         # values that are meant; empty: all
    new: str                                             # key, key = 'word', gone or by hand
    why: str


@dataclass
class Table:
    """All former names, and the format of decks that the program knows."""

    version: int
    formers: list

    def find(self, group, key, value):
        """The first entry that fits a piece of a deck, or None."""
        value = SWITCHES.get(value, value)
        for former in self.formers:
            if (former.group, former.key) == (group, key) and (
                    not former.words or value in former.words):
                return former
        return None


@dataclass
class Migrated:
    """What becomes of one file."""

    deck: DeckText
    text: str = ""
    changes: list = field(default_factory=list)          # (line, what)
    refused: list = field(default_factory=list)          # (line, why)


def read_table(text):
    """The table of `scree --list former`."""
    head, *rest = text.strip().splitlines()
    version = re.fullmatch(r"deck_version (\d+)", head)
    found = [LINE.fullmatch(line) for line in rest]
    if not version or None in found:
        raise PostError("scree --list former is not understood; take scree and scree-deck of one version")
    return Table(int(version[1]), [
        Former(one["group"], one["key"], tuple((one["words"] or "").lower().split("' '"))
               if one["words"] else (), one["new"], one["why"] or "") for one in found])


def table_of(program):
    """The table of a program."""
    answer = subprocess.run([program, "--list", "former"], capture_output=True, text=True, check=False)
    if answer.returncode:
        raise PostError(f"{program} knows no former names: {answer.stderr.strip()}")
    return read_table(answer.stdout)


class Editor:
    """Changes in one file, applied together."""

    def __init__(self, deck):
        self.deck, self.edits = deck, []

    def replace(self, first, last, letters):
        """Other letters between two places."""
        self.edits.append((first, last, letters))

    def remove(self, piece):
        """A piece goes; a line that it leaves empty goes with it, a comment stays."""
        text, words = self.deck.text, list(piece.words)
        while words:
            begin = 1 + max(text.rfind(end, 0, words[0].first) for end in "\r\n")
            end = re.compile(r"[^\r\n]*").match(text, begin).end()
            here = [word for word in words if word.first < end]
            words = words[len(here):]
            first, last = here[0].first, here[-1].last
            if not text[begin:first].strip() and not text[last:end].strip():
                first, last = begin, re.compile(r"\r\n|\r|\n|").match(text, end).end()
            elif text[last:end].strip():
                last += len(text[last:end]) - len(text[last:end].lstrip())
            else:
                first, last = begin + len(text[begin:first].rstrip()), end
            self.replace(first, last, "")

    def result(self):
        """The text with all changes."""
        text = self.deck.text
        for first, last, letters in sorted(self.edits, reverse=True):
            text = text[:first] + letters + text[last:]
        return text


def migrate(deck, table):
    """What becomes of one file."""
    done, editor = Migrated(deck), Editor(deck)
    for group in deck.groups:
        for piece in group.pieces:
            former = table.find(group.name, piece.key, deck.value(piece))
            if former:
                line = deck.line_of(piece.name.first)
                try:
                    done.changes.append((line, change(editor, group, piece, former)))
                except ValueError as error:
                    done.refused.append((line, str(error)))
    set_version(editor, table.version, done)
    done.text = editor.result()
    return done


def change(editor, group, piece, former):
    """Note the change of one piece; the result says what it is. What cannot be done is a ValueError."""
    deck = editor.deck
    old, where = deck.written(piece), f"&{group.name}: "
    if former.new == "by hand":
        raise ValueError(f"{where}{old} is gone and somebody must decide: {former.why}")
    if former.new == "gone":
        editor.remove(piece)
        return f"{where}{old}  ->  gone: {former.why}"
    key, _, word = former.new.partition(" = ")
    if key != piece.key:
        for other in group.pieces:
            if other.key == key:
                raise ValueError(f"{where}{old} is called {former.new}, but {key} is given already "
                                 f"in line {deck.line_of(other.name.first)}; remove one of both")
        editor.replace(piece.name.first, piece.name.last, key)
    new = old.replace(old[:len(piece.key)], key, 1)
    if word:
        value = piece.values[0]
        if value.kind == "quoted" and word[0] == "'":    # texts keep the quotes that they had
            word = word.replace("'", deck.text[value.first])
        editor.replace(value.first, value.last, word)
        new = f"{key} = {word}"
    return f"{where}{old}  ->  {new}"


def set_version(editor, version, done):
    """Write the format of decks that the names are of now, where it is not that of a silent deck."""
    deck = editor.deck
    for group in deck.groups:
        for piece in group.pieces if group.name == "run" else []:
            if piece.key == "deck_version":
                have, line = deck.value(piece), deck.line_of(piece.name.first)
                if not have.isdecimal() or int(have) > version:
                    done.refused.append((line, f"&run: deck_version = {have}; this scree knows "
                                               f"formats from 1 to {version}"))
                elif int(have) < version:
                    editor.replace(piece.values[0].first, piece.values[0].last, str(version))
                    done.changes.append((line, f"&run: deck_version = {have}  ->  {version}"))
                return
    first = next((group for group in deck.groups if group.name == "run"), None)
    if version == 1 or not first:
        return
    place, letters = first.begin, f" deck_version = {version}"
    if first.pieces:
        place = first.pieces[0].name.first
        blank = re.search(r"\s*$", deck.text[first.begin:place]).group()
        letters = f"deck_version = {version}" + (blank or " ")
    editor.replace(place, place, letters)
    done.changes.append((deck.line_of(place), f"&run: deck_version = {version} is written"))


def with_includes(path, table):
    """The files of a deck, itself first, each with what becomes of it."""
    waiting, seen, found = [str(path)], set(), []
    while waiting:
        name = waiting.pop(0)
        if os.path.realpath(name) in seen:
            continue
        seen.add(os.path.realpath(name))
        deck = DeckText(name)
        found.append(migrate(deck, table))
        for group in deck.groups:
            if group.name == "include":
                waiting += [os.path.join(os.path.dirname(name), quoted_text(deck, piece))
                            for piece in group.pieces if piece.key == "file" and piece.values]
    return found


def quoted_text(deck, piece):
    """The text of a piece, letters as they are."""
    word = piece.values[0]
    inside = deck.text[word.first:word.last]
    return inside[1:-1].strip().encode("latin-1").decode("utf-8", "surrogateescape")


def named_paths(deck):
    """Whether a deck names files by their place beside it."""
    return any(piece.key in PATHS and piece.values and not deck.value(piece).startswith("/")
               for group in deck.groups for piece in group.pieces)


def write(done, path):
    """Write one file, whole or not at all."""
    part = f"{path}.part"
    try:
        with open(part, "wb") as handle:
            handle.write(done.text.encode("latin-1"))
        shutil.copymode(done.deck.path, part)
        os.replace(part, path)
    except OSError as error:
        Path(part).unlink(missing_ok=True)
        raise PostError(f"cannot write {path}: {error.strerror}") from error


def check_writing(files, out):
    """A copy elsewhere must be one file that still finds what it names."""
    if os.path.exists(out):
        raise PostError(f"{out} is there already; --write rewrites a deck in its place")
    others = [one.deck.path for one in files[1:] if one.changes]
    if others:
        raise PostError(f"{', '.join(others)} must change too; --write rewrites all files of a deck",
                        EXIT_DIFFERENT)
    here, there = (os.path.realpath(os.path.dirname(os.path.abspath(path)))
                   for path in (files[0].deck.path, out))
    if here != there and named_paths(files[0].deck):
        raise PostError(f"the deck names files by their place beside it; let {out} stand in {here}",
                        EXIT_DIFFERENT)
