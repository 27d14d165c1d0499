# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke
# timeout: 120
"""What `--check` says about a run before it begins: particles and masses, units, memory.

Would catch a number of particles or a mass that the run does not have (particles at cut surfaces counted as whole,
parts of a shape outside of the grid, later bodies, factors of random packings, rings around an axis), a value in other
units that is accepted in silence, a false alarm for a preset or an example, a run that is started without the memory
that it needs, and an allocation that fails without a message.
"""

import os
import re
import resource
import subprocess

import numpy as np
import pytest

import case
import test_facets

DECK = """&run dimension = '{dimension}' /
&grid lo = 0 0 0  hi = 1 1 1  dx = {dx} /
&time t_end = 1  max_steps = 0 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
{regions}
&body name = 'one'  region = 'solid'  material = 'metal'  packing = '{packing}'  ppc = 2 2 2  {body} /
{more}
"""
DISC = "&region name = 'solid'  shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.31 /"
CORNER = "&region name = 'solid'  shape = 'sphere'  centre = 0 0 0  radius = 0.71 /"
BOX = "&region name = 'solid'  shape = 'box'  lo = 0.3 0.3 0.3  hi = 0.71 0.72 0.73  {} /"
TURNED = BOX.format("rotate = 10 20 30  rotate_about = 'centre'")
MIRRORS = "&boundary face = 'xlo'  type = 'symmetry' /\n&boundary face = 'zlo'  type = 'symmetry' /"
STL = "&region name = 'solid'  shape = 'stl'  file = 'ball.stl' /"
TWO = ("&region name = 'small'  shape = 'sphere'  centre = 0.6 0.5 0.6  radius = 0.2 /\n"
       "&body name = 'two'  region = 'small'  material = 'metal'  packing = 'cut' /")
SCENES = {
    "disc_cut": ("plane_strain", 0.05, DISC, "cut", "", ""),
    "quarter_disc_cut": ("plane_strain", 0.05, CORNER, "cut", "", MIRRORS),
    "ball_lattice": ("3d", 0.1, DISC, "lattice", "", ""),
    "ball_cut": ("3d", 0.1, DISC, "cut", "", ""),
    "turned_box_cut": ("3d", 0.1, TURNED, "cut", "", ""),
    "stl_cut": ("3d", 0.1, STL, "cut", "", ""),
    "disks": ("plane_strain", 0.05, DISC, "poisson_disk", "", ""),
    "disks_round_an_axis": ("axisymmetric", 0.05, DISC, "poisson_disk", "", ""),
    "ring_cut": ("axisymmetric", 0.05, DISC, "cut", "", ""),
    "line_cut": ("1d", 0.05, BOX.format(""), "cut", "", ""),
    "overlap": ("plane_strain", 0.05, DISC, "lattice", "", TWO),
    "rows": ("plane_strain", 0.05, DISC.replace("0.31", "0.11").replace("0.5 0.5 0.5", "0.2 0.5 0.2"), "cut",
             "repeat = 3 1 2  repeat_step = 0.25 0 0.3", ""),
}


def scene(options, name, facets=None):
    """A case of SCENES."""
    dimension, dx, regions, packing, body, more = SCENES[name]
    made = case.Case(options, name, DECK.format(dimension=dimension, dx=dx, regions=regions, packing=packing, body=body,
                                                more=more))
    if "stl" in name:
        (made.folder / "ball.stl").write_bytes(test_facets.binary(test_facets.ball(12) if facets is None else facets))
    return made


@pytest.mark.parametrize("name", SCENES)
def test_particles_and_mass(options, sheet, name):
    """The report has the particles and masses of the run, to the digits that it prints."""
    made = scene(options, name)
    said = made.run("--check", "--no-estimate").output
    made.run("-q")
    particles = int(re.search(r"^particles  (\d+) ", said, re.M).group(1))
    mass = float(re.search(r"^mass       (\S+) kg", said, re.M).group(1))
    sheet.require(particles == made.summary["particles"] > 0, f"{particles} particles, of {made.summary['particles']}")
    sheet.near("mass [kg]", mass, made.history["mass"][0], 1.0e-5)
    parts = re.search(r"^mass .*? kg: (.*)", said, re.M)
    if parts:
        sheet.near("sum of bodies [kg]", sum(float(part.split()[-1]) for part in parts.group(1).split(", ")), mass,
                   1.0e-5 * len(parts.group(1).split(", ")))


MEMORY = {
    "elastic": ("elastic = 'isotropic'  young = 70e9  poisson = 0.3", ""),
    "shocks": ("young = 70e9  poisson = 0.3  eos_model = 'mie_gruneisen'  mg_c0 = 5000  mg_s = 1.3  mg_gamma = 2  "
               "strength_model = 'johnson_cook'  jc_a = 1e8  jc_b = 1e8  jc_n = 0.5  jc_c = 0.01  jc_m = 1  "
               "jc_rate = 1  t_melt = 900  specific_heat = 900",
               "&effects thermal = T / &method split = T /"),
    "boxes": ("young = 70e9  poisson = 0.3", "&method basis = 'cpdi'  transfer = 'apic' /"),
}


@pytest.mark.parametrize("name", MEMORY)
def test_forecast_of_memory(options, sheet, name):
    """Would catch a field that the forecast omits, or counts with other bytes than it has.

    The forecast assumes spare capacity of 7 %; a run has between none and that.
    """
    material, more = MEMORY[name]
    method = "mpm" if name == "boxes" else "ddmp"
    made = case.Case(options, f"memory_{name}", f"""&run dimension = '3d'  method = '{method}' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.05 /
&time t_end = 1  max_steps = 1 /
&material name = 'metal'  density = 2700  {material} /
&region name = 'all'  shape = 'box'  lo = 0.1 0.1 0.1  hi = 0.9 0.9 0.9 /
&body name = 'one'  region = 'all'  material = 'metal'  ppc = 2 2 2 /
{more}
""")
    said = made.run("--check", "--no-estimate").output
    made.run("-q")
    told = float(re.search(r"bytes per particle, (\d+) with node fields", said).group(1))
    sheet.near("forecast over memory in use", told / made.summary["bytes_per_particle"], 1.0, 0.07)


def test_volume_of_facets(options, sheet):
    """Cut surfaces have the mass of the volume that the facets enclose: sampling a site has an error of half a sample,
    1/12 of its edge, in alternating directions."""
    facets = test_facets.ball(12, centre=(0.5, 0.5, 0.5), radius=0.3)
    said = scene(options, "stl_cut", facets).run("--check", "--no-estimate").output
    mass = float(re.search(r"^mass       (\S+) kg", said, re.M).group(1))
    sheet.near("mass [kg]", mass, 2700.0 * test_facets.volume(facets), 0.01)


PLAIN = """&run dimension = 'plane_strain' /
{units}
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.1 /
&time t_end = {t_end} /
&material name = 'metal'  {material} /
&region name = 'solid'  shape = 'box'  lo = 0.2 0 0.2  hi = 0.8 1 0.8 /
&body name = 'one'  region = 'solid'  material = 'metal'  {body} /
{more}
"""
ELASTIC = "density = 2700  young = 70e9  poisson = 0.3"
FLOWS = "strength_model = 'von_mises'"
MISTAKES = {
    "velocity_km_s": ({"body": "velocity = 900000 0 0"}, "D509", "did you mean 900 m/s (factor 1e-3)?"),
    "speed": ({"body": "speed = 1e6  direction = 1 0 0"}, "D509", "did you mean 1000 m/s (factor 1e-3)?"),
    "wall": ({"more": "&boundary face = 'xlo'  type = 'velocity'  velocity = 1e5 0 0 /"}, "D509", "(factor 1e-3)?"),
    "shear_meant": ({"material": "preset = 'al_6061_t6'  shear = 27.6"}, "D508",
                    "did you mean 2.76e10 Pa (factor 1e9)?"),
    "yield_mpa": ({"material": f"{ELASTIC}  {FLOWS}  yield = 265"}, "D508", "did you mean 2.65e8 Pa (factor 1e6)?"),
    "yield_gpa": ({"material": f"{ELASTIC}  {FLOWS}  yield = 0.265"}, "D508", "did you mean 2.65e8 Pa (factor 1e9)?"),
    "jc_a_mpa": ({"material": "preset = 'al_6061_t6'  jc_a = 265"}, "D508", "did you mean 2.65e8 Pa (factor 1e6)?"),
    "spall_gpa": ({"material": f"{ELASTIC}  spall = 1.2", "more": "&effects damage = .true. /"}, "D508",
                  "did you mean 1.2e9 Pa (factor 1e9)?"),
    "too_strong": ({"material": f"{ELASTIC}  {FLOWS}  yield = 265e9"}, "D508", "did you mean 2.65e8 Pa (factor 1e-3)?"),
    "jh2_gpa": ({"material": "preset = 'glass_soda_lime'  jh2_k1 = 45.4  jh2_k2 = -138  jh2_k3 = 290"}, "D503",
                "gives a wave speed of"),
    "pa_in_mm_us_mg": ({"units": "&units system = 'mm-us-mg' /", "material": "density = 2.7  young = 70  poisson = 0.3"
                        f"  {FLOWS}  yield = 265"}, "D508", "did you mean 2.65e8 Pa (factor 1e-3)?"),
    "load": ({"more": "&load pressure = 1e20 /"}, "D508", "times the bulk modulus"),
    "gravity": ({"more": "&effects gravity = .true.  gravity_vector = 0 0 -9810 /"}, "D512",
                "did you mean 9.81 m/s2 (factor 1e-3)?"),
    "no_step": ({"t_end": "1e-9"}, "D510", "the run makes next to no step"),
    "many_steps": ({"t_end": "1e5"}, "D511", "needs about 1476911577"),
    "no_end": ({"t_end": "1e300"}, "D511", "so that the time could not advance"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_wrong_units(options, name):
    """One warning with its code, line, value in SI and factor; an error where no run could end."""
    change, code, text = MISTAKES[name]
    deck = PLAIN.format(**{"units": "", "t_end": "1e-3", "material": ELASTIC, "body": "", "more": "", **change})
    said = case.Case(options, name, deck).run("--check", "--no-estimate", expect=2 if name == "no_end" else 0).output
    lines = [line for line in said.splitlines() if f"[{code}]" in line]
    assert len(lines) == 1, said
    assert text in lines[0]
    assert re.match(rf".*{name}\.nml:\d+: (error|warning): &", lines[0])


def test_preset_with_another_equation(options):
    """Would catch a value of a preset that another eos_model does not use and that is an error of the deck, or of its
    echo: the bulk modulus of granite, and the time of spall of copper, which needs an internal energy."""
    tillotson = ("preset = 'granite'  eos_model = 'tillotson'  till_a = 0.5  till_b = 1.3  till_bulk = 18e9"
                 "  till_square = 18e9\n  till_e0 = 16e6  till_eiv = 3.5e6  till_ecv = 18e6"
                 "  till_alpha = 5  till_beta = 5")
    linear = "preset = 'cu_ofhc'  eos_model = 'linear'  bulk = 140e9"
    for name, material in (("granite", tillotson), ("copper", linear)):
        deck = PLAIN.format(units="", t_end="1e-2  max_steps = 2", material=material, body="",
                            more="&effects damage = .true.  thermal = .true. /")
        made = case.Case(options, name, deck).run("-q")
        echo = made.path(".echo.nml").read_text(encoding="utf-8")
        case.Case(options, f"{name}_echo", echo).run("--check")


def test_materials_in_contact(options):
    """Would catch a material that is compared with the bulk modulus of another one where contact gives materials a
    store for each velocity field."""
    deck = PLAIN.format(units="", t_end="1e-3", material="density = 1100  young = 2e6  poisson = 0.4", body="", more="""
&effects contact = .true. /
&material name = 'soil'  density = 1700  bulk = 1.2e8  shear = 7.7e7 /
&region name = 'bed'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.2 /
&body name = 'two'  region = 'bed'  material = 'metal' /""")
    deck = deck.replace("'one'  region = 'solid'  material = 'metal'", "'one'  region = 'solid'  material = 'soil'")
    said = case.Case(options, "contact", deck).run("--check", "--no-estimate").output
    assert "[D508]" not in said, said


def test_a_warning_is_in_the_log(options):
    """Would catch a warning of `--check` that the run does not repeat."""
    made = case.Case(options, "log", PLAIN.format(units="", t_end="1e-9", material=ELASTIC, body="", more=""))
    made.run("-q")
    assert "[D510]" in made.path(".log").read_text(encoding="utf-8")


@pytest.mark.parametrize("system", ["si", "cgs", "mm-us-mg", "mm-ms-g"])
def test_no_false_alarm_for_presets(options, system):
    """All presets, in each system of units."""
    listed = subprocess.run([options.scree, "--list", "materials"], stdout=subprocess.PIPE, text=True, check=True)
    names = re.findall(r"^ +([a-z]\w+)  ", listed.stdout.split("preset:")[1], re.M)
    assert len(names) > 10
    deck = PLAIN.format(units=f"&units system = '{system}' /", t_end="1  max_steps = 1000", body="", more="",
                        material=f"preset = '{names[0]}'")
    deck += "".join(f"&material name = 'm{n}'  preset = '{name}' /\n" for n, name in enumerate(names))
    said = case.Case(options, f"presets_{system}", deck).run("--check", "--no-estimate").output
    assert not re.findall(r".*\[D5\d\d\]", said), said


def test_no_false_alarm_for_examples(options, sheet):
    """The decks of input/, none of which has a value in wrong units."""
    decks = [path for path in sorted((case.ROOT / "input").rglob("*.nml")) if b"&grid" in path.read_bytes()]
    sheet.require(len(decks) > 10, "there are decks")
    for deck in decks:
        said = subprocess.run([options.scree, "--check", "--no-estimate", deck], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False).stdout
        sheet.require(not re.findall(r"\[D5(?:0\d|11)\]", said), f"{deck.relative_to(case.ROOT)}: {said[:400]}")


def test_nested_regions(options):
    """Would catch regions that double their shapes at each level, which take all memory and time: 2^30 of them."""
    deck = PLAIN.format(units="", t_end="1e-3", material=ELASTIC, body="", more="")
    levels = [f"&region name = 's{n + 1}'  shape = 'union'  of = 's{n}' 's{n}' /\n" for n in range(30)]
    deck += "&region name = 's0'  shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.2 /\n" + "".join(levels)
    said = case.Case(options, "nested", deck).run("--check", "--no-estimate", expect=2, timeout=30).output
    assert said.count("[D451]") == 1
    assert "more than 200000 simple shapes" in said


BLOCK = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = {dx} /
&time t_end = 1  max_steps = 1 /
&material name = 'metal'  {material} /
&region name = 'all'  shape = 'box'  lo = 0 0 0  hi = 1 1 1 /
&body name = 'one'  region = 'all'  material = 'metal' /
"""


def limited(options, arguments, megabytes):
    """Run the program on one thread with a limit on its address space."""
    return subprocess.run([options.scree, *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False, env={**os.environ, "OMP_NUM_THREADS": "1"}, timeout=100, cwd=options.work,
                          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20)))


class TestMemory:
    """A run that needs more memory than there is."""

    def test_refused(self, options):
        """Would catch a run that begins: it would be killed later. --check only warns, --force goes on."""
        made = case.Case(options, "refused", BLOCK.format(dx=0.00125, material=ELASTIC))
        said = made.run(expect=2).output
        assert re.search(r"refused\.nml:2: error: &grid: the run needs about .* [GT]B of memory, and .* GB are "
                         r"available; use larger cells or fewer ppc.* continue with --force \[R134\]", said), said
        said = made.run("--check", "--no-estimate").output
        assert re.search(r"refused\.nml:2: warning: .*\[R134\]", said), said

    def test_limit_of_the_process(self, options):
        """Would catch a limit on the address space that is ignored, and a failed allocation that ends with addresses of
        the program and exit code 1."""
        made = case.Case(options, "limit", BLOCK.format(dx=0.01, material=ELASTIC))
        answer = limited(options, [made.deck, "--outdir", made.folder], 1500)
        assert (answer.returncode, answer.stdout.count("[R134]")) == (2, 1), answer.stdout
        answer = limited(options, [made.deck, "--outdir", made.folder, "--force", "-q"], 1000)
        assert answer.returncode == 3, answer.stdout
        assert "error: out of memory: an array cannot be allocated; use" in answer.stdout
        assert "Backtrace" not in answer.stdout

    def test_grains(self, options):
        """Would catch a cell of grains that is made without the memory for it."""
        deck = ("&grains shape = 'spheres'  number = 100000000  diameter = 1e-3  density = 2500  stiffness = 1e6 /\n"
                "&cell pressure = 1e3 /\n&stage servo = 'isotropic'  duration = 1e-4 /\n")
        path = options.work / "many.nml"
        path.write_text(deck, encoding="utf-8")
        answer = limited(options, ["--grains", path], 8000)
        assert answer.returncode == 2, answer.stdout
        assert re.search(r"many\.nml:1: error: &grains: the run needs about .*fewer grains.*\[R134\]", answer.stdout)


def test_no_state_of_a_point(options):
    """Would catch a table with numbers that are not finite, and exit code 0."""
    deck = (f"&material name = 'm'  {ELASTIC} /\n&point path = 'shear'  strain = 1e300  steps = 10 /\n")
    path = options.work / "point.nml"
    path.write_text(deck, encoding="utf-8")
    answer = subprocess.run([options.scree, "--point", path, "-o", options.work / "point"], text=True, check=False,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert answer.returncode == 4, answer.stdout
    assert "the state of the material point is not finite in row" in answer.stdout
    table = np.genfromtxt(options.work / "point/point_point.csv", delimiter=",", names=True)
    assert all(np.isfinite(table[name]).all() for name in table.dtype.names)
