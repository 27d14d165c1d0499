# SPDX-License-Identifier: BSD-3-Clause
"""Selects the parts of a test to run: the tier in SCREE_TIER, which CTest sets from the line `# tiers:` of the test.

    import tier
    cells = tier.choose(smoke=(16, 32), full=(16, 32, 64, 128))
    if tier.NAME != "smoke":
        ...

smoke: a few seconds that execute the same code; full: all verification that is done by default; long: studies of many
minutes. Without SCREE_TIER a test runs in full.
"""

import os

TIERS = ("smoke", "full", "long")
NAME = os.environ.get("SCREE_TIER", "full")
if NAME not in TIERS:
    raise SystemExit(f"SCREE_TIER={NAME} is none of: {', '.join(TIERS)}")


def choose(full, smoke=None, long=None):
    """The value for this tier; `smoke` and `long` default to `full`."""
    value = {"smoke": smoke, "full": full, "long": long}[NAME]
    return full if value is None else value
