# SPDX-License-Identifier: BSD-3-Clause
"""A deck as text with places: groups and pieces `key = value`, each with where it stands.

The rules are those of the program (src/base/base_namelist_words.f90): quotes end in their line, a
comment begins with !, each = makes the word before it a key. Nothing is lost: whoever changes a
deck replaces letters between two places and leaves all others as they are.
"""
import re
from dataclasses import dataclass, field

from .errors import PostError

QUOTED = re.compile(r"'(?:[^'\r\n]|'')*'|\"(?:[^\"\r\n]|\"\")*\"")
FORMULA = re.compile(r"\{[^}\r\n]*\}")
# A slash belongs to a unit such as km/s if letters or brackets are close to it.
PLAIN = re.compile(r"(?:\([^)=/&!'\"\r\n]*\)|&(?![A-Za-z])|(?<=[A-Za-z0-9.)])/(?=[A-Za-z(])|[^\s,=/!'\"&{])+")
NAME = re.compile(r"&[A-Za-z]\w*", re.ASCII)
COMMENT = re.compile(r"![^\r\n]*")


@dataclass
class Word:
    """A word of the text."""

    kind: str                                            # name, quoted, plain, or the sign itself
    first: int                                           # its first letter
    last: int                                            # behind its last letter


@dataclass
class Piece:
    """One `key = value`."""

    key: str                                             # small letters, without subscript
    name: Word                                           # the letters of the key alone
    values: list                                         # words of the value without commas
    words: list                                          # all words, the comma behind it too


@dataclass
class Group:
    """One group."""

    name: str                                            # small letters, without &
    first: int                                           # its &
    begin: int                                           # behind its name
    pieces: list = field(default_factory=list)


class DeckText:
    """The groups of one file."""

    def __init__(self, path):
        self.path = path
        try:
            with open(path, "rb") as handle:
                self.text = handle.read().decode("latin-1")  # a letter a byte, whatever they mean
        except OSError as error:
            raise PostError(f"cannot read {path}: {error.strerror}") from error
        self.groups = []
        self._scan()

    def line_of(self, place):
        """Number of the line of a place, from 1."""
        return 1 + len(re.findall(r"\r\n|\r|\n", self.text[:place]))

    def letters(self, first, last):
        """Letters between two places, in one line and as people read them."""
        part = " ".join(self.text[first:last].split())
        return part.encode("latin-1").decode("utf-8", "replace")

    def written(self, piece):
        """A piece as it is written, without the comma behind it."""
        last = piece.values[-1].last if piece.values else piece.words[-1].last
        if self.line_of(piece.name.first) == self.line_of(last):
            return self.letters(piece.name.first, last)
        values = ", ".join(self.letters(word.first, word.last) for word in piece.values)
        return f"{self.letters(piece.name.first, piece.name.last)} = {values}"

    def value(self, piece):
        """The value of a piece if it has one, without quotes and in small letters; else nothing."""
        if len(piece.values) != 1:
            return ""
        word = piece.values[0]
        inside = self.text[word.first:word.last].lower()
        return inside[1:-1].strip() if word.kind == "quoted" else inside

    def _scan(self):
        """Cut the text into groups."""
        inside, words = None, []
        for word in self._words():
            if word.kind == "name" and inside is None:
                name = self.text[word.first + 1:word.last].lower()
                inside = Group(name, word.first, word.last)
            elif inside is None:
                continue
            elif word.kind == "/" or self.text[word.first:word.last].lower() == "&end":
                inside.pieces = self._pieces(words)
                self.groups.append(inside)
                inside, words = None, []
            elif word.kind == "name":
                break
            else:
                words.append(word)
        if inside is not None:
            raise self._broken(inside.first, f"&{inside.name} is not closed by a /")

    def _broken(self, place, what):
        """An error of a deck that cannot be cut into pieces."""
        return PostError(f"{self.path}:{self.line_of(place)}: {what}; "
                         f"mend it first, scree --check {self.path} tells more")

    def _words(self):
        """All words of the text."""
        at, outside = 0, True
        while at < len(self.text):
            letter = self.text[at]
            if letter <= " ":
                at += 1
                continue
            if letter == "!":
                at = COMMENT.match(self.text, at).end()
                continue
            kind, found = letter, None
            if letter in "'\"":
                kind, found = "quoted", QUOTED.match(self.text, at)
                if not found:
                    if not outside:
                        raise self._broken(at, "the quote is not closed")
                    found = re.compile(r"[^\r\n]*").match(self.text, at)
            elif letter == "{":
                kind, found = "formula", FORMULA.match(self.text, at)
                if not found and not outside:
                    raise self._broken(at, "the brace is not closed")
            elif letter not in "/=,":
                found = NAME.match(self.text, at)
                kind = "name" if found else "plain"
                found = found or PLAIN.match(self.text, at)
                outside = outside and kind != "name"
            outside = outside or kind == "/"
            last = found.end() if found else at + 1
            yield Word(kind, at, last)
            at = last

    def _pieces(self, words):
        """The pieces of the words of a group."""
        signs = [place for place, word in enumerate(words) if word.kind == "="]
        begins = []
        for count, sign in enumerate(signs):
            begin = sign - 1
            if begin <= (signs[count - 1] if count else -1) or words[begin].kind != "plain":
                raise self._broken(words[sign].first, "an equals sign without a key before it")
            if self.text[words[begin].first] == "(" and begin > 0 and words[begin - 1].kind == "plain":
                begin -= 1                               # a blank before the subscript
            begins.append(begin)
        found = []
        for begin, sign, end in zip(begins, signs, [*begins[1:], len(words)]):
            head = words[begin]
            bare = self.text[head.first:head.last].partition("(")[0]
            values = [word for word in words[sign + 1:end] if word.kind != ","]
            found.append(Piece(bare.lower(), Word("plain", head.first, head.first + len(bare)),
                               values, words[begin:end]))
        return found
