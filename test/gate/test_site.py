# SPDX-License-Identifier: BSD-3-Clause
# timeout: 300
"""The manual builds as a site without a warning, and can be read and searched from disk without a network.

Would catch a link or an anchor of a page that leads nowhere on the site, a page that is not in the navigation, a
script, style or font that is fetched when the site is viewed, formulas that no script draws, and a word that new
users search for and do not find. Usage: test_site.py --scree PATH --work DIR
"""

import json
import os
import re
import shutil
import subprocess
import sys
import unittest
from pathlib import Path

from sources import ROOT

sys.path.insert(0, str(ROOT / "test" / "support"))
import report  # noqa: E402

#: What new users search for, and a page that must hold it in a heading.
SOUGHT = {"NaN": "reference/glossary.html", "restart": "guide/running.html", "free surface": "reference/glossary.html",
          "contact": "theory/contact.html", "units": "guide/deck.html"}
FETCHED = re.compile(r"<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=\"?(https?:[^\"\s>]+)", re.I)
WORK = Path(sys.argv[sys.argv.index("--work") + 1]).resolve() if "--work" in sys.argv else ROOT / "build/test/gate"
SITE = WORK / "site"


def mkdocs(*words):
    """Exit code and all that MkDocs says."""
    answer = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", *map(str, words)], cwd=ROOT,
                            capture_output=True, text=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"})
    return answer.returncode, answer.stdout + answer.stderr


class SiteGate(unittest.TestCase):
    """The site is built once, from the repository as it is."""

    @classmethod
    def setUpClass(cls):
        shutil.rmtree(SITE, ignore_errors=True)
        cls.code, cls.said = mkdocs("--site-dir", SITE)
        cls.pages = sorted(SITE.rglob("*.html"))

    def test_builds_without_warning(self):
        self.assertEqual(self.code, 0, self.said[-6000:])
        self.assertGreater(len(self.pages), 80)

    def test_links_are_checked(self):
        """A page with a link to nowhere must stop the build, also in a README of a scene."""
        copy = WORK / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        copy.mkdir(parents=True)
        for name in ("doc", "scripts", "input"):
            shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
        for name in ("mkdocs.yml", "CMakeLists.txt", "CHANGELOG.md", "CONTRIBUTING.md", "CITATION.cff", "LICENSE",
                     "README.md"):
            shutil.copy(ROOT / name, copy / name)
        for name in ("src", "python", "test"):
            (copy / name).symlink_to(ROOT / name)
        with open(copy / "input/two_discs/README.md", "a", encoding="utf-8") as page:
            page.write("\n[Nowhere](../../doc/guide/nowhere.md) and [no anchor](../../doc/guide/deck.md#nowhere)\n")
        answer = subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", WORK / "broken"],
                                cwd=copy, capture_output=True, text=True)
        said = answer.stdout + answer.stderr
        self.assertNotEqual(answer.returncode, 0, said)
        self.assertIn("nowhere.md", said)
        self.assertIn("#nowhere", said)

    def test_nothing_is_fetched(self):
        found = [f"{page.relative_to(SITE)} fetches {url}" for page in self.pages
                 for url in FETCHED.findall(page.read_text(encoding="utf-8"))]
        self.assertEqual(found, [])
        styles = [path for path in SITE.rglob("*.css") if re.search(r"url\(['\"]?https?:", path.read_text("utf-8"))]
        self.assertEqual(styles, [])

    def test_formulas_are_drawn(self):
        page = (SITE / "theory/method.html").read_text(encoding="utf-8")
        self.assertGreater(page.count('class="arithmatex"'), 50)
        self.assertIn("assets/mathjax.js", page)
        self.assertGreater((SITE / "assets/mathjax.js").stat().st_size, 1000000)
        self.assertNotRegex(re.sub(r"<(script|pre|code)\b.*?</\1>", "", page, flags=re.S), r"\$\$")

    def test_search_finds(self):
        text = (SITE / "search/search_index.js").read_text(encoding="utf-8")
        entries = json.loads(text[text.index("{"):])["docs"]
        self.assertGreater(len(entries), 500)
        for word, page in SOUGHT.items():
            titles = [entry["title"] for entry in entries if entry["location"].startswith(page)]
            self.assertTrue(any(word.lower() in title.lower() for title in titles), f"{word} in {page}: {titles}")


if __name__ == "__main__":
    try:
        import material      # noqa: F401
        import mathjax       # noqa: F401
        import mkdocs as _   # noqa: F401
        import mkdocstrings  # noqa: F401
    except ImportError as missing:
        report.skip_all(f"MkDocs is not installed ({missing}); scripts/setup.sh installs it")
    unittest.main(argv=sys.argv[:1])
