# SPDX-License-Identifier: BSD-3-Clause
"""Grains between two faces that move along themselves: the stress as the shear begins.

Would catch: a Jaumann rate with the wrong sign or without the normal stresses, relaxation of a part of the
stress only, faces with a velocity that do not drag or that push, periodic faces that lose stress.

D. Z. Zhang, R. M. Rauenzahn, J. Rheol. 41 (1997) 1275, with constant relaxation: rate g = 2 /s, G = 3 Pa,
from rest. With W = g tau and A = G W/(1 + W2):
  s_xz = A [1 - exp(-t/tau) (cos gt - W sin gt)],  s_xx = A [W - exp(-t/tau) (W cos gt + sin gt)],
so at 1.3 s and tau = 0.7 s 1.7686065 and 2.1380370 Pa. Errors are root mean squares over all particles, the
greatest of 26 times, over G/2, the greatest stress that such a flow bears.

Two ways to begin: `started` gives every layer its speed, so the flow is uniform and the formula holds to
round-off (limit 1e-12); `driven` has grains at rest and moving faces, and waves between the faces that the
formula does not know. They fade with the density: limits 1 % with 5e-4 kg/m3. The mean stress of all particles
is then right to 1e-3. Here tau = 0.35 s: above W = 1 the law has less stress for more shear, so that flows that
are not quite uniform may split into bands. Shown beside it: with GIMP or splines, flip and `musl` or `usf`, noise
grows (17 to 22 %), with `usl` or apic it does not.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "support"))
import bodies  # noqa: E402
import case    # noqa: E402
import report  # noqa: E402


def flow(options, name, *words, **more):
    """One flow, shown."""
    result = bodies.shear(options, name, *words, **more)
    print(f"         {name}: " + (", ".join(f"{key} {result[key]:.2e}" for key in ("across", "along", "mean"))
          + f", {result['steps']} steps" if not result["code"] else f"exit code {result['code']}"), flush=True)
    return result


def main():
    """Both beginnings; another method beside them."""
    options = case.arguments()
    sheet = report.Report()
    exact = bodies.shear_stress(1.3, 0.7)
    sheet.near("formula: shear stress [Pa]", exact[0], 1.7686065, 1.0e-7)
    sheet.near("formula: normal stress [Pa]", exact[1], 2.1380370, 1.0e-7)
    started = flow(options, "started", started=True, density=0.1, relaxation=0.7)
    driven = flow(options, "driven", density=5.0e-4)
    flow(options, "mpm", "mpm", density=5.0e-4)
    for update in ("musl", "usl"):
        flow(options, f"gimp_{update}", "mpm", f"basis='gimp' stress_update='{update}'", density=5.0e-4)
    for name, result, limit in (("started", started, 1.0e-12), ("driven", driven, 0.01)):
        sheet.require(len(result["curve"]) == 27, f"{name}: all times are there")
        sheet.above(f"{name}: shear stress at the end [Pa]", result["curve"][-1, 1], 1.4)
        sheet.below(f"{name}: shear stress", result["across"], limit)
        sheet.below(f"{name}: normal stress", result["along"], limit)
    sheet.below("driven: mean stress", driven["mean"], 1.0e-3)
    sheet.end()


if __name__ == "__main__":
    main()
