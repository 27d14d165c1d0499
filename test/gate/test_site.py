# SPDX-License-Identifier: BSD-3-Clause
# timeout: 300
"""The manual can be built as a site without a warning, and can be read and searched from disk without a network.

Would catch a link or an anchor that leads nowhere on the site, a page that is not in the navigation, a script, style or
font that is fetched when the site is viewed, formulas that no script renders, and a term that new users search for and
do not find. Skipped where MkDocs is not installed (scripts/setup.sh installs it).
"""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
MISSING = [name for name in ("material", "mathjax", "mkdocs", "mkdocstrings") if not importlib.util.find_spec(name)]
WHY = f"MkDocs is not installed ({', '.join(MISSING)} missing); scripts/setup.sh installs it"
pytestmark = pytest.mark.skipif(bool(MISSING), reason=WHY)
#: What new users search for, and a page that must hold it in a heading.
SOUGHT = {"NaN": "reference/glossary.html", "restart": "guide/running.html", "free surface": "reference/glossary.html",
          "contact": "theory/contact.html", "units": "guide/deck.html"}
FETCHED = re.compile(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=\"?(https?:[^\"\s>]+)", re.I)


def build(root, folder):
    """Exit code and all output of MkDocs."""
    answer = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(folder)], cwd=root,
                            capture_output=True, text=True, check=False,
                            env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    return answer.returncode, answer.stdout + answer.stderr


@pytest.fixture(scope="module", name="site")
def built(tmp_path_factory):
    """Folder of the site."""
    folder = tmp_path_factory.mktemp("manual") / "site"
    code, said = build(ROOT, folder)
    assert code == 0, said[-6000:]
    assert len(list(folder.rglob("*.html"))) > 80
    return folder


def test_links_are_checked(tmp_path):
    """A broken link must stop the build, also in a README of a scene, which MkDocs does not check by itself."""
    for name in ("doc", "scripts", "input"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "messages", "*.png"))
    for picture in [*(ROOT / "doc").rglob("*.png"), *(ROOT / "input").rglob("*.png")]:
        (tmp_path / picture.relative_to(ROOT)).symlink_to(picture)
    for name in ("mkdocs.yml", "CMakeLists.txt", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE",
                 "README.md", "src", "python", "test"):
        (tmp_path / name).symlink_to(ROOT / name)
    with open(tmp_path / "input/two_discs/README.md", "a", encoding="utf-8") as page:
        page.write("\n[Nowhere](../../doc/guide/nowhere.md) and [no anchor](../../doc/guide/deck.md#nowhere)\n")
    code, said = build(tmp_path, tmp_path / "build/site")
    assert code != 0
    assert "nowhere.md" in said
    assert "#nowhere" in said


def test_nothing_is_fetched(site):
    found = [f"{page.relative_to(site)} fetches {url}" for page in site.rglob("*.html")
             for url in FETCHED.findall(page.read_text(encoding="utf-8"))]
    assert found == []
    assert [path for path in site.rglob("*.css") if re.search(r"url\(['\"]?https?:", path.read_text("utf-8"))] == []


def test_formulas_are_drawn(site):
    page = (site / "theory/method.html").read_text(encoding="utf-8")
    assert page.count('class="arithmatex"') > 50
    assert "assets/mathjax.js" in page
    assert (site / "assets/mathjax.js").stat().st_size > 1000000
    assert not re.search(r"\$\$", re.sub(r"<(script|pre|code)\b.*?</\1>", "", page, flags=re.S))


def test_search_finds(site):
    text = (site / "search/search_index.js").read_text(encoding="utf-8")
    entries = json.loads(text[text.index("{"):])["docs"]
    assert len(entries) > 500
    for word, page in SOUGHT.items():
        titles = [entry["title"] for entry in entries if entry["location"].startswith(page)]
        assert any(word.lower() in title.lower() for title in titles), f"{word} in {page}: {titles}"
    # a search for a key must rank its declaration before guides, messages, changes and pages for developers
    boosts = {True: [], False: []}
    for entry in entries:
        boosts[entry["location"].startswith("reference/keys.html")].append(entry.get("boost", 1.0))
    assert min(boosts[True]) >= 10.0 * max(boosts[False])
