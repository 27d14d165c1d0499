# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
"""Comments, messages and names of src/ use the terms of the field.

Would catch words that a reader cannot search for ("a number that is none" for NaN), personified data ("the deck is
told"), and comments that only repeat the declaration (`!! The grid`).
"""

import re

from sources import COVERED, ROOT, code_of, lines_of, place, project_files

# Patterns of rejected words, each with the term to use instead.
OUT = [(re.compile(pattern, re.I), term) for pattern, term in (
    (r"\bwhole numbers?\b", "integer"),
    (r"\bnumbers? that (?:is|are) none\b|\bbad numbers?\b|\b(?:is|are) no numbers?\b", "NaN, not finite"),
    (r"\bpoints? of matter\b", "particle, material point"),
    (r"(?<!no )\bmatter\b", "material"),
    (r"\blocal places\b|\bplaces\b", "positions, local coordinates"),
    (r"\bnode functions?\b", "shape functions"),
    (r"\bshare (?:of the cell|alpha)\b", "weight alpha, cell fraction"),
    (r"\brooms?\b", "capacity, buffer"),
    (r"\bpieces\b", "packed patches, parts"),
    (r"\b(?:un)?settle[sdr]?\b|\b(?:re)?arrange[sdr]?\b", "to sort, to decide"),
    (r"\basks?\b|\basked\b|\bwish(?:es)?\b", "to request, requests"),
    (r"\bbook(?:s|ed|ing)?\b", "ledger, balance; to record"),
    (r"\baskew\b", "inclined, oblique"),
    (r"\btorn\b|\b(?:come|comes|came) apart\b", "separated"),
    (r"\blook(?:s|ed|ing)? at\b", "to use, to examine"),
    (r"\bstands? in\b", "is in"),
    (r"\bof before\b", "previous, old"),
    (r"\btold\b|\btells?\b", "reported, reports; given"),
    (r"\bdear\b|\bcheap\b", "costly, inexpensive"),
    (r"\bhardly meant\b", "implausible"),
    (r"\bround (?:an|the|its) axis\b", "axisymmetric, around"),
    (r"\blone particles?\b", "isolated particle"),
    (r"\blight nodes?\b", "node of small mass"),
    (r"\bmethod's seed\b|\bseed of the method\b", "the scheme of LA-UR-11-06616"),
    (r"\bfaces? that absorbs?\b", "absorbing boundary"),
    (r"\bculprits?\b", "offending particle"),
    (r"\bwhat (?:fails|has failed)\b|\bfailed matter\b", "failed material"),
    (r"\bnobody\b|\bwhoever\b", "what is meant"),
)]
# Rejected words in names. Names are split at underscores, and each part is compared.
OUT_OF_NAMES = {"room", "rooms", "askew", "torn", "wish", "wishes", "ask", "asks", "asked", "books", "booked",
                "tell", "tells", "told", "settle", "settler", "unsettle", "arrange", "arranger", "arranged", "matter",
                "culprit", "places", "restless"}
# Names of other libraries.
FOREIGN_NAMES = {"omp_get_num_places"}
# Accepted exceptions, each with its reason.
EXCEPTIONS = [re.compile(pattern) for pattern in (
    r"(?:node_functions|matter)\.md",  # names of pages of the theory
    r"\bdecimal places\b",  # digits after the point
    r"[\"']matter[\"']",  # key of &output in decks
)]
REPEATS = re.compile(r"!!\s*(?:It|This|Them|They|Which|(?:The|Which) [a-z]+)\s*$")


def split_line(line):
    """Code without strings, strings, and comment of a line."""
    code = code_of(line)
    start = line.find(code) + len(code) if code else 0
    comment = line[start:].strip()
    strings = re.findall(r'"[^"]*"|\'[^\']*\'', code)
    return re.sub(r'"[^"]*"|\'[^\']*\'', " ", code), strings, comment


def offences_of(line):
    """Messages about one line of Fortran."""
    code, strings, comment = split_line(line)
    found = []
    for text in [comment, *strings]:
        for exception in EXCEPTIONS:
            text = exception.sub(" ", text)
        found += [f"says `{match.group(0)}`; the term is: {term}"
                  for pattern, term in OUT for match in pattern.finditer(text)]
    for name in sorted(set(re.findall(r"[a-z]\w*", code, re.I)) - FOREIGN_NAMES):
        parts = OUT_OF_NAMES & set(name.lower().split("_"))
        found += [f"has the name {name} with `{part}`" for part in sorted(parts)]
    if REPEATS.match(comment):
        found.append(f"has a comment that repeats the declaration: {comment}")
    return found


class TestGlossary:
    """All violations are listed."""

    def test_samples(self):
        """The gate itself: rejected words are found in comments, strings and names, other words are not."""
        bad = ('n = 1  ! a whole number', 'call stop_run("dt is a number that is none")', "integer, intent(in) :: wish",
               "type(grid_t), intent(in) :: grid  !! The grid", "integer, intent(in) :: tile !! Which tile",
               "!> The deck is told all its faults", "call settle_store(store)", "!! It", "!! Energy for the books",
               'message = "faces that absorb"', "! it does not matter, but this matter does")
        for line in bad:
            assert offences_of(line), line
        good = ("n = 1  ! an integer", 'text = "no matter what"', "integer, intent(in) :: count !! (tile) New counts",
                "x = mushroom + bookkeeping_of", "!> Shape functions: doc/theory/node_functions.md",
                "position = lower  !! The position before the step [m]", 'call group%get("matter", word)')
        for line in good:
            assert offences_of(line) == [], line

    def test_sources(self):
        paths = [path for folder in COVERED for path in project_files(".f90", under=f"src/{folder}")]
        assert len(paths) > 10
        assert all((ROOT / "src" / folder).is_dir() for folder in COVERED)
        found = [f"{place(path, number)} {offence}" for path in paths
                 for number, line in enumerate(lines_of(path), 1) for offence in offences_of(line)]
        assert len(found) == 0, "\n" + "\n".join(found)
