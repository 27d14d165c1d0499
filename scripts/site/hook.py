# SPDX-License-Identifier: BSD-3-Clause
"""Hook of MkDocs that adds files outside of doc/ to the site, without copies in the repository.

READMEs, CHANGELOG and CONTRIBUTING become pages. Pictures and other files to which a page links are taken
along; text files (decks, sources, scripts) become pages with coloured text, and folders pages that list them. With
the environment variable SCREE_REPOSITORY (the address of a public repository) links to sources and folders go there
instead. The modules of src/ get a page for each folder (fortran.py), to which the list at the end of
doc/api/fortran.md leads. Links are rewritten when MkDocs reads a page; MkDocs checks all of them afterwards.
"""
import json
import os
import posixpath
import re
import subprocess
import sys
from pathlib import Path

import mathjax
from mkdocs.structure.files import File, InclusionLevel

sys.path.insert(0, str(Path(__file__).resolve().parent))
import fortran  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]
MODULES = "api/fortran.md"
NOTEBOOKS = "doc/learn/notebooks"
#: Pages that are not in doc/, by their path in the repository.
PAGES = {"CHANGELOG.md": "changes.md", "CONTRIBUTING.md": "contributing.md", "README.md": "readme.md",
         "doc/ford.md": MODULES}
#: Weight of pages in the search, so that a search for a key finds its declaration first and pages for developers last.
SEARCH_BOOST = {"reference/keys.md": 20.0, "developer/": 0.5, "api/": 0.5, "changes.md": 0.5}
ASSETS = ("formulas.js", "site.css", "favicon.svg", "iframe-worker.js")
MATHJAX = Path(mathjax.__file__).parent / "static/mathjax/es5/tex-svg-full.js"
LINK = re.compile(r"(\]\()([^)\s]+)(\))")
FENCE = re.compile(r"^```.*?^```", re.M | re.S)
LANGUAGES = {".f90": "fortran", ".nml": "fortran", ".py": "python", ".sh": "bash", ".cmake": "cmake", ".txt": "text",
             ".js": "javascript", ".yml": "yaml", ".cff": "yaml", ".toml": "toml", ".md": "markdown"}


def version():
    """Version of the program and commit of the sources."""
    number = re.search(r"project\(\s*scree\s+VERSION\s+([\d.]+)", (ROOT / "CMakeLists.txt").read_text(), re.I)[1]
    answer = subprocess.run(["git", "-C", str(ROOT), "log", "-1", "--format=%h, %cs"], capture_output=True, text=True,
                            check=False)
    return number, answer.stdout.strip()


def place_in_repository(uri):
    """Path in the repository of a page of the site."""
    for path, page in PAGES.items():
        if page == uri and page in ("changes.md", "contributing.md", "readme.md"):
            return path
    scene = re.fullmatch(r"scenes/(\w+)\.md", uri)
    return f"input/{scene[1]}/README.md" if scene else f"doc/{uri}"


def place_on_site(path):
    """Page or file of the site for a file of the repository; None if the repository on the web is the target."""
    scene = re.fullmatch(r"input/(\w+)/README\.md", path)
    if scene:
        return f"scenes/{scene[1]}.md"
    if path in PAGES:
        return PAGES[path]
    whole = ROOT / path
    if path.startswith("doc/"):
        return re.sub(r"\.ipynb$", ".md", path[4:]) + ("/index.md" if whole.is_dir() else "")
    if whole.is_dir():
        return f"files/{path}/index.md"
    picture = whole.suffix in (".png", ".svg", ".gif", ".csv", ".h5", ".stl", ".mp4")
    return f"files/{path}" if picture else f"files/{path}.md"


def target_of(link, path):
    """Path in the repository to which a link of the document `path` leads, and its anchor; None if it is no file."""
    if link.startswith(("http:", "https:", "mailto:", "#")):
        return None
    name, mark, anchor = link.partition("#")
    target = posixpath.normpath(posixpath.join(posixpath.dirname(path), name))
    if target.startswith("..") or not (ROOT / target).exists():
        return None                                      # MkDocs reports it
    return target, mark + anchor


def address(path, repository):
    """Web address of a source or folder; None if it becomes a part of the site."""
    on_site = place_on_site(path)
    if repository and on_site.startswith("files/") and on_site.endswith(".md"):
        return f"{repository.rstrip('/')}/{'tree' if (ROOT / path).is_dir() else 'blob'}/main/{path}"
    return None


def text_outside_fences(text, change):
    """The text with `change` applied to all parts outside of fenced blocks."""
    result, at = [], 0
    for block in FENCE.finditer(text):
        result += [change(text[at:block.start()]), block[0]]
        at = block.end()
    return "".join([*result, change(text[at:])])


def page_of_file(path):
    """A source as a page, a folder as a list."""
    whole = ROOT / path
    head = f"---\nsearch:\n  exclude: true\n---\n# {path}\n\n"
    if whole.is_dir():
        return head + "".join(f"* `{entry.name}`\n" for entry in sorted(whole.iterdir())
                              if not entry.name.startswith((".", "__")))
    text = whole.read_text(encoding="utf-8")
    return f"{head}``````{LANGUAGES.get(whole.suffix, 'text')}\n{text}\n``````\n"


def page_of_notebook(path):
    """A Jupyter notebook as a page, without the outputs of its cells."""
    cells = json.loads((ROOT / path).read_text(encoding="utf-8"))["cells"]
    texts = [("".join(cell["source"]), cell["cell_type"]) for cell in cells]
    return "\n\n".join(f"```python\n{text}\n```" if kind == "code" else text for text, kind in texts) + (
        f"\n\nThe notebook is `{path}`.\n")


def add_notebooks(add):
    """Add the pages of all notebooks and a list of them."""
    paths = sorted((ROOT / NOTEBOOKS).glob("*.ipynb"))
    for path in paths:
        add(f"{NOTEBOOKS[4:]}/{path.stem}.md", content=page_of_notebook(str(path.relative_to(ROOT))))
    if paths:
        add(f"{NOTEBOOKS[4:]}/index.md", content="# Notebooks\n\n" + "".join(
            f"* [{path.stem}]({path.stem}.md)\n" for path in paths))


def linked_files(documents):
    """All files outside of doc/ that are the target of a link in one of the documents."""
    found = set()
    for path in documents:
        text = (ROOT / path).read_text(encoding="utf-8")
        for _, link, _ in LINK.findall(FENCE.sub("", text)):
            target = target_of(link, path)
            if target:
                found.add(target[0])
    return found


def on_config(config):
    """Show the version in the footer of each page."""
    number, commit = version()
    config.copyright = f"Scree {number} ({commit})" if commit else f"Scree {number}"
    # replaces the scripts that the plugin `offline` would load from a network when the site is viewed
    config.extra["polyfills"] = ["assets/iframe-worker.js"]
    if os.environ.get("SCREE_SITE_RELEASE"):
        config.extra["version"] = {"provider": "mike"}   # the version selector reads ../versions.json
    return config


def on_files(files, config):
    """Add pages and files from outside of doc/."""
    known = {file.src_uri for file in files}

    def add(uri, **what):
        if uri not in known:
            known.add(uri)
            files.append(File.generated(config, uri, **what))

    for name in ASSETS:
        add(f"assets/{name}", abs_src_path=str(ROOT / "scripts/site" / name))
    add("assets/mathjax.js", abs_src_path=str(MATHJAX))
    outside = ["CHANGELOG.md", "CONTRIBUTING.md", "README.md",
               *(str(path.relative_to(ROOT)) for path in sorted((ROOT / "input").glob("*/README.md")))]
    for path in outside:
        add(place_on_site(path), content=(ROOT / path).read_text(encoding="utf-8"))
    pages = [f"doc/{file.src_uri}" for file in files.documentation_pages() if (ROOT / "doc" / file.src_uri).is_file()]
    for path in sorted(linked_files([*pages, *outside])):
        uri = place_on_site(path)
        if uri in known or not uri.startswith("files/") or address(path, os.environ.get("SCREE_REPOSITORY")):
            continue
        if uri.endswith(".md"):
            add(uri, content=page_of_file(path))
        else:
            add(uri, abs_src_path=str(ROOT / path))
    add_notebooks(add)
    for name in fortran.folders():
        add(f"api/fortran/{name}.md", content=fortran.page(name))
    for file in files:
        if file.src_uri.startswith(("files/", "api/fortran/")) and file.src_uri.endswith(".md"):
            file.inclusion = InclusionLevel.NOT_IN_NAV
    return files


def on_page_markdown(markdown, page, config, files):
    """Replace links that are valid in the repository by links to pages of the site; weigh the page in the search."""
    for start, boost in SEARCH_BOOST.items():
        if page.file.src_uri.startswith(start):
            page.meta["search"] = {"boost": boost, **page.meta.get("search", {})}
    if page.file.src_uri.startswith(("files/", "api/fortran/")):
        return markdown
    if page.file.src_uri == MODULES:
        markdown += "".join(f"\n* [src/{name}](fortran/{name}.md), {fortran.summary(name)} modules"
                            for name in fortran.folders())
    path = place_in_repository(page.file.src_uri)
    here = posixpath.dirname(page.file.src_uri)

    def rewritten(match):
        target = target_of(match[2], path)
        if target is None:
            return match[0]
        on_web = address(target[0], os.environ.get("SCREE_REPOSITORY"))
        if on_web:
            return f"{match[1]}{on_web}{match[3]}"
        uri = place_on_site(target[0])
        return f"{match[1]}{posixpath.relpath(uri, here or '.')}{target[1]}{match[3]}"

    return text_outside_fences(markdown, lambda text: LINK.sub(rewritten, text))
