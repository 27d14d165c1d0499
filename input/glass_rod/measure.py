# SPDX-License-Identifier: BSD-3-Clause
"""Failure fronts in glass rods against impact stress.

    python input/glass_rod/measure.py --scree build/bin/scree
"""
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / folder) for folder in ("scripts", "python/src")]
import scree_post                      # noqa: E402
from scree.drawing import look     # noqa: E402
from scree_post import panel     # noqa: E402
from scree_scene import Study, Table   # noqa: E402

#: Title, density [kg/m3], speeds of longitudinal and shear waves [m/s].
GLASS = {"soda": ("soda-lime", 2530.0, 5828.0, 3466.0),
         "surface": ("borosilicate, flaws of its surface", 2230.0, 5647.0, 3458.0),
         "inside": ("borosilicate, strength of its inside", 2230.0, 5647.0, 3458.0),
         "constant": ("borosilicate, 0.3 us to failure", 2230.0, 5647.0, 3458.0),
         "slow": ("borosilicate, time to failure by load", 2230.0, 5647.0, 3458.0),
         "slowsoda": ("soda-lime, time to failure by load", 2530.0, 5828.0, 3466.0)}
COLOURS = {"soda": "#0072b2", "surface": "#e69f00", "inside": "#d55e00", "constant": "#777777", "slow": "#009e73",
           "slowsoda": "#cc79a7"}
#: Failure that takes 0.3 us at twice the strength and the less the greater the load; the moduli of soda-lime glass.
SLOW = {"material.preset": "glass_borosilicate", "material.failure_stress": 0.6, "material.failure_shear": 0.7,
        "material.failure_delay": 0.3, "material.failure_delay_power": 2}
#: What --set adds to the deck.
VALUES = {"soda": {}, "surface": {"material.preset": "glass_borosilicate"},
          "inside": {"material.preset": "glass_borosilicate", "material.failure_stress": 0.6,
                     "material.failure_shear": 1.0},
          "constant": {**SLOW, "material.failure_delay_power": 0},
          "slow": SLOW,
          "slowsoda": {**SLOW, "material.density": 2.53, "material.bulk": 45.4, "material.shear": 30.4}}
STRESS = (1.0, 1.5, 2.0, 3.0, 4.0)     # at first contact, rho c v / 2 [GPa]
LAYER = 5.0e-4                         # height of the layers in which failed particles are counted [m]


def speed(glass, stress):
    """Speed of approach that makes a stress [m/s]."""
    _, density, longitudinal, _ = GLASS[glass]
    return 2.0 * stress * 1.0e9 / (density * longitudinal)


def front(snap):
    """Highest layer in which a tenth of the particles has failed, none above it being so [m]."""
    layer = (snap.points[:, 2] / LAYER).astype(int)
    whole = np.bincount(layer)
    failed = np.bincount(layer, weights=snap.fields["failed"], minlength=len(whole))
    broken = np.nonzero(failed > 0.1 * np.maximum(whole, 1))[0]
    return (broken.max() + 1) * LAYER if len(broken) else 0.0


def fronts(run):
    """Times [s] and places [m] of the front."""
    frames = [scree_post.snapshot(file, ("failed",)) for _, file in run.series]
    return np.array([snap.time for snap in frames]), np.array([front(snap) for snap in frames])


def front_speed(run):
    """Slope of the front while it is between one and four diameters from the impact [m/s]."""
    times, places = fronts(run)
    chosen = (places > 0.010) & (places < 0.040)
    return np.polyfit(times[chosen], places[chosen], 1)[0] if chosen.sum() > 3 else 0.0


def speed_in_glass(run, name):
    """Speed of the front in the glass ahead of it, which comes with half the speed of approach [m/s]."""
    glass, stress = name.split("_")
    found = front_speed(run)
    return found + 0.5 * speed(glass, float(stress)) if found > 0.0 else 0.0


def table(runs):
    """Speed of the front by stress, and what is kept."""
    result = Table(["glass", "stress [GPa]", "approach [m/s]", "front [m/s]", "in the glass [m/s]", "over shear wave",
                    "over longitudinal wave", "farthest [mm]", "failed at the end", "fastest radially [m/s]"])
    for name, run in runs.items():
        glass, stress = name.split("_")
        title, _, longitudinal, shear = GLASS[glass]
        found, last, inside = front_speed(run), run.last_snapshot(), speed_in_glass(run, name)
        result.rows.append([title, stress, f"{speed(glass, float(stress)):.0f}",
                            f"{found:.0f}" if inside else "no front", f"{inside:.0f}" if inside else "no front",
                            f"{inside / shear:.2f}", f"{inside / longitudinal:.2f}",
                            f"{1e3 * fronts(run)[1].max():.1f}",
                            f"{last.fields['failed'].mean():.2f}",
                            f"{last.fields['velocity'][:, 0].max():.0f}"])
    return result


def tables(runs):
    """Glass that takes time to fail, and glass that takes none."""
    takes_time = {name: "material.failure_delay" in VALUES[name.split("_")[0]] for name in runs}
    return [table({name: run for name, run in runs.items() if takes_time[name] is wanted}) for wanted in (True, False)]


def draw(runs, plot):
    """Rods at three times, and the speed of the front by stress."""
    figure, panels = plot.subplots(1, 4, figsize=(10.5, 5.0), width_ratios=(1, 1, 1, 2.6), layout="constrained")
    run = runs["soda_4.0"]
    for axes, moment in zip(panels, (3.0e-6, 6.0e-6, 9.0e-6)):
        snap = run.near(moment)
        broken = snap.fields["failed"] > 0.5
        panel.particles(axes, snap, "#b8d4e8", rows=~broken, sides=(-1, 1))
        shown = panel.particles(axes, snap, snap.fields["velocity"][:, 0], low=0.0, high=500.0, colours=look.HEAT,
                                rows=broken, sides=(-1, 1))
        panel.window(axes, (-12, 12, 0, 62), "r [mm]", title=f"{1e6 * snap.time:.0f} µs")
    panels[0].set_ylabel("z [mm]")
    figure.colorbar(shown, ax=panels[:3], label="radial speed of failed glass [m/s]", location="bottom", shrink=0.7)
    for glass, (title, _, longitudinal, shear) in GLASS.items():
        colour = COLOURS[glass]
        names = [name for name in runs if name.startswith(f"{glass}_")]
        panels[3].plot([float(name.split("_")[1]) for name in names],
                       [1e-3 * speed_in_glass(runs[name], name) for name in names], "o-", color=colour, label=title)
        for wave, style in ((longitudinal, "--"), (shear, ":")):
            panels[3].axhline(1e-3 * wave, color=colour, ls=style, lw=0.8)
    panels[3].errorbar([4.0, 4.05], [4.7, 4.6], yerr=0.5, fmt="ks", ms=4, capsize=3, label="measured")
    panels[3].set(xlabel="stress at first contact [GPa]", ylabel="failure front in the glass [km/s]", ylim=(0, 6.2))
    panels[3].legend(loc="lower right", fontsize=8)
    return figure


def draw_fronts(runs, plot):
    """Where glass that takes time to fail has failed, by stress."""
    figure, panels = plot.subplots(1, 8, figsize=(9.6, 5.0), layout="constrained", sharey=True)
    for axes, (stress, moment) in zip(panels, ((stress, moment) for stress in STRESS[1:]
                                                for moment in (4.0e-6, 8.0e-6))):
        snap = runs[f"slow_{stress}"].near(moment)
        broken = snap.fields["failed"] > 0.5
        for chosen, colour in ((~broken, "#b8d4e8"), (broken, "#333333")):
            panel.particles(axes, snap, colour, rows=chosen, sides=(-1, 1))
        panel.window(axes, (-7, 7, 0, 60), "r [mm]", title=f"{stress:g} GPa\n{1e6 * snap.time:.0f} µs")
    panels[0].set_ylabel("z [mm]")
    return figure


def numbers(runs):
    """What the README says beside its table."""
    def inside(glass, stress):
        return f"{1e-3 * speed_in_glass(runs[f'{glass}_{stress:.1f}'], f'{glass}_{stress:.1f}'):.1f}"

    def reach(glass):
        return f"{1e3 * fronts(runs[f'{glass}_1.5'])[1].max():.0f}"
    return {"soda_lime_4": inside("slowsoda", 4), "borosilicate_4": inside("slow", 4),
            "reach_borosilicate": reach("slow"), "reach_soda_lime": reach("slowsoda"),
            "borosilicate_2": inside("slow", 2), "borosilicate_3": inside("slow", 3), "jh2": inside("soda", 4),
            "surface": inside("surface", 4), "constant": inside("constant", 4)}


def case(glass, stress):
    """Deck and values of a run: half of the speed of approach, the mirror plane does the rest."""
    return "scene.nml", {"body.velocity": f"0,0,{-0.5e-3 * speed(glass, stress):.6f}", **VALUES[glass]}


CASES = {f"{glass}_{stress}": case(glass, stress) for glass in GLASS for stress in STRESS}

if __name__ == "__main__":
    Study(__file__, CASES, tables, {"picture.png": draw, "fronts.png": draw_fronts}, numbers={"README.md": numbers},
          as_it_stands="soda_4.0").main()
