# SPDX-License-Identifier: BSD-3-Clause
"""Random effects and random valid materials of every law, equation of state and model of failure.

    effects = materials.draw_effects(chance, "shock")
    matter = materials.draw(chance, "metal", effects, dx)

Families: metal, brittle, soft, porous (solids that support a shear stress), grains, liquid, gas. Constants are those of
real materials, changed by at most a factor of 2, so a failure cannot be due to unrealistic constants.
"""

import dataclasses
import math

from chance import short

PRESETS = {
    # density, bulk sound speed, shear modulus, family
    "al_2024_t351": (2785.0, 5328.0, 28.6e9, "metal"), "al_2017_t4": (2790.0, 5328.0, 27.2e9, "metal"),
    "al_6061_t6": (2703.0, 5240.0, 27.6e9, "metal"), "cu_ofhc": (8930.0, 3940.0, 47.7e9, "metal"),
    "steel_4340": (7810.0, 4578.0, 80.0e9, "metal"), "lead": (11350.0, 2050.0, 7.887e9, "metal"),
    "glass_soda_lime": (2530.0, 4236.0, 30.4e9, "brittle"),
    "glass_borosilicate": (2230.0, 3992.0, 26.7e9, "brittle"),
    "sand_dry": (1674.0, 264.4, 76.9e6, "grains"), "glass_beads": (1470.0, 75.3, 3.85e6, "grains"),
}
WITH_ENERGY = ("mie_gruneisen", "ideal_gas", "tillotson", "p_alpha")
AMBIENT = 293.0


@dataclasses.dataclass
class Matter:
    """A material of a deck, with the properties that judge.py needs."""

    family: str
    keys: dict                        # of &material, without its name
    density: float                    # [kg/m3]
    bulk_speed: float                 # sqrt(K/rho) at rest, or at the start of a gas [m/s]
    wave_speed: float                 # fastest wave at rest, or at the start of a gas [m/s]
    model: str                        # law / equation of state / failure, for the table
    carries: bool = False             # carries its internal energy
    opens: bool = False               # may separate: its volume may grow without tension
    breaks: bool = False              # can fail
    melts: bool = False               # loses strength and tension at high temperature
    energy: float = 0.0               # internal energy per mass at the start [J/kg]
    heat: float = 0.0                 # specific heat, 0 without thermal effects [J/(kg K)]
    speed_limit: float = 0.0          # fastest impact for which its laws hold [m/s]
    gamma: float = 0.0                # of a gas


def draw_effects(chance, kind):
    """Switches of &effects. `kind` is shock, solid, loose, gas or liquid."""
    words = {}
    shock = kind == "shock"
    if kind in ("shock", "solid", "loose") and chance.true(0.5 if shock else 0.3):
        words["damage"] = True
        if chance.true(0.15):
            words["size_scatter"] = True
        if chance.true(0.1):
            words["erosion"] = True
    if chance.true(0.35 if shock else 0.12):
        words["thermal"] = True
        if chance.true(0.5):
            words["melting"] = True
    if kind in ("shock", "solid", "loose") and chance.true(0.1):
        words["voids"] = True
    if chance.true(0.08):
        words["rate"] = False
    if kind == "solid" and "damage" not in words and "voids" not in words and chance.true(0.08):
        words["eos"] = False
    if kind in ("shock", "liquid") and "damage" not in words and chance.true(0.06):
        words["strength"] = False
    if kind in ("solid", "loose", "liquid") and chance.true(0.08):
        words["artificial_viscosity"] = False
    return words


def draw(chance, family, effects, dx):
    """A material of a family that is valid with these effects and cells of dx [m]."""
    matter = FAMILIES[family](chance, effects)
    keys = matter.keys
    if effects.get("thermal"):
        matter.heat = keys.setdefault("specific_heat", chance.log(150.0, 1500.0))
        if "preset" not in keys and keys.get("strength_model") not in ("neo_hookean", "granular") and (
                effects.get("melting") or "jc_m" in keys):
            keys["t_melt"] = chance.uniform(600.0, 2000.0)
        matter.melts = bool(effects.get("melting"))
    if not effects.get("artificial_viscosity", True):
        matter.speed_limit = min(matter.speed_limit, 0.02 * matter.bulk_speed)     # no shocks
    if effects.get("damage"):
        fail(chance, matter, effects, dx)
    if effects.get("voids") and "p_alpha" not in matter.model and matter.family in ("grains", "brittle", "metal"):
        keys["alpha_m"] = chance.choose(["one", "open_when_failed", "crush"])
        if "preset" not in keys and matter.family == "grains":
            keys["solid_fraction"] = chance.uniform(0.55, 0.7)
            if chance.true(0.5):
                keys["b_shear"] = chance.uniform(0.0, 0.3)
    for key, value in keys.items():
        if isinstance(value, float):
            keys[key] = short(value)
    return matter


def moduli(chance, keys, bulk, shear):
    """Write the moduli as one of the two allowed pairs of keys."""
    if chance.true(0.5):
        keys.update(bulk=bulk, shear=shear)
    else:
        young = 9.0 * bulk * shear / (3.0 * bulk + shear)
        keys.update(young=young, poisson=young / (2.0 * shear) - 1.0)


def speeds(density, bulk, shear):
    """Bulk wave speed, and the greatest wave speed."""
    return math.sqrt(bulk / density), math.sqrt((bulk + 4.0 / 3.0 * shear) / density)


def preset(chance, effects, names):
    """A material of the library."""
    name = chance.choose(names)
    density, sound, shear, family = PRESETS[name]
    keys = {"preset": name}
    model = name
    eos = effects.get("eos", True)
    if not eos:
        bulk = density * sound ** 2
        keys.update(young=9.0 * bulk * shear / (3.0 * bulk + shear),
                    poisson=(3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear))
    elif family == "metal" and name in ("al_2024_t351", "al_6061_t6", "cu_ofhc") and effects.get(
            "strength", True) and chance.true(0.25):
        keys["strength_model"] = "steinberg_guinan"
        model += "/steinberg_guinan"
    if not effects.get("strength", True):
        shear = 0.0
    energetic = (family == "metal" and eos) or name == "glass_soda_lime"
    _, fast = speeds(density, density * sound ** 2, shear)
    limit = 15000.0 if family == "metal" and eos else 0.5 * sound
    if name == "glass_soda_lime":
        limit = 3000.0
    return Matter(family, keys, density, sound, fast, model, carries=energetic, opens=family == "grains",
                  breaks=bool(effects.get("damage")) and family != "grains" and name != "lead", speed_limit=limit)


def metal(chance, effects):
    """Ductile material: presets, or a random law and equation of state."""
    strong, eos = effects.get("strength", True), effects.get("eos", True)
    if chance.true(0.5):
        return preset(chance, effects, [name for name, row in PRESETS.items() if row[3] == "metal"])
    density, sound = chance.uniform(1800.0, 12000.0), chance.uniform(2000.0, 5500.0)
    bulk = density * sound ** 2
    shear = bulk * chance.uniform(0.2, 0.6)
    keys = {"density": density}
    model = chance.choose({"linear": 2, "mie_gruneisen": 5, "tillotson": 2}) if eos else "rate"
    if eos:
        keys["eos_model"] = model
    if model == "mie_gruneisen":
        keys.update(mg_c0=sound, mg_s=chance.uniform(1.2, 1.7), mg_gamma=chance.uniform(1.2, 2.2))
    elif model == "tillotson":
        vapour = chance.log(3.0e6, 1.5e7)
        keys.update(till_a=0.5, till_b=chance.uniform(1.0, 1.6), till_bulk=bulk,
                    till_square=bulk * chance.uniform(0.5, 1.0), till_alpha=5.0, till_beta=5.0,
                    till_e0=chance.log(5.0e6, 2.0e7), till_eiv=vapour * chance.uniform(0.15, 0.3), till_ecv=vapour)
    if strong:
        if model in ("linear", "rate"):
            moduli(chance, keys, bulk, shear)
        else:
            keys["shear"] = shear
    else:
        shear = 0.0
        if model == "linear":
            keys["bulk"] = bulk
    strength = bulk * chance.log(3.0e-4, 5.0e-3)
    law = chance.choose({"elastic": 1, "von_mises": 3, "johnson_cook": 3}) if strong else "none"
    if law == "von_mises":
        keys.update(strength_model=law, **{"yield": strength}, hardening=strength * chance.uniform(0.0, 2.0))
    elif law == "johnson_cook":
        keys.update(strength_model=law, jc_a=strength, jc_b=strength * chance.uniform(0.3, 2.0),
                    jc_n=chance.uniform(0.1, 0.6))
        if effects.get("rate", True):
            keys["jc_c"] = chance.uniform(0.0, 0.03)
        if effects.get("thermal"):
            keys["jc_m"] = chance.uniform(0.8, 1.3)
    if law != "elastic" and strong and chance.true(0.5):
        keys["spall"] = bulk * chance.log(5.0e-3, 3.0e-2)
    _, fast = speeds(density, bulk, shear)
    return Matter("metal", keys, density, sound, fast, f"{law}/{model}", carries=model in WITH_ENERGY,
                  opens="spall" in keys, speed_limit=15000.0 if model in WITH_ENERGY else 0.3 * sound)


def brittle(chance, effects):
    """Glass, ceramics, rock; failure is set by `fail`."""
    if chance.true(0.4):
        names = ["glass_borosilicate"]
        if effects.get("eos", True) and effects.get("strength", True):
            names.append("glass_soda_lime")
        if effects.get("strength", True):
            return preset(chance, effects, names)
    density, sound = chance.uniform(1800.0, 4000.0), chance.uniform(2500.0, 7000.0)
    bulk = density * sound ** 2
    shear = bulk * chance.uniform(0.4, 0.8)
    keys = {"density": density}
    strong, eos = effects.get("strength", True), effects.get("eos", True)
    law = chance.choose({"elastic": 3, "jh2": 2, "drucker_prager": 1}) if strong and eos else "elastic"
    model = chance.choose({"linear": 3, "mie_gruneisen": 1, "jh2": 1 if law != "drucker_prager" else 0})
    model = model if eos else "rate"
    if eos:
        keys["eos_model"] = model
    if model == "mie_gruneisen":
        keys.update(mg_c0=sound, mg_s=chance.uniform(1.2, 1.5), mg_gamma=chance.uniform(0.8, 1.5))
    elif model == "jh2":
        keys.update(jh2_k1=bulk, jh2_k2=bulk * chance.uniform(0.0, 1.0), jh2_k3=bulk * chance.uniform(0.5, 2.0))
    if not strong:
        law, shear = "none", 0.0
        if model == "linear":
            keys["bulk"] = bulk
    elif model in ("linear", "rate"):
        moduli(chance, keys, bulk, shear)
    else:
        keys["shear"] = shear
    if law == "jh2":
        limit = bulk * chance.uniform(0.05, 0.12)
        keys.update(strength_model=law, jh2_a=chance.uniform(0.8, 1.0), jh2_n=chance.uniform(0.5, 0.8),
                    jh2_b=chance.uniform(0.1, 0.4), jh2_m=chance.uniform(0.3, 1.0), jh2_t=limit * 0.03,
                    jh2_hel=limit, jh2_phel=limit * chance.uniform(0.4, 0.7))
        if effects.get("rate", True) and chance.true(0.5):
            keys["jh2_c"] = chance.uniform(0.0, 0.01)
    elif law == "drucker_prager":
        keys.update(strength_model=law, friction_angle=chance.uniform(25.0, 50.0),
                    cohesion=bulk * chance.log(3.0e-4, 3.0e-3))
    _, fast = speeds(density, bulk, shear)
    carries = model in WITH_ENERGY or law == "jh2"
    return Matter("brittle", keys, density, sound, fast, f"{law}/{model}", carries=carries,
                  opens=law in ("drucker_prager", "jh2", "none"), speed_limit=(0.5 if carries else 0.3) * sound)


def soft(chance, effects):
    """Rubber, gel, wax: soft and elastic, or flowing at a small stress."""
    density, bulk = chance.uniform(700.0, 2000.0), chance.log(1.0e4, 1.0e9)
    shear = bulk * chance.log(0.05, 1.2)
    strong, eos = effects.get("strength", True), effects.get("eos", True)
    keys = {"density": density}
    law = chance.choose({"neo_hookean": 4, "elastic": 3, "von_mises": 1}) if strong else "none"
    model = "whole" if law == "neo_hookean" else chance.choose({"linear": 3, "tait": 1}) if eos else "rate"
    if model == "tait":
        keys.update(eos_model=model, tait_n=chance.uniform(3.0, 7.0))
    if strong:
        if law != "elastic":
            keys["strength_model"] = law
        moduli(chance, keys, bulk, shear)
    else:
        keys["bulk"], shear = bulk, 0.0
    if law == "von_mises":
        keys["yield"] = shear * chance.uniform(0.02, 0.1)
    sound, fast = speeds(density, bulk, shear)
    return Matter("soft", keys, density, sound, fast, f"{law}/{model}", opens=law == "none",
                  speed_limit=0.3 * math.sqrt(shear / density) if strong else 0.3 * sound)


def porous(chance, effects):
    """Foam or a porous metal with p_alpha, which supports neither voids nor temperatures."""
    solid, sound = chance.uniform(2000.0, 9000.0), chance.uniform(2000.0, 5500.0)
    density = solid * chance.uniform(0.5, 0.95)
    crush = solid * sound ** 2 * chance.log(1.0e-3, 1.0e-2)
    shear = density * sound ** 2 * chance.uniform(0.2, 0.5)
    keys = {"density": density, "eos_model": "p_alpha", "mg_c0": sound, "mg_s": chance.uniform(1.2, 1.6),
            "mg_gamma": chance.uniform(1.0, 2.0), "pa_solid": solid, "pa_pe": crush * chance.uniform(0.05, 0.5),
            "pa_pc": crush}
    law = "none"
    if effects.get("strength", True):
        law = "von_mises"
        keys.update(shear=shear, strength_model=law, **{"yield": crush * chance.uniform(0.1, 1.0)})
    else:
        shear = 0.0
    _, fast = speeds(density, density * sound ** 2, shear)
    return Matter("porous", keys, density, sound, fast, f"{law}/p_alpha", carries=True, speed_limit=8000.0)


def grains(chance, effects):
    """Loose material: presets, or a random law with friction, stiff enough for its weight."""
    if chance.true(0.3):
        return preset(chance, effects, [name for name, row in PRESETS.items() if row[3] == "grains"])
    density, bulk = chance.uniform(1000.0, 2500.0), chance.log(1.0e5, 3.0e8)
    shear = bulk * chance.uniform(0.2, 0.7)
    law = chance.choose({"drucker_prager": 3, "mohr_coulomb": 2, "mu_i": 2, "granular": 2})
    keys = {"density": density, "strength_model": law}
    moduli(chance, keys, bulk, shear)
    friction, cohesion = chance.uniform(15.0, 45.0), bulk * chance.log(1.0e-4, 1.0e-2)
    if law in ("drucker_prager", "mohr_coulomb"):
        keys["friction_angle"] = friction
        if chance.true(0.4):
            keys["cohesion"] = cohesion
        if chance.true(0.2) and not effects.get("voids"):
            keys["dilation_angle"] = friction * chance.uniform(0.1, 0.9)
    if law == "drucker_prager":
        keys["dp_cone"] = chance.choose(["compression", "extension", "plane_strain"])
    elif law == "mu_i":
        slow = chance.uniform(0.2, 0.6)
        keys.update(mu_s=slow, mu_2=slow * chance.uniform(1.2, 2.0), mu_i0=chance.uniform(0.1, 0.5),
                    grain_diameter=chance.log(1.0e-4, 1.0e-2), grain_density=density / 0.6)
    elif law == "granular":
        if chance.true(0.6):
            keys["gr_gamma_c"] = chance.uniform(0.02, 0.5)
        if "gr_gamma_c" not in keys or chance.true(0.3):
            keys["gr_tau"] = chance.log(1.0e-6, 1.0e-2)
        if chance.true(0.3):
            keys["gr_mode"] = "total"
    sound, fast = speeds(density, bulk, shear)
    return Matter("grains", keys, density, sound, fast, f"{law}/linear", opens=True, speed_limit=0.3 * sound)


def liquid(chance, effects):
    """Water, oil, melt: tait or linear, with or without viscosity; its sound speed may be reduced, as is common."""
    density = chance.uniform(700.0, 1500.0)
    bulk = density * chance.log(20.0, 1500.0) ** 2
    keys = {"density": density, "bulk": bulk}
    model = chance.choose({"tait": 3, "linear": 1})
    if model == "tait":
        keys.update(eos_model=model, tait_n=7.0)
    law = "none"
    if effects.get("strength", True):
        if chance.true(0.5):
            law = "newtonian"
            keys.update(strength_model=law, viscosity=chance.log(1.0e-3, 10.0))
        else:
            keys["elastic"] = "none"
    if chance.true(0.4):
        keys["spall"] = bulk * chance.log(1.0e-6, 1.0e-3)
    sound, fast = speeds(density, bulk, 0.0)
    return Matter("liquid", keys, density, sound, fast, f"{law}/{model}", opens=True, speed_limit=0.2 * sound)


def gas(chance, effects):
    """An ideal gas near room temperature, thin or dense, or hot."""
    gamma = chance.uniform(1.1, 1.67)
    density, energy = chance.log(0.1, 50.0), chance.log(5.0e4, 5.0e6)
    keys = {"density": density, "eos_model": "ideal_gas", "ig_gamma": gamma}
    if effects.get("strength", True):
        keys["elastic"] = "none"
    sound = math.sqrt(gamma * (gamma - 1.0) * energy)
    return Matter("gas", keys, density, sound, sound, "ideal_gas", carries=True, opens=True, energy=energy,
                  speed_limit=4.0 * sound, gamma=gamma)


def fail(chance, matter, effects, dx):
    """Models of failure that are compatible with the law, and the treatment of failed material."""
    keys = matter.keys
    law = keys.get("strength_model")
    if matter.family == "metal" and law in ("von_mises", "johnson_cook") and chance.true(0.6):
        keys.update(damage_model="johnson_cook", jcd=[chance.uniform(0.02, 0.3), chance.uniform(0.0, 2.0),
                                                      chance.uniform(-3.0, -0.5), chance.uniform(0.0, 0.02), 0.0])
    elif matter.family in ("brittle", "metal") and "preset" not in keys and law in (None, "von_mises", "jh2"):
        break_brittle(chance, matter, law, effects, dx)
    elif matter.family == "soft" and law in (None, "von_mises") and effects.get("strength", True) and chance.true(0.5):
        keys.update(damage_model="principal_strain", failure_strain=chance.uniform(0.02, 0.3))
    word = keys.get("damage_model", "none")
    if effects.get("size_scatter") and word in ("principal_stress", "principal_strain"):
        keys["weibull_m"] = chance.uniform(4.0, 15.0)
        keys["weibull_volume"] = dx ** 3
        if chance.true(0.3):
            keys["weibull_size"] = dx * chance.log(0.1, 5.0)
    if word != "none" or "spall" in keys:
        matter.breaks = True
        matter.model += f"/{word}"
        if word != "jh2" and matter.family != "liquid" and chance.true(0.4):
            remains(chance, keys)
    elif keys.get("preset", "lead") != "lead" and matter.family != "grains":
        matter.model += "/damage"


def break_brittle(chance, matter, law, effects, dx):
    """Failure of brittle material by stress, strain, flaws or JH-2."""
    keys, bulk = matter.keys, matter.density * matter.bulk_speed ** 2
    strain = chance.log(3.0e-4, 5.0e-3)
    shear = 0.75 * matter.density * (matter.wave_speed ** 2 - matter.bulk_speed ** 2)
    young = 9.0 * bulk * shear / (3.0 * bulk + shear)
    word = chance.choose({"principal_stress": 3, "principal_strain": 2, "grady_kipp": 2,
                          "jh2": 4 if law == "jh2" else 0})
    keys["damage_model"] = word
    if word == "jh2":
        keys.update(jh2_d1=chance.uniform(0.005, 0.1), jh2_d2=chance.uniform(0.5, 1.0))
        if chance.true(0.5):
            keys["jh2_beta"] = chance.uniform(0.0, 1.0)
        return
    if word == "grady_kipp":
        # so many flaws that some hundred of them are active in a cell at that strain
        power = chance.uniform(5.0, 10.0)
        keys.update(weibull_m=power, weibull_k=300.0 / dx ** 3 / strain ** power)
        return
    if word == "principal_stress":
        keys["failure_stress"] = young * strain
        if chance.true(0.4):
            keys["failure_shear"] = 5.0 * young * strain
    else:
        keys["failure_strain"] = strain
    extra = chance.choose({"none": 5, "delay": 2, "energy": 3})
    if extra == "delay":
        keys["failure_delay"] = dx / matter.wave_speed * chance.log(0.3, 10.0)
        if chance.true(0.5):
            keys["failure_delay_power"] = chance.uniform(0.5, 2.0)
    elif extra == "energy" and law != "jh2":
        # a cell holds a tenth to a half of the energy that its crack dissipates
        keys["fracture_energy"] = young * strain ** 2 * dx * chance.uniform(5.0, 20.0)
        keys["softening"] = chance.choose(["linear", "exponential"])


def remains(chance, keys):
    """Treatment of failed material."""
    word = chance.choose({"rubble": 2, "nothing": 1, "granular": 2, "drucker_prager": 2})
    keys["failed_as"] = word
    if word == "granular":
        keys["failed_gamma_c"] = chance.uniform(0.1, 0.5)
    elif word == "drucker_prager":
        keys["failed_friction_angle"] = chance.uniform(15.0, 45.0)


FAMILIES = {"metal": metal, "brittle": brittle, "soft": soft, "porous": porous, "grains": grains, "liquid": liquid,
            "gas": gas}
