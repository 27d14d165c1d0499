# SPDX-License-Identifier: BSD-3-Clause
"""A million random states of every law, and of every combination of models that go together.

The unit tests of the catalogue with more states; they say what they would catch: numbers that are
none, energy that flow makes, sound that is not real, and stress outside of the yield surface.
"""
# tiers: long
# timeout: 3000

import os
import subprocess
import sys
from pathlib import Path

if "--scree" not in sys.argv:
    sys.exit("usage: test_random_states.py --scree BUILD/bin/scree")
BUILD = Path(sys.argv[sys.argv.index("--scree") + 1]).resolve().parents[1]


def main():
    """Both programs; a missing one has not been built."""
    failed = 0
    for name in ("test_material_catalogue", "test_material_random"):
        found = [file for file in (BUILD / "test" / "unit").rglob(name) if file.is_file()]
        if len(found) != 1:
            sys.exit(f"{name} is not in {BUILD}/test/unit; build the tests first")
        states = os.environ.get("SCREE_STATES", "1000000")
        answer = subprocess.run([found[0]], env={**os.environ, "SCREE_STATES": states}, text=True,
                                capture_output=True, check=False)
        print(answer.stdout, answer.stderr, sep="")
        failed += answer.returncode != 0 or "0 failed" not in answer.stdout
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
