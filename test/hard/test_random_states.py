# SPDX-License-Identifier: BSD-3-Clause
"""A million random states of every law, and of every compatible combination of models.

The unit tests of the catalogue with more states; they state what they would catch: NaN, energy created by flow, a sound
speed that is not real, and stress outside of the yield surface.
"""
# tiers: long
# timeout: 3000

import os
import subprocess

import pytest


@pytest.mark.parametrize("name", ["test_material_catalogue", "test_material_random"])
def test_random_states(options, name):
    """A missing program has not been built."""
    build = options.scree.parents[1]
    # a program of the whole folder, or with pFUnit one of each file
    found = [[file, *words] for program, words in (("unit_material", [name]), (name, []))
             for file in (build / "test" / "unit").rglob(program) if file.is_file()]
    assert found, f"unit_material is not in {build}/test/unit; build the tests first"
    states = os.environ.get("SCREE_STATES", "1000000")
    answer = subprocess.run(found[0], env={**os.environ, "SCREE_STATES": states}, text=True,
                            capture_output=True, check=False)
    print(answer.stdout, answer.stderr, sep="")
    assert answer.returncode == 0
    assert "0 failed" in answer.stdout
