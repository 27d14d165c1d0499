# SPDX-License-Identifier: BSD-3-Clause
# tiers: full
# timeout: 300
"""A restart may change the keys that only the rest of the run reads, and uses their new values.

Would catch a key of the schema about whose change nothing is declared, a key that a restart accepts but does not read,
a refusal without its reason, and a body that came to rest with damping and cannot be released.
"""

import functools
import re
import subprocess

import pytest

import case

SCENE = """&run  dimension='plane_strain' {run} /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1  max_steps=12 /
&effects  {effects} /
&material  name='m'  {material} /
&region  name='r'  shape='box'  lo=0.2,0,0  hi=0.8,1,0.6 /
&body  name='b'  region='r'  material='m'  {body} /
&boundary  face='zlo'  type={wall} /
{more}
&output  name='h'  kind='history'  every=4 /
"""
USUAL = {"run": "", "effects": "gravity=.true.", "body": "velocity=0,0,-{speed}", "wall": "'slip'", "more": ""}
SOLID = "density=2000  bulk=1e7  shear=5e6"
METAL = "density=2700  shear=26e9  eos_model='mie_gruneisen'  mg_c0=5240  mg_s=1.4  mg_gamma=2"
# Scenes, and keys whose change must change the results of the few steps after the restart.
SCENES = {
    "elastic": ({"material": "density=2000  young=1e7  poisson=0.3", "speed": 5,
                 "effects": "gravity=.true.  damping=20", "wall": "'friction'  friction=0.3",
                 "more": "&load  pressure=1e5  times=0,1  factors=1,0.5 /"},
                "effects.damping effects.gravity_vector load.pressure load.factors material.young material.poisson "
                "boundary.friction method.bulk_q1 method.bulk_q2 time.cfl"),
    "mpm": ({"run": "method='mpm'", "material": SOLID, "speed": 5,
             "more": "&method  transfer='flip'  stress_update='usavg' /"},
            "method.flip material.bulk material.shear"),
    "von_mises": ({"material": SOLID + "  strength_model='von_mises'  yield=1e5  hardening=1e6", "speed": 10},
                  "material.yield material.hardening"),
    "johnson_cook": ({"material": METAL + "  strength_model='johnson_cook'  jc_a=1e8  jc_b=4e8  jc_n=0.3  jc_c=0.01"
                      "  jc_m=1  t_melt=800  specific_heat=890  spall=1e9  damage_model='johnson_cook'"
                      "  jcd=0.1,0.1,-1.5,0.01,0", "speed": 1000,
                      "effects": "damage=.true.  thermal=.true.  melting=.true."},
                     "material.mg_c0 material.mg_s material.mg_gamma material.jc_a material.jc_b material.jc_n "
                     "material.jc_c material.jc_rate material.jc_m material.t_melt material.specific_heat "
                     "material.jcd"),
    "steinberg": ({"material": METAL + "  strength_model='steinberg_guinan'  scg_y0=2.9e8  scg_ymax=6.8e8  scg_beta=125"
                   "  scg_n=0.1  scg_gp=6.5e-11  scg_gt=6.2e-4  scg_tm=1220  scg_a=1.5  scg_gamma=1.97"
                   "  specific_heat=890", "speed": 1000, "effects": "thermal=.true."},
                  "material.scg_y0 material.scg_beta material.scg_n material.scg_gp material.scg_gt"),
    "gurson": ({"material": SOLID + "  strength_model='gurson'  yield=1e5  hardening=1e6  gtn_f0=0.02  gtn_fn=0.04"
                "  gtn_fc=0.1  gtn_ff=0.3", "speed": 10},
               "material.gtn_q1 material.gtn_q2 material.yield"),
    "drucker_prager": ({"material": SOLID + "  strength_model='drucker_prager'  friction_angle=30  cohesion=1e4"
                        "  dilation_angle=5", "speed": 10},
                       "material.friction_angle material.cohesion material.dilation_angle"),
    "mu_i": ({"material": SOLID + "  strength_model='mu_i'  mu_s=0.4  mu_2=0.6  mu_i0=0.3  grain_diameter=1e-3"
              "  grain_density=2500", "speed": 10}, "material.mu_s material.mu_2 material.mu_i0"),
    "granular": ({"material": SOLID + "  strength_model='granular'  gr_tau=1e-3  gr_gamma_c=1e-2", "speed": 5},
                 "material.gr_tau material.gr_gamma_c"),
    "newtonian": ({"material": "density=1000  bulk=1e7  strength_model='newtonian'  viscosity=10", "speed": 5},
                  "material.viscosity material.bulk"),
    "jh2": ({"material": "preset='glass_soda_lime'", "speed": 500, "effects": "damage=.true."},
            "material.jh2_k1 material.jh2_a material.jh2_n"),
    "hjc": ({"material": "preset='concrete_48'", "speed": 100, "effects": "damage=.true."},
            "material.hjc_pcrush material.hjc_a material.hjc_t"),
    "tillotson": ({"material": "density=2700  shear=2.2e10  eos_model='tillotson'  till_a=0.5  till_b=1.5"
                   "  till_bulk=2.67e10  till_square=2.67e10  till_alpha=5  till_beta=5  till_e0=4.87e8"
                   "  till_eiv=4.72e6  till_ecv=1.82e7", "speed": 1000},
                  "material.till_a material.till_b material.till_bulk material.till_square material.till_e0"),
    "tait": ({"material": "density=1000  bulk=2e9  elastic='none'  eos_model='tait'  tait_n=7", "speed": 100},
             "material.tait_n"),
    "gas": ({"material": "density=1  elastic='none'  eos_model='ideal_gas'  ig_gamma=1.4", "speed": 100,
             "body": "velocity=0,0,-100  specific_energy=2e5"}, "material.ig_gamma"),
    "p_alpha": ({"material": "density=2000  elastic='none'  eos_model='p_alpha'  pa_solid=2700  pa_pe=1e7  pa_pc=5e8"
                 "  mg_c0=5240  mg_s=1.4  mg_gamma=2", "speed": 300}, "material.pa_pe material.pa_pc material.mg_c0"),
    "explosive": ({"material": "preset='tnt'", "speed": 0, "more": "&detonation  point=0.5,0,0 /"},
                  "material.jwl_a material.jwl_b material.jwl_r1 material.jwl_omega material.burn_cells"),
}


@functools.lru_cache(maxsize=None)
def explained(scree, *words):
    """Output of the program, which is the same for all scenes."""
    return subprocess.run([str(scree), *words], capture_output=True, text=True, check=True).stdout


def program(options, *words):
    """Output of the program that is tested."""
    return explained(options.scree, *words)


def test_every_key(options, sheet):
    """The explanation of each key of the schema states what a restart may do with it."""
    groups = re.findall(r"^(?:! )?&(\w+)", program(options, "--template"), re.M)
    seen, bare, frozen = 0, [], []
    for group in groups:
        # keys with the name of a group are explained before and after it
        said = re.search(rf"^&{group} .*\n((?: .*\n?)*)", program(options, "--explain", group), re.M)
        for name in re.findall(r"^ {3}(\w+) ", said.group(1), re.M):
            seen += 1
            key = f"{group}.{name}"
            text = program(options, "--explain", key)
            line = re.search(r"^ +restart: (may change[,;] .+|must not change; .{10,})$", text, re.M)
            if line is None:
                bare.append(key)
            elif line.group(1).startswith("must"):
                frozen.append(key)
    sheet.require(seen > 350, f"{seen} keys are explained")
    sheet.require(not bare, f"every key states it, but {bare}")
    sheet.require({"grid.dx", "body.velocity", "material.density", "run.dimension"} <= set(frozen), "the layout stays")
    sheet.require(not {"effects.damping", "effects.gravity_table", "load.pressure", "inflow.velocity"} & set(frozen),
                  "what only the rest of a run reads may change")


def numbers_of(echo):
    """Keys of an echo that have numbers: (group, key, values)."""
    group = ""
    for line in echo.splitlines():
        if line.startswith("&"):
            group = line[1:].strip()
        found = re.match(r" {3}(\w+) += (-?\.?\d[^!]*?) *(?:! default)?$", line)
        if found:
            yield group, found.group(1), found.group(2)


@pytest.mark.parametrize("name", SCENES)
def test_changed_numbers(options, sheet, name):
    """Each number of a scene is changed by a percent in a restart: it is accepted and named, or refused with its
    reason, as its explanation says."""
    words, felt = SCENES[name]
    words = {**USUAL, **words}
    words["body"] = words["body"].format(speed=words["speed"])
    run = case.Case(options, name, SCENE.format(**words)).run("--quiet")
    first = run.path("_chk_0001.h5")
    plain = case.Case(options, name + "_plain", SCENE.format(**words).replace("max_steps=12", "max_steps=24"))
    plain.run("--quiet", "--restart", str(first))
    unfelt, tried = set(felt.split()), 0
    for group, key, values in numbers_of(run.path(".echo.nml").read_text(encoding="utf-8")):
        if group in ("checkpoint", "log", "parallel", "point", "output", "grains", "cell", "stage", "run"):
            continue
        if name != "elastic" and group != "material" and f"{group}.{key}" not in felt.split():
            continue                                    # the first scene changes them
        about = program(options, "--explain", f"{group}.{key}")
        if "kind: integer" in about or "integers" in about or "up to" in about and key != "factors":
            continue
        old = [float(word) for word in values.replace(",", " ").split()]
        value = ",".join(repr(0.99 * v if any(old) else 0.003) for v in old)
        again = case.Case(options, f"{name}_{group}_{key}", plain.deck.read_text(encoding="utf-8"))
        frozen = "restart: must not change" in about
        with sheet.part(f"{name} {group}.{key}"):
            again.run("--restart", str(first), "--set", f"{group}.{key}={value}", expect=None)
            if again.code == 2:
                continue                                # the number alone is not a valid change of this deck
            tried += 1
            assert again.code == (3 if frozen else 0), again.output
            if frozen:
                reason = re.search(r"restart: must not change; (.*)", about).group(1)
                assert "[F110]" in again.output and reason in again.output, again.output
            elif "time.t_end" != f"{group}.{key}":
                assert f" {key} = " in again.output, again.output
                if again.summary["digest"] != plain.summary["digest"]:
                    unfelt.discard(f"{group}.{key}")
    sheet.require(tried >= max(2, len(felt.split())), f"{tried} numbers were changed")
    sheet.require(not unfelt, f"these keys change the results: {sorted(unfelt)}")


BAR = """&run  dimension='1d' /
&grid  lo=0,0,0  hi=1.2,1,1  dx=0.05 /
&time  t_end={end}  dt_fixed=1e-3 /
&effects  damping={damping} /
&material  name='m'  density=1000  young=1e6  poisson=0 /
&region  name='r'  shape='box'  lo=0,0,0  hi=1,1,1 /
&region  name='tip'  shape='box'  lo=0.9,0,0  hi=1.2,1,1 /
&body  name='b'  region='r'  material='m' /
&boundary  face='xlo'  type='stick' /
{load}
&output  name='h'  kind='history'  every=1 /
"""
PRESSURE = 1000.0


def test_release(options, sheet):
    """A bar is compressed by a load and comes to rest with damping; a restart without load and damping releases it. The
    elastic energy of the pressure, p**2 V/2E, then becomes kinetic energy a quarter of a period later, and none is
    lost. A damping of the old deck would brake it, the load of the old deck would hold it. The tip moves only by
    p/E = 0.1 %, so the linear theory holds."""
    speed, young = (1e6 / 1000) ** 0.5, 1e6
    relaxed = 20 / speed                         # twenty passages of a wave
    damping = 2 * 3.14159 / 2 * speed            # twice the lowest angular frequency pi c/2L
    words = {"damping": damping, "load": f"&load  region='tip'  pressure={PRESSURE} /"}
    bits = []
    for ranks in (1, 2):
        if ranks > 1 and not case.has_ranks(options.scree):
            continue
        run = case.Case(options, f"bar_{ranks}", BAR.format(end=relaxed, **words), ranks=ranks).run("--quiet")
        rest = run.history["kinetic"][-1]
        free = BAR.format(end=relaxed + 2 / speed, damping=0.0, load="")
        run.deck.write_text(free, encoding="utf-8")
        run.run("--restart")
        assert "&effects damping = 0.0, was" in run.output and "&load is gone" in run.output, run.output
        bits.append(run.summary["digest"])
    sheet.require(len(set(bits)) == 1, "the same bits on one rank and on two")
    history = run.history
    energy = PRESSURE ** 2 / (2 * young)
    after = history["time"] > relaxed
    sheet.below("kinetic energy at rest over the elastic one", rest / energy, 1e-3)
    # a block of particles of the tip is half loaded: its share of the length of 20 cells
    sheet.near("greatest kinetic energy after the release over the elastic one",
               history["kinetic"][after].max() / energy, 1.0, 0.15)


INFLOW = """&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end={end}  dt_fixed=2e-4 /
&material  name='m'  density=1000  young=1e6  poisson=0 /
&region  name='r'  shape='box'  lo=0,0,0.3  hi=0.3,1,0.6 /
&body  name='b'  region='r'  material='m' /
&inflow  body='b'  velocity={speed},0,0 /
&output  name='h'  kind='history'  every=1 /
"""


def test_slower_inflow(options, sheet):
    """A restart with another velocity of an inflow continues from the material that has entered: the mass grows by the
    new velocity, to one layer of particles. The displacement since the start with the new velocity leaves a gap."""
    first = case.Case(options, "inflow", INFLOW.format(end=0.02, speed=10)).run("--quiet")
    before = first.history["mass"][-1]
    layer = 1000 * 0.3 * 0.05
    first.deck.write_text(INFLOW.format(end=0.04, speed=4), encoding="utf-8")
    first.run("--restart")
    sheet.near("mass that entered before [layers]", (before - 90) / layer, 0.2 / 0.05, 1.0)
    sheet.near("mass that entered after [layers]", (first.history["mass"][-1] - before) / layer, 0.08 / 0.05, 1.0)
