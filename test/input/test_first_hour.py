# SPDX-License-Identifier: BSD-3-Clause
# timeout: 900
# cores: 2
"""The commands of the page "first hour" are run one after another, as a new user would.

Would catch a command that does not work after the preceding ones, one that ends with another exit code than the page
says, a picture that is not made, and a restart that does not find the checkpoint of the interrupted run.
"""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import case

PAGE = case.ROOT / "doc/learn/first_hour.md"
PICTURES = ("my_column/energies.png", "my_column/pressure.png", "my_column/column.gif", "my_column/both.png",
            "my_column/out/column_collapse/column_collapse.png", "my_column/out/column_collapse_sweep/sweep.png",
            "my_cloud/cloud.png")
CODE = re.compile(r"\s+# exit code (\d+)$")
MARK = "### "


def commands():
    """Title of the section, command and exit code of all commands."""
    found, title = [], ""
    for part in re.split(r"^## (.*)$", PAGE.read_text(encoding="utf-8"), flags=re.M)[1:]:
        if "\n" not in part:
            title = part
        for block in re.findall(r"^```console\n(.*?)^```", part, re.M | re.S):
            for line in block.splitlines():
                assert line.startswith("$ "), line
                code = CODE.search(line)
                found.append((title, CODE.sub("", line[2:]), int(code[1]) if code else 0))
    return found


def script(typed):
    """The same as one shell script, which prints the exit code and the time after each command."""
    lines = ["export PATH"]
    for number, (_, words, _) in enumerate(typed):
        lines += [words, f'echo "{MARK}{number} $? ${{SECONDS}}"']
    return "\n".join(lines) + "\n"


def test_first_hour(options, sheet):
    """Run the commands, compare the exit codes, check that the pictures exist, print the time of each section."""
    # the page starts in the root of the repository; its first command adds the programs to the search path
    typed = [entry for entry in commands() if not entry[1].startswith("export PATH=")]
    sheet.require(len(typed) >= 20, f"only {len(typed)} commands were found")
    folder = options.work / "home"
    shutil.rmtree(folder, ignore_errors=True)
    names = folder / "bin"
    names.mkdir(parents=True)
    (names / "scree-post").write_text(
        f'#!/bin/sh\nexport PYTHONPATH="{case.ROOT}/python/src" SCREE="{options.scree}"\n'
        f'exec "{sys.executable}" -m scree_post "$@"\n', encoding="utf-8")
    (names / "scree-post").chmod(0o755)
    places = (options.scree.parent, names, Path(sys.executable).parent)
    path = os.pathsep.join([*map(str, places), os.environ["PATH"]])
    # a page that waits for something that never happens must end too
    answer = subprocess.run(["timeout", "850", "bash", "-c", script(typed)], cwd=folder, text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, **case.OPEN_MPI, "PATH": path})
    found = dict(re.findall(rf"^{MARK}(\d+) (\d+ \d+)$", answer.stdout, re.M))
    clock = {}
    for number, (title, words, wanted) in enumerate(typed):
        code, seconds = map(int, found.get(str(number), "-1 0").split())
        sheet.require(code == wanted, f"{words}: exit code {code}, the page says {wanted}")
        clock[title] = seconds
    begin = 0
    for title, end in clock.items():
        print(f"{end - begin:5d} s  {title}")
        begin = end
    for name in PICTURES:
        picture = folder / name
        sheet.require(picture.is_file() and picture.stat().st_size > 1000, f"picture {name}")
    if sheet.missed:
        print(answer.stdout[-6000:])
