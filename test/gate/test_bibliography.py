# SPDX-License-Identifier: BSD-3-Clause
"""The bibliography has the sources that the theory pages cite, and each page that it names cites the source.

Would catch a citation on a page without an entry, an entry whose page no longer cites it, a misspelt name or another
year, and an entry out of order.
"""

import re

from sources import ROOT

THEORY = ROOT / "doc" / "theory"
PAGE = THEORY / "bibliography.md"
ROWS = re.findall(r"^\| ([^|]*) \| [^|]* \|[^|]*\| ([^|]*) \|$", PAGE.read_text(encoding="utf-8"), re.M)[1:]
NAME = re.compile(r"(?:[A-Z]\.[ -]?)+((?:de |von |van )?[A-Z][^\W\d_]+(?:-[A-Z][^\W\d_]+)?(?: Neto)?)")
YEAR = re.compile(r"\b(?:18|19|20)\d\d\b")
# Words after an initial that are journals, not people.
JOURNALS = set("Fluid Appl Comput Mech Phys Chem Rheol Eng Int Impact Fract Numer Mater Math Rock Soc".split())


def text_of(path):
    """Text of a page or source in one line."""
    return re.sub(r"\s*\n(?:\s*!!?)?\s*", " ", path.read_text(encoding="utf-8"))


def citations(text):
    """Pairs of name and year: the first author of a list, and the first year after it."""
    for found in NAME.finditer(text):
        if found[1] in JOURNALS or text[:found.start()].endswith((", ", " and ")):
            continue                             # a journal or a further author
        year = YEAR.search(text, found.end(), found.end() + 120)
        if year:
            yield found[1], year[0]


def test_samples():
    """The search itself."""
    text = "(A. B. Smith, C. Jones, J. Appl. Mech. 18 (1951) 293), by G. Lube and others, J. Fluid Mech. 5 (2004) 1"
    assert list(citations(text)) == [("Smith", "1951"), ("Lube", "2004")]


def test_citations_have_entries():
    entries = {(found[1], row[-4:]) for row, _ in ROWS if (found := NAME.match(row))}
    assert len(entries) > 100
    cited = {(name, year, path.name) for path in THEORY.glob("*.md") if path != PAGE
             for name, year in citations(text_of(path))}
    assert len(cited) > 60
    assert sorted(one for one in cited if one[:2] not in entries) == []


def test_entries_are_cited():
    rows = [(NAME.match(row)[1], row[-4:], used) for row, used in ROWS]
    for name, year, used in rows:
        assert (places := re.findall(r"\]\(([^)]*)\)|`([^`]*)`", used)), (name, year)
        for link, source in places:
            text = text_of((THEORY / link) if link else ROOT / source)
            assert name in text and (year in text or not year.isdigit()), (name, year, link or source)
    names = [name.lower() for name, *_ in rows]
    assert names == sorted(names)
