# SPDX-License-Identifier: BSD-3-Clause
"""scree --point: one material along a path, against an integration of the same equations here.

Would catch: a deck for a point that needs a scene, a preset that does not reach the law, a file that is not that of the
path, JH-2 with a wrong constant, voids that require work.
"""
# tiers: smoke

import subprocess

import numpy as np

HUGONIOT = """
&material  name='al'  preset='al_2024_t351' /
&point  path='hugoniot'  speed=3000  steps=12 /
"""
GLASS = """
&units  system='mm-us-mg' /
&effects  damage=.true. /
&material  name='g'  preset='glass_soda_lime' /
&point  path='uniaxial_strain'  strain=-0.25  rate=0.1  steps=5000 /
"""
SAND = """
&effects  voids=.true. /
&material  name='s'  preset='sand_dry' /
&point  path='hydrostatic'  strain=0.3  steps=300  returns=.true. /
"""


def drive(options, name, deck, *more):
    """Run a deck for a point; its table by column."""
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "path.nml").write_text(deck, encoding="ascii")
    done = subprocess.run([options.scree, "--point", "path.nml", *more], cwd=folder, text=True,
                          capture_output=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"{name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return np.genfromtxt(folder / "out" / "path" / "path_point.csv", delimiter=",", names=True)


def glass(strain, steps, rate):
    """JH-2 in uniaxial strain: longitudinal stress, damage, pressure of bulking."""
    k1, k2, k3, g = 45.4e9, -138.0e9, 290.0e9, 30.4e9
    unit = 1.5 * (5.95e9 - 2.92e9)
    factor = 1.0 + 0.003 * np.log(2.0 / 3.0 * rate)
    step, volume, s, damage, gain = strain / steps, 1.0, 0.0, 0.0, 0.0

    def strength(p, d):
        return unit * ((1.0 - d) * 0.93 * ((p + 0.15e9) / 2.92e9) ** 0.77 * factor
                       + d * min(0.5, 0.088 * (p / 2.92e9) ** 0.35 * factor))

    for _ in range(steps):
        volume *= np.exp(step)
        mu = 1.0 / volume - 1.0
        p = k1 * mu + k2 * mu**2 + k3 * mu**3 + gain
        s += 4.0 / 3.0 * g * step
        limit = strength(p, damage)
        if 1.5 * abs(s) > limit:
            plastic = (1.5 * abs(s) - limit) / (3.0 * g)
            s *= limit / (1.5 * abs(s))
            old, damage = damage, min(1.0, damage + plastic / (0.053 * ((p + 0.15e9) / 2.92e9) ** 0.85))
            lost = (strength(p, old) ** 2 - strength(p, damage) ** 2) / (6.0 * g)
            more = -k1 * mu + np.sqrt((k1 * mu + gain) ** 2 + 2.0 * k1 * lost) - gain
            gain, p = gain + more, p + more
    return s - p, damage, gain


def test_point(options, sheet):
    """Three paths."""
    shock = drive(options, "hugoniot", HUGONIOT)
    sheet.near("shock speed at 1 km/s", shock["shock_speed"][3], 6666.0, 1.0e-6)
    sheet.near("pressure at 1 km/s", shock["pressure"][3], 18.565e9, 1.0e-4)
    sheet.near("pressure at 3 km/s", shock["pressure"][11], 78.052e9, 1.0e-4)

    path = drive(options, "glass", GLASS)
    stress, damage, gain = glass(-0.25, 5000, 1.0e5)
    print(f"glass: stress {path['xx'][-1] / 1e9:.6f} GPa, by hand {stress / 1e9:.6f}; bulking {gain / 1e9:.3f} GPa")
    sheet.near("stress of glass", path["xx"][-1], stress, 1.0e-8)
    sheet.require(damage == 1.0 and path["failed"][-1] == 1.0, "the glass fractures")
    sheet.require(set(np.unique(path["failed"])) == {0.0, 1.0}, "flags are 0 or 1")

    sand = drive(options, "sand", SAND)
    sheet.require((sand["pressure"][: 300 + 100] == 0.0).all(), "open sand bears nothing")
    sheet.near("packing when open", sand["solid_fraction"][300], 0.634 * np.exp(-0.3), 1.0e-9)
    closed = 0.58 * 117.0e6 * (0.634 / 0.58 - 1.0)
    sheet.near("pressure of sand pressed again", sand["pressure"][-1], closed, 1.0e-6)
