# SPDX-License-Identifier: BSD-3-Clause
"""Cost of each effect: instructions, time and memory of a small scene with the effect off, not named in the deck, and
on.

    python3 test/bench/effects.py --scree build/bin/scree --work /tmp/effects [--only NAME ...] [--write FILE]

Instructions are counted by `valgrind --tool=callgrind` in the steps alone, so they do not depend on the load of the
machine. The time is processor time, the best of some runs with one thread, and is approximate. An effect that is off
must cost as much as one that the deck does not name: within 1 % of the instructions, with the same memory and the same
bits.
"""

import argparse
import json
import math
import os
import re
import resource
import shutil
import subprocess
import sys
from pathlib import Path

SCENE = """
&run  dimension='plane_strain'  method='ddmp' /
&units  system='si' /
&method  stress_update='usl'  {method} /
&grid  lo=0,0,0  hi=1,1,1  dx=0.03125 /
&time  t_end=1.0e3  max_steps={steps} /
&effects  {effects} /
&material  name='m'  {material} /
&region  name='a'  shape='box'  lo=0.25,0,0.25  hi=0.75,1,0.75 /
&body  name='a'  region='a'  material='m'  ppc=3,3,3  velocity=1,0,0 /
&boundary  face='xhi'  type='slip' /
&output  name='h'  kind='history'  every=100000 /
&checkpoint  at_end=.false. /
"""
PARTICLES = 2304
STEPS, TIMED_STEPS = 10, 400
STEP = "__step_advance_MOD_advance"

PLAIN = "artificial_viscosity=.false."
ELASTIC = "density=1000  bulk=1.0e6  shear=5.0e5"
SHOCK = "density=1000  shear=5.0e5  eos_model='mie_gruneisen'  mg_c0=32  mg_s=1.3  mg_gamma=2"
YIELD = "strength_model='von_mises'  yield=1.0e3"
JOHNSON = "strength_model='johnson_cook'  jc_a=1.0e3  jc_b=3.0e3  jc_n=0.3"
BRITTLE = "damage_model='principal_stress'  failure_stress=3.0e3"
HOT = "specific_heat=500"
FLUID = "density=1000  bulk=1.0e6"
JH2 = ("density=1000  shear=5.0e5  eos_model='jh2'  jh2_k1=1.0e6  jh2_k2=1.0e6  jh2_k3=1.0e6  strength_model='jh2'"
       "\n  jh2_a=0.9  jh2_n=0.7  jh2_b=0.1  jh2_m=0.4  jh2_t=3.0e3  jh2_hel=6.0e4  jh2_phel=3.0e4")
TILLOTSON = ("density=1000  shear=5.0e5  eos_model='tillotson'  till_a=0.5  till_b=1.5  till_bulk=1.0e6"
             "\n  till_square=1.0e6  till_alpha=5  till_beta=5  till_e0=4.0e4  till_eiv=1.0e3  till_ecv=9.0e3")
STEINBERG = "strength_model='steinberg_guinan'  scg_y0=1.0e3  scg_ymax=1.0e4  scg_beta=10  scg_n=0.2  scg_gp=1.0e-7"
PORES = ("density=1000  shear=5.0e5  eos_model='p_alpha'  mg_c0=32  mg_s=1.3  mg_gamma=2"
         "\n  pa_solid=1100  pa_pe=1e3  pa_pc=1e5")
MU = "strength_model='mu_i'  mu_s=0.4  mu_2=0.7  mu_i0=0.3  grain_diameter=1.0e-3  grain_density=2500"


def scene(effects=PLAIN, material=ELASTIC, method=""):
    """A deck without the number of its steps."""
    return SCENE.replace("{effects}", effects).replace("{material}", material).replace("{method}", method)


def switch(key, effects=PLAIN, material=ELASTIC, more=""):
    """The scenes of a switch of &effects: off, not named, on."""
    return (scene(f"{effects}  {key}=.false.", material), scene(effects, material),
            scene(f"{effects}  {key}=.true.", f"{material}  {more}"))


def model(material, base=ELASTIC):
    """The scenes of a model that replaces a simpler one."""
    return None, scene(material=base), scene(material=material)


CONTACT = scene(f"{PLAIN}  {{switch}}") + """&region  name='b'  shape='box'  lo=0.25,0,0.5  hi=0.75,1,0.75 /
&body  name='b'  region='b'  material='m'  ppc=3,3,3  velocity=0.9,0,-0.1 /
"""
FORCES = "&output  name='f'  kind='forces'  every=100000 /\n"
LOAD = "&region  name='half'  shape='box'  lo=0,0,0  hi=0.5,1,1 /\n&load  name='l'  region='half'  pressure=1 /\n"
DAMAGE = f"{PLAIN}  damage=.true."
THERMAL = f"{PLAIN}  thermal=.true."
EFFECTS = {
    "artificial_viscosity": (scene(PLAIN), scene("artificial_viscosity=.false."), scene("artificial_viscosity=.true.")),
    "gravity": (scene(f"{PLAIN}  gravity=.false."), scene(), scene(f"{PLAIN}  gravity=.true.")),
    "strength": (scene(f"{PLAIN}  strength=.false.", FLUID), scene(material=f"{FLUID}  elastic='none'"), scene()),
    "von_mises": model(f"{ELASTIC}  {YIELD}"),
    "johnson_cook": (None, scene(), scene(f"{PLAIN}  rate=.false.", f"{ELASTIC}  {JOHNSON}")),
    "steinberg_guinan": model(f"{SHOCK}  {STEINBERG}", SHOCK),
    "drucker_prager": model(f"{ELASTIC}  strength_model='drucker_prager'  friction_angle=30"),
    "mohr_coulomb": model(f"{ELASTIC}  strength_model='mohr_coulomb'  friction_angle=30"),
    "mu_i": model(f"{ELASTIC}  {MU}"),
    "granular": model(f"{ELASTIC}  strength_model='granular'  gr_gamma_c=0.1"),
    "neo_hookean": model(f"{ELASTIC}  strength_model='neo_hookean'"),
    "newtonian": model(f"{FLUID}  strength_model='newtonian'  viscosity=10", f"{FLUID}  elastic='none'"),
    "jh2": model(JH2),
    "gurson": model(f"{ELASTIC}  strength_model='gurson'  yield=1.0e3  gtn_f0=0.01"),
    "rate": (scene(f"{PLAIN}  rate=.false.", f"{ELASTIC}  {JOHNSON}"), None,
             scene(PLAIN, f"{ELASTIC}  {JOHNSON}  jc_c=0.01")),
    "eos": (scene(f"{PLAIN}  eos=.false."), None, scene()),
    "mie_gruneisen": model(SHOCK),
    "tait": model(f"{ELASTIC}  eos_model='tait'  tait_n=7"),
    "tillotson": model(TILLOTSON),
    "p_alpha": model(PORES),
    "table": model("density=1000  shear=5.0e5  eos_model='table'  eos_table='table.txt'"),
    "damage": switch("damage", material=ELASTIC, more=BRITTLE),
    "size_scatter": switch("size_scatter", DAMAGE, f"{ELASTIC}  {BRITTLE}", "weibull_m=7  weibull_volume=1"),
    "voids": switch("voids", DAMAGE, f"{ELASTIC}  {BRITTLE}"),
    "thermal": switch("thermal", material=f"{ELASTIC}  {YIELD}", more=HOT),
    "melting": switch("melting", THERMAL, f"{ELASTIC}  {YIELD}  {HOT}", "t_melt=900"),
    "conduction": (None, scene(THERMAL, f"{ELASTIC}  {HOT}"), scene(THERMAL, f"{ELASTIC}  {HOT}  conductivity=1.0e3")),
    "contact": (CONTACT.replace("{switch}", "contact=.false."), CONTACT.replace("{switch}", ""),
                CONTACT.replace("{switch}", "contact=.true.")),
    "contact_itself": (None, scene(DAMAGE, f"{ELASTIC}  {BRITTLE}"),
                       scene(f"{DAMAGE}  contact=.true.", f"{ELASTIC}  {BRITTLE}") + "&contact  bodies='a','a' /\n"),
    "damping": (scene(f"{PLAIN}  damping=0"), scene(), scene(f"{PLAIN}  damping=1")),
    "load": (None, scene(), scene() + LOAD),
    "forces": (None, scene(), scene() + FORCES),
    "antilock": (scene(method="antilock='none'"), scene(), scene(method="antilock='bbar'")),
    "sub_points": (scene(method="quadrature='point'"), scene(), scene(method="quadrature='sub_points'")),
}


def write_table(path):
    """64 densities and temperatures of a soft solid: p = c (rho - 1000) + 20 (T - 293), with the consistent energy
    e."""
    lines = []
    for density in (500.0 + 1000.0 * i / 63 for i in range(64)):
        cold = 1.0e3 * (math.log(density / 1000.0) + 1000.0 / density - 1.0) + 20.0 * 293.0 / density
        lines += [f"{density!r} {t!r} {1.0e3 * (density - 1000.0) + 20.0 * (t - 293.0)!r} {cold + 500.0 * t!r}"
                  for t in (200.0 + 300.0 * j / 63 for j in range(64))]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


class Bench:
    """Runs scenes, each once."""

    def __init__(self, scree, work):
        self.scree, self.work, self.counted, self.timed = Path(scree).resolve(), Path(work).resolve(), {}, {}
        self.work.mkdir(parents=True, exist_ok=True)

    def run(self, deck, steps, before=()):
        """Run a deck; its output and summary."""
        folder = self.work / "run"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        write_table(folder / "table.txt")
        (folder / "scene.nml").write_text(deck.replace("{steps}", str(steps)), encoding="ascii")
        done = subprocess.run([*before, self.scree, "--case", "scene", "--outdir", folder, folder / "scene.nml"],
                              env={**os.environ, "OMP_NUM_THREADS": "1"}, text=True, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode:
            sys.exit(f"exit code {done.returncode}\n{deck}\n{done.stdout[-3000:]}")
        return done.stdout, json.loads((folder / "scene.summary.json").read_text(encoding="utf-8"))

    def instructions(self, deck):
        """Instructions per particle and step, bytes per particle, and the digest."""
        if deck not in self.counted:
            output, summary = self.run(deck, STEPS, (
                "valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", f"--toggle-collect={STEP}"))
            count = int(re.search(r"Collected : (\d+)", output).group(1))
            self.counted[deck] = (count / (PARTICLES * STEPS), summary["bytes_per_particle"], summary["digest"])
        return self.counted[deck]

    def nanoseconds(self, deck, repeats=5):
        """Processor time per particle and step [ns], the best of some runs, without the start."""
        if deck not in self.timed:
            best = {}
            for steps in (STEPS, TIMED_STEPS) * repeats:
                before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
                self.run(deck, steps)
                spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
                best[steps] = min(spent, best.get(steps, spent))
            self.timed[deck] = 1.0e9 * (best[TIMED_STEPS] - best[STEPS]) / (PARTICLES * (TIMED_STEPS - STEPS))
        return self.timed[deck]


def main():
    """Print the table; exit code 1 if an effect that is off costs instructions or memory."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scree", required=True)
    parser.add_argument("--work", required=True)
    parser.add_argument("--only", nargs="*", choices=list(EFFECTS), default=list(EFFECTS))
    parser.add_argument("--write", help="also write the rows of the table into this file")
    options = parser.parse_args()
    if not shutil.which("valgrind"):
        sys.exit("valgrind is needed to count instructions")
    bench, costs = Bench(options.scree, options.work), []
    count, size, _ = bench.instructions(scene())
    lines = [f"Elastic matter without any of them: {count:.0f} instructions and {bench.nanoseconds(scene()):.0f} ns "
             f"a particle and step, {size:.0f} bytes a particle.", "",
             "| effect | instructions added | ns added | bytes added | off against never named |",
             "|---|---|---|---|---|"]
    for name in options.only:
        off, never, on = EFFECTS[name]
        base, same = off or never, ""
        one, two = bench.instructions(base), bench.instructions(on)
        if off and never:
            other = bench.instructions(never)
            same = f"{100.0 * (one[0] / other[0] - 1.0):+.3f} %"
            if abs(one[0] / other[0] - 1.0) > 0.01 or one[1:] != other[1:]:
                costs.append(name)
        lines.append(f"| `{name}` | {two[0] - one[0]:+.0f} | {bench.nanoseconds(on) - bench.nanoseconds(base):+.0f} "
                     f"| {two[1] - one[1]:+.0f} | {same} |")
        print(lines[-1], flush=True)
    print("\n".join(lines))
    if options.write:
        Path(options.write).write_text("\n".join(lines) + "\n", encoding="utf-8")
    if costs:
        sys.exit(f"off, but not as if never named: {', '.join(costs)}")


if __name__ == "__main__":
    main()
