#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Renew the digests of the self-test in src/program/self_test/digests.csv.

    scripts/self_test_digests.py [--scree build/bin/scree] [--check]

The rows of the kind of this build (processor family and generation of the compiler) are replaced, those of other kinds
are kept. Renew them after a change that is meant to change results, with each compiler whose rows the file has: the
rows of other kinds are then out of date, and the script says so. Build the program again afterwards.

--check changes nothing; the exit code is 1 if the file has other digests.
"""

import argparse
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
FILE = ROOT / "src/program/self_test/digests.csv"
HEAD = "# kind of build,scene,digest at the end; written by scripts/self_test_digests.py\n"
KIND = re.compile(r"^self-test scree [^,]+, ([^,]+), ", re.M)
ROW = re.compile(r"^ *(\w+) +\d+ +\d+ +([0-9a-f]{16}) ", re.M)


def digests_of(scree):
    """Kind of a build, and digest of each scene. A difference from the recorded digests is not a failure here."""
    answer = subprocess.run([scree, "--self-test"], text=True, capture_output=True, check=False, timeout=600)
    kind, rows = KIND.search(answer.stdout), dict(ROW.findall(answer.stdout))
    if answer.returncode not in (0, 5) or not kind or not rows:
        sys.exit(f"{scree} --self-test: exit code {answer.returncode}\n{answer.stdout}{answer.stderr}")
    wrong = [line for line in answer.stderr.splitlines() if line.startswith("  ") and "recorded" not in line]
    if wrong:
        sys.exit("checks of other kinds failed, so these digests are not recorded:\n" + "\n".join(wrong))
    return kind.group(1), rows


def recorded():
    """Rows of the file: digest by kind and scene."""
    lines = [line.split(",") for line in FILE.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return {(kind, scene): digest for kind, scene, digest in lines}


def main():
    """Renew or check."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--scree", default=str(ROOT / "build/bin/scree"), help="the program; default build/bin/scree")
    parser.add_argument("--check", action="store_true", help="change nothing, exit code 1 if digests differ")
    given = parser.parse_args()
    kind, rows = digests_of(given.scree)
    old = recorded()
    new = {key: digest for key, digest in old.items() if key[0] != kind}
    new.update({(kind, scene): digest for scene, digest in rows.items()})
    if new == old:
        print(f"the digests of {kind} are up to date")
        return
    if given.check:
        sys.exit(f"{FILE.relative_to(ROOT)} has other digests for {kind}; run scripts/self_test_digests.py")
    FILE.write_text(HEAD + "".join(f"{kind},{scene},{digest}\n" for (kind, scene), digest in sorted(new.items())),
                    encoding="utf-8")
    print(f"{len(rows)} digests of {kind} written; build again")
    others = sorted({other for other, _ in new if other != kind})
    if others:
        print(f"renew these too, each with a program of its kind: {', '.join(others)}")


if __name__ == "__main__":
    main()
