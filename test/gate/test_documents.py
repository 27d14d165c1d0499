# SPDX-License-Identifier: BSD-3-Clause
"""The documents agree with the program and with each other.

Would catch a link or a file name that leads nowhere, a document that is too long to be read, a key, field or column
that was added or renamed without a change of the documents, and printed examples that the program no longer prints.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

from sources import ROOT, lines_of, place, project_files

LONGEST = 250
# lists that scripts generate, whose length follows from the number of keys and scenes
WRITTEN = {ROOT / "doc" / "reference" / "keys.md", ROOT / "doc" / "reference" / "messages.md",
           ROOT / "doc" / "gallery.md"}
DOCUMENTS = project_files(".md")
LINK = re.compile(r"\]\(([^)\s]+)\)")
NAMED = re.compile(r"`((?:src|scripts|test|cmake|doc|input)/[a-z0-9_./]+)`")
FIRST_STEPS = ROOT / "doc" / "learn" / "first_deck.md"
DECK = ROOT / "doc" / "guide" / "deck.md"
RUNNING = ROOT / "doc" / "guide" / "running.md"
MATTER_OUTPUTS = ROOT / "doc" / "reference" / "matter_outputs.md"
OUTPUT = ROOT / "doc" / "reference" / "output.md"
SCENE = "input/two_discs/scene.nml"



def scree(options, *arguments, folder=ROOT):
    """Exit code and all output of the program."""
    answer = subprocess.run([options.scree, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    return answer.returncode, answer.stdout + answer.stderr


def blocks(path, language):
    """Contents of the fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", path.read_text(encoding="utf-8"), re.M | re.S)


def first_cells(path, heading):
    """Names in code in the first column of the tables of one section."""
    section = re.split(r"^## ", path.read_text(encoding="utf-8"), flags=re.M)
    chosen = next(part for part in section if part.startswith(heading))
    cells = [line.split("|")[1] for line in chosen.split("\n") if line.startswith("| `")]
    return [name for cell in cells for name in re.findall(r"`(\w+)`", cell)]


class TestDocumentGate:
    """One rule per test; all violations are listed."""

    def none(self, offences):
        assert len(offences) == 0, "\n" + "\n".join(offences)

    def test_materials_that_lose_energy(self):
        """The list of the manual is that of the sources: which equations of state and laws request an energy. Would
        catch a new one, or one that begins to store energy, that the page does not name."""
        text = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "src").rglob("*.f90"))
        store = set(re.findall(r'%add\("energy", "(?:equation of state|strength model) (\w+)"', text))
        states = {path.stem.removeprefix("eos_") for path in (ROOT / "src").rglob("eos_*.f90")}
        chosen = (ROOT / "doc" / "guide" / "choose.md").read_text(encoding="utf-8")
        rows = {word: set(re.findall(r"[`'](\w+)[`']", re.search(rf"^\| {word} it \|(.*)\|$", chosen, re.M)[1]))
                for word in ("store", "lose")}
        assert len(states) > 6 and rows["store"] == store, (rows, store)
        assert rows["lose"] == states - (store - {"jh2"}), (rows, states)

    def test_documents_are_found(self):
        assert len(DOCUMENTS) > 15

    def test_length(self):
        self.none([f"{place(path, 1)} has {len(lines_of(path))} lines, limit {LONGEST}"
                   for path in DOCUMENTS
                   if path not in WRITTEN and len(lines_of(path)) > LONGEST])

    def test_links(self):
        offences, found = [], 0
        for path in DOCUMENTS:
            for number, line in enumerate(lines_of(path), 1):
                for target in LINK.findall(line):
                    if target.startswith(("http:", "https:", "#")):
                        continue
                    found += 1
                    if not (path.parent / target.split("#")[0]).exists():
                        offences.append(f"{place(path, number)} links to {target}, which is not there")
        assert found > 30
        self.none(offences)

    def test_named_files(self):
        self.none([f"{place(path, number)} names {name}, which is not there" for path in DOCUMENTS
                   for number, line in enumerate(lines_of(path), 1) for name in NAMED.findall(line)
                   # a name with a colon is the title of a file that the page contains (test_extension_pages.py)
                   if line != f"`{name}`:" and not (ROOT / name).exists()])

    def test_every_document_is_linked(self):
        linked = {(path.parent / target.split("#")[0]).resolve() for path in DOCUMENTS
                  for target in LINK.findall(path.read_text(encoding="utf-8"))}
        self.none([f"{place(path, 1)} is linked from nowhere" for path in DOCUMENTS
                   if path.parts[len(ROOT.parts)] in ("doc", "input") and path.resolve() not in linked])

    def test_letters_with_other_meanings(self):
        """Would catch a page whose letters differ from those that the page of symbols names, and the reverse."""
        pages = {path.name: path.read_text(encoding="utf-8") for path in (ROOT / "doc/theory").glob("*.md")}
        rows = dict(re.findall(r"^\| \[.*?\]\((\w+\.md)\) \| (.*) \|$", pages["symbols.md"], re.M))
        here = {name: found[1] for name, text in pages.items()
                if (found := re.search(r"^\*Here\* (.*?) \(\[Symbols\]\(symbols\.md\)\)\.$", text, re.M))}
        assert len(here) > 10 and rows == here

    def test_shapes_are_listed(self, options):
        """Would catch a shape that a deck accepts and `--list` does not show."""
        said = scree(options, "--explain", "region.shape")[1]
        assert f"one of: {scree(options, '--list', 'shapes')[1].strip()}\n" in said

    def test_keys(self, options):
        script = ROOT / "scripts" / "document_keys.py"
        answer = subprocess.run([sys.executable, script, options.scree, "--check"], capture_output=True, text=True)
        assert answer.returncode == 0, answer.stdout + answer.stderr

    def test_fields(self, options):
        code, text = scree(options, "--list", "fields")
        assert code == 0, text
        names, lines = text.split("\n")[0].split(), dict(re.findall(r"^(\w+): (.*)$", text, re.M))
        own = first_cells(ROOT / "doc/reference/keys.md", "Fields of single models")
        assert own and first_cells(OUTPUT, "Snapshots") == [name for name in names if name not in own]
        assert set(own) <= set(names)
        profile = first_cells(MATTER_OUTPUTS, "Profiles")
        assert profile == lines["profile"].split()
        history = sum((first_cells(OUTPUT, part) for part in ("History", "Errors against", "Columns by name")), [])
        assert sorted(history) == sorted(lines["history"].split())

    def test_columns(self, options):
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
            code, text = scree(options, SCENE, "--quiet", "--set", "time.max_steps=1", "--outdir", folder)
            assert code == 0, text
            heading = lines_of(Path(folder) / "two_discs_history.csv")[0]
        columns = [column.split(" [")[0] for column in heading.split(",")]
        assert sorted(first_cells(OUTPUT, "History")) == sorted(columns)

    def test_printed_check(self, options):
        code, text = scree(options, "--check", SCENE)
        assert code == 0, text
        command = f"$ build/bin/scree --check {SCENE}\n"
        shown = [block for block in blocks(FIRST_STEPS, "console") if block.startswith(command)]
        # the time that it takes depends on the machine
        said, told = (re.sub(r"estimate .*", "estimate", words) for words in
                      (command + text, shown[0]))
        assert said == told

    def test_printed_faults(self, options):
        deck = next(block for block in blocks(DECK, "fortran") if "dimention" in block)
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
            (Path(folder) / "bad.nml").write_text(deck, encoding="utf-8")
            code, text = scree(options, "--check", "bad.nml", folder=folder)
        assert code == 2, text
        assert "$ build/bin/scree --check bad.nml\n" + text in blocks(DECK, "console")

    def test_printed_job(self, options):
        shown = next(block for block in blocks(RUNNING, "console") if "--job slurm" in block)
        command, script = shown.split("\n", 1)
        code, text = scree(options, *command.split()[2:])
        assert code == 0, text
        # the output shows the absolute path of the program, which differs between machines
        assert text.replace(f"srun {shlex.quote(str(options.scree))} ", "srun build/bin/scree ") == script

    def test_printed_examples(self, options):
        shown = next(block for block in blocks(RUNNING, "console") if "--list examples" in block)
        first, *said, last = shown.strip().split("\n")
        code, text = scree(options, *first.split()[2:])
        assert code == 0, text
        assert len(said) > 3
        self.none([f"not listed: {line}" for line in said if line != "..." and line not in text.split("\n")])
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
            code, text = scree(options, *last.split()[2:], folder=folder)
            assert code == 0, text
            assert (Path(folder) / "my_discs/two_discs.nml").is_file()

    def test_shown_streams(self, options):
        shown = blocks(MATTER_OUTPUTS, "fortran")[0]
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
            scene = (ROOT / "input/debris_cloud/scene.nml").read_text(encoding="utf-8")
            (Path(folder) / "scene.nml").write_text(scene + shown, encoding="utf-8")
            code, text = scree(options, "scene.nml", "--quiet", "--set", "time.max_steps=0", "--outdir", ".",
                               folder=folder)
            assert code == 0, text
            with open(Path(folder) / "debris_cloud_fragments.csv", encoding="utf-8") as lines:
                columns = [column.split(" [")[0] for column in lines.readline().strip().split(",")]
            written = {path.name for path in Path(folder).iterdir()}
        told = " ".join(first_cells(MATTER_OUTPUTS, "Fragments"))
        self.none([f"{MATTER_OUTPUTS.name} does not name {column}" for column in columns
                   if column not in told and not column.startswith(("lower_", "upper_"))])
        self.none([f"there is no {name}" for name in ("debris_cloud_g.hdf.series", "debris_cloud_profile.csv",
                                                      "debris_cloud_tip_p.hdf.series") if name not in written])

    def test_shown_deck(self):
        scene = (ROOT / SCENE).read_text(encoding="utf-8")
        lines = {re.sub(r"\s*!.*", "", line) for line in scene.split("\n")}
        shown = [line for block in blocks(FIRST_STEPS, "fortran") for line in block.strip().split("\n")]
        assert len(shown) > 20
        self.none([f"{SCENE} does not hold: {line}" for line in shown if line not in lines])
