# SPDX-License-Identifier: BSD-3-Clause
"""An elastic disc, five cells on its radius, spins freely for twenty turns with every transfer.

Would catch: a transfer that takes or makes angular momentum turn by turn, a disc that grows or fades, stress that is
left behind by the rotation.

The disc of test_spin.py. Judged are what the default and the affine transfers do to the angular momentum in a turn, to
the radius of gyration in all turns, and the stress at the end against the closed solution; the rest is shown.
"""
# label: long
# timeout: 3000

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402

TURNS = 20
TRANSFERS = {
    "ddmp": ("ddmp", ""), "ddmp rflip 1": ("ddmp", "transfer='rflip' flip=1"),
    "ddmp flip 1": ("ddmp", "transfer='flip' flip=1"), "ddmp flip": ("ddmp", "transfer='flip'"),
    "ddmp apic": ("ddmp", "transfer='apic'"), "ddmp aflip": ("ddmp", "transfer='aflip'"),
    "ddmp xpic": ("ddmp", "transfer='xpic'"),
    "mpm flip 1": ("mpm", "transfer='flip' flip=1"), "mpm flip": ("mpm", "transfer='flip'"),
    "mpm rflip": ("mpm", "transfer='rflip'"), "mpm apic": ("mpm", "transfer='apic'"),
    "mpm aflip": ("mpm", "transfer='aflip'"), "mpm xpic": ("mpm", "transfer='xpic'"),
}


def radius(snap):
    """Radius of gyration."""
    return float(np.sqrt((snap.points[:, [0, 2]] ** 2).sum(axis=1).mean()))


def main():
    """A table, and limits for some of its lines."""
    options = case.arguments()
    options.timeout = 1000
    sheet = report.Report()
    for name, (method, words) in TRANSFERS.items():
        result = bodies.spin(options, name.replace(" ", "_"), method, words, spacing=0.2, turns=TURNS)
        if result["code"]:
            sheet.note(f"{name}: exit code", result["code"])
            continue
        snaps = result["run"].snapshots()
        growth = radius(snaps[-1][1]) / radius(snaps[0][1]) - 1.0
        sheet.note(f"{name}: angular momentum a turn, energy a turn, radius in {TURNS} turns, stress",
                   " ".join(f"{value:+.1e}" for value in
                            (result["drift"], result["energy"], growth, result["stress"])))
        if name in ("ddmp", "ddmp apic", "ddmp aflip"):
            sheet.below(f"{name}: angular momentum a turn", result["drift"], 2.5e-3)
            sheet.below(f"{name}: radius", growth, 5.0e-3)
    sheet.end()


if __name__ == "__main__":
    main()
