# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/talk.md and print its numbers.

    python test/verify/draw_talk.py --scree build/bin/scree --work FOLDER [--only WORD]

runs what is not there yet below FOLDER and writes doc/theory/figures/talk_*.png. On one core crater, flags, erosion and
spall take a minute, rod and cell a few minutes each, cloud twenty.
"""

import argparse
import json
import subprocess

import matplotlib
import numpy as np
from matplotlib import pyplot
from matplotlib.colors import to_rgb

import _support
import case
import scree_post
import space
from draw_bodies import STYLE
from scree.drawing import page, surface, view, view_options
from scree.drawing.areal_density import radiograph
from scree.drawing.radiograph_page import exposure
from scree.drawing.shape import particle_size
from scree_post import panel
from scree_post.command import main as main_of_post
from scree_post.grains import memory, relaxation, rheology
from scree_post.grains.cell_run import read_run

matplotlib.use("Agg")
INPUT = case.ROOT / "input"
JITTER = {"body[sphere].packing": "jitter", "body[sheet].packing": "jitter"}
# A bar whose middle third fails at once, carried through 100 cells.
FLAGS = """
&run  dimension='1d' /
&units  system='si' /
&grid  lo=0,0,0  hi=170,1,1  dx=1 /
&time  t_end=10 /
&effects  damage=.true.  artificial_viscosity=.false. /
&material  name='strong'  density=1000  bulk=1.0e5  shear=1.0e4 /
&material  name='weak'  density=1000  bulk=1.0e5  shear=1.0e4  damage_model='principal_stress'  failure_stress=1.0e-3 /
&region  name='left'   shape='box'  lo=5,0,0  hi=25,1,1 /
&region  name='middle' shape='box'  lo=25,0,0  hi=45,1,1 /
&region  name='right'  shape='box'  lo=45,0,0  hi=65,1,1 /
&body  name='left'  region='left'  material='strong'  velocity=10,0,0 /
&body  name='middle'  region='middle'  material='weak'  velocity=10,0,0  velocity_formula='1.0e-4*(x-35)','0','0' /
&body  name='right'  region='right'  material='strong'  velocity=10,0,0 /
&output  name='p'  kind='particles'  count=10  fields='failed','mass','velocity','volume' /
"""
# An aluminium flyer, a target that spalls, and a wall behind it that closes the spall again.
SPALL = """
&run  dimension='1d' /
&units  system='mm-us-mg' /
&grid  lo=-3,0,0  hi=4.6,1,1  dx=0.05 /
&time  t_end=4 /
&effects  damage=.true.  voids=.true.  thermal=.true. /
&material  name='al'  preset='al_6061_t6'  alpha_m='{rule}'  critical_packing={packing}  b_thermal={expansion} /
&region  name='flyer'  shape='box'  lo=-2,0,0  hi=0,1,1 /
&region  name='target' shape='box'  lo=0,0,0  hi=4,1,1 /
&body  name='flyer'  region='flyer'  material='al'  ppc=2,1,1  velocity=0.6,0,0 /
&body  name='target'  region='target'  material='al'  ppc=2,1,1 /
&boundary  face='xhi'  type='slip' /
&output  name='p'  kind='particles'  every=3  precision='double'
  fields='failed','mass','volume','solid_fraction','temperature','pressure','velocity' /
"""
# A quarter of a rod of soda-lime glass that takes time to fail (README of input/glass_rod), against its mirror image.
APPROACH = 543.0                           # speed of the two rods towards each other [m/s]: 4 GPa at first contact
ROD = f"""
&run  dimension='3d' /
&units  system='mm-us-mg' /
&grid  lo=0,0,0  hi=10,10,62.5  dx=0.3125 /
&time  t_end=10 /
&effects  damage=.true.  thermal=.true. /
&material  name='glass'  preset='glass_borosilicate'  density=2.53  bulk=45.4  shear=30.4
  failure_stress=0.6  failure_shear=0.7  failure_delay=0.3  failure_delay_power=2 /
&region  name='rod'  shape='cylinder'  centre=0,0,30  radius=5  height=60 /
&body  name='rod'  region='rod'  material='glass'  packing='jitter'  velocity=0,0,{-0.5e-3 * APPROACH} /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='ylo'  type='symmetry' /
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  dt=0.5  fields='mass','volume','velocity','failed','damage' /
"""
# The cell of discs of input/grain_cell with three of its stages: slow shear, reversal, stop.
SEEDS = (7, 8, 9, 10)
CELL = """
&grains
  shape = 'discs'   number = 600   diameter = 1 mm   spread = 0.2   density = 2500
  stiffness = 1.0e6   tangential_ratio = 0.5   restitution = 0.5   friction = 0.4
/
&cell  pressure = 1 kPa   seed = 7 /
&stage  name = 'compress'  servo = 'isotropic'  duration = 0.15  quiet = 1.0e-4  rows = 50  /
&stage  name = 'shear'     servo = 'y'  inertial_number =  0.01  strain = 4  rows = 800  snapshots = 20 /
&stage  name = 'reverse'   servo = 'y'  inertial_number = -0.01  strain = 3  rows = 600  snapshots = 10 /
&stage  name = 'stop'      servo = 'y'  duration = 0.06  rows = 600  /
"""


class Result:
    """A finished run: its summary and snapshots."""

    def __init__(self, options, name, deck, values=(), words=()):
        self.folder, self.name = options.work / name, name
        self.folder.mkdir(parents=True, exist_ok=True)
        if "\n" in str(deck):
            (self.folder / "deck.nml").write_text(deck, encoding="ascii")
            deck = self.folder / "deck.nml"
        if not (self.folder / f"{name}.summary.json").exists():
            sets = [word for key, value in dict(values).items() for word in ("-s", f"{key}={value}")]
            done = subprocess.run([options.scree, *words, "-q", "--overwrite", "--case", name, "--outdir", self.folder,
                                   *sets, deck], capture_output=True, text=True, check=False)
            if done.returncode:
                raise SystemExit(f"{name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")

    @property
    def ledger(self):
        """The balances at the end."""
        return json.loads((self.folder / f"{self.name}.summary.json").read_text(encoding="utf-8"))["ledger"]

    @property
    def series(self):
        """Times and files of the snapshots."""
        return scree_post.series(str(self.folder / f"{self.name}_p.hdf.series"))

    def near(self, moment):
        """The snapshot nearest to a time [s]."""
        return scree_post.snapshot(min(self.series, key=lambda frame: abs(frame[0] - moment))[1])

    @property
    def snaps(self):
        """All snapshots."""
        return [scree_post.snapshot(file) for _, file in self.series]


def carried(flag, cells, courant, limiter):
    """A flag on a grid after it moved that many cells: first order upwind, or second order with the limiter of van
    Leer."""
    for _ in range(round(cells / courant)):
        left, right = flag - np.roll(flag, 1), np.roll(flag, -1) - flag
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.where(left * right > 0.0, 2.0 * left * right / (left + right), 0.0) if limiter else 0.0 * flag
        flux = courant * (flag + 0.5 * (1.0 - courant) * slope)
        flag = flag - flux + np.roll(flux, 1)
    return flag


def flags(options):
    """The flag of a broken part that moves through 100 cells, on particles and on a grid."""
    snap = Result(options, "flags", FLAGS).snaps[-1]
    place, failed = snap.points[:, 0], snap.fields["failed"]
    order = np.argsort(place)
    grid = ((np.arange(170) >= 25) & (np.arange(170) < 45)).astype(float)
    figure, axes = pyplot.subplots(figsize=(8.0, 2.8))
    middle = np.arange(170) + 0.5
    for limiter, name, style in ((False, "grid, first order", "C1--"), (True, "grid, second order", "C2-")):
        moved = carried(grid, 100, 0.5, limiter)
        mixed = (moved > 0.01) & (moved < 0.99)
        print(f"flags: {name}: {mixed.sum()} cells between 0.01 and 0.99, greatest {moved.max():.3f}, "
              f"whole {np.sum(moved >= 0.99)} of 20")
        axes.plot(middle, moved, style, label=name)
    axes.plot(place[order], failed[order], "C0.", markersize=3, label="particles")
    print(f"flags: particles neither 0 nor 1: {np.sum((failed != 0) & (failed != 1))}; failed {np.sum(failed == 1)}")
    axes.set(xlabel="x [cells]", ylabel="flag of failure", xlim=(100, 170))
    axes.legend()
    _support.save(figure, "talk_flags")


def share(ledger, name):
    """What was removed, over the start."""
    start = ledger["start"]["kinetic" if name == "energy" else name]
    return ledger["end"][f"removed_{name}"] / start


def erosion(options):
    """Mass and momentum that a scheme loses which deletes what has failed."""
    figure, places = pyplot.subplots(2, 2, figsize=(8.0, 5.6), width_ratios=(1, 2.4))
    scenes = (("rod", "glass_rod", {"output[rod].dt": 3}, {"xlim": (-11, 11), "ylim": (0, 62)}, 6.0e-6),
              ("cloud", "debris_cloud", {"grid.dx": 0.31, "output[cloud].dt": 5, "time.t_end": 10, **JITTER},
               {"xlim": (-45, 75), "ylim": (-25, 25)}, 10.0e-6))
    for column, (name, scene, values, limits, moment) in enumerate(scenes):
        for row, (kind, extra) in enumerate((("kept", {}), ("eroded", {"effects.erosion": ".true."}))):
            run = Result(options, f"{name}_{kind}", INPUT / scene / "scene.nml", {**values, **extra})
            books, snap = run.ledger, run.near(moment)
            whole = snap.fields["mass"]
            behind = (snap.points[:, 2] > 2.0e-3) & (snap.fields["velocity"][:, 2] > 0.0)
            print(f"erosion: {name} {kind}: removed mass {share(books, 'mass'):.3f}, momentum "
                  f"{share(books, 'momentum_z'):.3f}, energy {share(books, 'energy'):.3f}; momentum at the end "
                  f"{books['end']['momentum_z'] / books['start']['momentum_z']:.3f}; behind the sheet "
                  f"{np.sum((whole * snap.fields['velocity'][:, 2])[behind]) / abs(books['start']['momentum_z']):.3f}; "
                  f"mass error {books['mass_error']:.1e}, momentum error {books['momentum_error']:.1e}")
            axes, failed = places[row, column], snap.fields["failed"] > 0.5
            # the scene with its mirror image; the cloud flies to the right
            spots, image = ([0, 2], (-1, 1)) if name == "rod" else ([2, 0], (1, -1))
            middle = np.concatenate([snap.points[:, spots], snap.points[:, spots] * image])
            size, failed = np.tile(particle_size(snap), 2), np.tile(failed, 2)
            tints = np.where(failed[:, None], to_rgb("#e69f00"), to_rgb("#0072b2"))
            axes.set(**limits)
            whole = np.flatnonzero(~failed) if name == "cloud" else np.arange(len(failed))
            dots = np.ones(len(failed), bool)
            dots[whole] = surface.draw(axes, middle[whole], size[whole, None, None] * np.eye(2), size[whole],
                                       tints[whole])
            axes.scatter(*1e3 * middle[dots].T, s=0.5, c=tints[dots], linewidths=0, rasterized=True)
            axes.set_aspect("equal")
            axes.grid(visible=False)
            axes.set_title(f"{'failed particles stay' if row == 0 else 'failed particles are deleted'}", fontsize=8)
            axes.set(xlabel="r [mm]" if name == "rod" else "z [mm]", ylabel="z [mm]" if name == "rod" else "r [mm]")
    places[0, 1].legend(handles=panel.patches({"intact": "#0072b2", "failed": "#e69f00"}), loc="upper left", fontsize=7)
    _support.save(figure, "talk_erosion")


def law_of(solid, pressure, rise, packing):
    """Alpha of the rule `crush` in each interval between snapshots, NaN where the rule changes in the interval."""
    states = []
    for theta, press in ((solid[:-1], pressure[:-1]), (solid[1:], pressure[1:])):
        crushed = np.where(rise < 0.0, np.maximum(theta - packing, 0.0) / max(1.0 - packing, 1.0e-12), 1.0)
        states.append((press > 0.0, np.where(press > 0.0, crushed, 0.0)))
    turned = np.sign(rise) != np.sign(np.roll(rise, 1))
    same = (states[0][0] == states[1][0]) & ~turned & ~np.roll(turned, -1)
    return np.where(same, 0.5 * (states[0][1] + states[1][1]), np.nan)


def spall(options):
    """Alpha and B of a spall that opens and is closed again, measured on its particles."""
    figure, panels = pyplot.subplots(4, 1, figsize=(8.0, 7.6), sharex=True)
    for rule, packing, expansion, tint in (("open_when_failed", 1.0, 0.0, "C0"), ("crush", 0.8, 7.0e-5, "C1")):
        snaps = Result(options, f"spall_{rule}", SPALL.format(rule=rule, packing=packing, expansion=expansion)).snaps
        theta = np.array([snap.fields["solid_fraction"] for snap in snaps])
        row = int(np.argmax(theta[-1] - theta.min(axis=0)))
        time = 1e6 * np.array([snap.time for snap in snaps])
        volume, solid, heat, pressure, failed = (np.array([snap.fields[name][row] for snap in snaps]) for name in (
            "volume", "solid_fraction", "temperature", "pressure", "failed"))
        rise, closed = np.diff(np.log(volume)), np.diff(np.log(solid))
        law = law_of(solid, pressure, rise, packing)
        own = expansion * np.diff(heat)                  # B dt of heat
        with np.errstate(divide="ignore", invalid="ignore"):
            alpha = 1.0 + (closed - own) / rise          # d ln theta = (alpha - 1) d ln V + B dt
        loose = (failed[1:] == 1) & (failed[:-1] == 1) & (np.abs(rise) > 1.0e-4)
        middle = 0.5 * (time[1:] + time[:-1])
        panels[0].plot(time, solid, color=tint, label=f"alpha_m = '{rule}'")
        panels[1].plot(middle[loose], alpha[loose], ".", color=tint, markersize=3)
        panels[3].plot(time, 1e-9 * pressure, color=tint)
        opening = loose & (rise > 0.0) & (pressure[1:] <= 0.0) & (pressure[:-1] <= 0.0)
        print(f"spall: {rule}: fails at {time[np.argmax(failed)]:.2f} us, least solid fraction {solid.min():.3f} at "
              f"{time[np.argmin(solid)]:.2f} us, at the end {solid[-1]:.3f}; alpha while it opens within "
              f"{np.abs(alpha[opening]).max():.0e}; greatest pressure after closing "
              f"{1e-9 * pressure[np.argmin(solid):].max():.2f} GPa; heated by "
              f"{heat[-1] - heat[np.argmax(failed)]:.0f} K")
        if rule == "open_when_failed":
            first, last = np.flatnonzero((failed == 1) & (solid < 0.99))[0], int(np.argmin(solid))
            kept = (solid * volume)[first:last]
            print(f"spall: solid volume while it opens: range over mean {np.ptp(kept) / kept.mean():.1e}")
            continue
        crushed = loose & (law > 0.0) & (law < 1.0)
        panels[1].plot(middle[crushed], law[crushed], "k_", markersize=5, label="law, crushed")
        print(f"spall: crushed intervals {crushed.sum()}: alpha less law, median "
              f"{np.median(np.abs(alpha - law)[crushed]):.4f}, greatest {np.abs(alpha - law)[crushed].max():.4f}")
        whole = np.isfinite(law) & (failed[1:] == 1) & (failed[:-1] == 1)
        found, wanted = (closed - (law - 1.0) * rise)[whole], own[whole]
        span = np.diff(time)[whole]
        panels[2].plot(middle[whole], found / span, ".", color=tint, markersize=3, label="measured")
        panels[2].plot(middle[whole], wanted / span, "k_", markersize=4, label="b_thermal dT/dt")
        print(f"spall: B dt in {whole.sum()} intervals: sum {found.sum():.5f}, of heat {wanted.sum():.5f}, rms of the "
              f"difference {np.sqrt(np.mean((found - wanted) ** 2)):.1e}, rms of it {np.sqrt(np.mean(wanted**2)):.1e}")
    for axes, label in zip(panels, ("solid fraction", r"$\alpha$", "B [1/us]", "pressure [GPa]")):
        axes.set_ylabel(label)
        if axes is not panels[3]:
            axes.legend(loc="center left")
    panels[1].set_ylim(-0.1, 1.1)
    panels[2].set_ylim(-0.03, 0.08)                      # without the interval in which grains touch
    panels[3].set_xlabel("time [us]")
    _support.save(figure, "talk_spall")


def picture(run, name, *words):
    """A picture by scree-post for the pages, with the surface of what holds together."""
    path = _support.FIGURES / f"{name}.png"
    with matplotlib.rc_context({"axes.grid": False}):
        main_of_post(["picture", str(run.folder / f"{run.name}_p.hdf.series"), "--surface", "--out", str(path), *words])
    scree_post.make_small(path)


def crater(options):
    """A crater in aluminium while it grows: the row crater_6061 of the validation."""
    run = Result(options, "crater", INPUT / "validation/craters/deck.nml", {
        "time.t_end": "10 us", "output[crater].fields": "'volume','mass','velocity','body'"})
    picture(run, "talk_crater", "--colour", "body", "--time", "6us", "--title", "", "--no-walls",
            "--view", "-20mm", "20mm", "-16mm", "12mm")


def cloud(options):
    """Radiographs of the cloud with a jittered start, to scale: in space, and axisymmetric; numbers of the latter."""
    run = Result(options, "cloud", INPUT / "debris_cloud/scene.nml", {**JITTER, "output[cloud].dt": 5})
    deck, values = space.RUNS["quarter"]
    whole = Result(options, "quarter", INPUT / "debris_cloud" / deck, values)
    frames = [radiograph(near(10.0e-6), 0.2e-3) for near in (whole.near, run.near)]
    absorption = exposure(frames[0])
    figure, places = pyplot.subplots(1, 2, figsize=(8.0, 3.7), sharey=True)
    for axes, frame, name in zip(places, frames, ("three dimensions", "axisymmetric")):
        axes.imshow(np.exp(-absorption * frame.sigma), extent=[1e3 * edge for edge in frame.box], origin="lower",
                    cmap="gray", vmin=0.0, vmax=1.0, interpolation="antialiased")
        axes.set(xlabel="z [mm]", xlim=(-36, 68), ylim=(-44, 44), aspect="equal")
        axes.set_title(f"{name}, {1e6 * frame.time:.3g} us after the impact")
        axes.grid(visible=False)
    places[0].set_ylabel("x [mm]")
    _support.save(figure, "talk_cloud")
    scree_post.make_small(_support.FIGURES / "talk_cloud.png")
    last = run.near(20.0e-6)
    whole = (last.fields["body"] == 2) & (last.fields["failed"] < 0.5)
    order = np.argsort(last.points[whole, 0])[::-1]
    mass = np.cumsum(last.fields["mass"][whole][order])
    hole = 2.0 * last.points[whole, 0][order][np.searchsorted(mass, 0.9995 * mass[-1])]
    edges = []
    for snap in (run.near(15.0e-6), last):
        flying = (snap.fields["velocity"][:, 2] > 300.0) & (snap.points[:, 2] > 0.0)
        order = np.argsort(snap.points[flying, 2])[::-1]
        mass = np.cumsum(snap.fields["mass"][flying][order])
        edges.append(snap.points[flying, 2][order][np.searchsorted(mass, 1.0e-3 * mass[-1])])
    speed = (edges[1] - edges[0]) / (last.time - run.near(15.0e-6).time)
    print(f"cloud: hole {1e3 * hole:.1f} mm, leading edge {speed / 6710.0:.3f} V, at {1e3 * edges[1]:.1f} mm; errors "
          f"of momentum {run.ledger['momentum_error']:.0e}, energy {run.ledger['energy_error']:.0e}")


def rod(options):
    """A quarter of the glass rod in space; the speed of its front."""
    run = Result(options, "rod", ROD, words=())
    places = []
    for snap in run.snaps:
        layer = (snap.points[:, 2] / 1.0e-3).astype(int)
        whole = np.bincount(layer)
        failed = np.bincount(layer, weights=snap.fields["failed"], minlength=len(whole))
        broken = np.flatnonzero(failed > 0.1 * np.maximum(whole, 1))
        places.append((snap.time, 1.0e-3 * (broken.max() + 1) if len(broken) else 0.0))
    time, place = np.array(places).T
    chosen = (place > 0.010) & (place < 0.040)
    speed = np.polyfit(time[chosen], place[chosen], 1)[0] + 0.5 * APPROACH
    print(f"rod: front in the glass {speed:.0f} m/s from {chosen.sum()} times; failed at the end "
          f"{run.snaps[-1].fields['failed'].mean():.3f}; momentum error {run.ledger['momentum_error']:.1e}")
    figure, places = pyplot.subplots(3, 1, figsize=(8.0, 4.6), sharex=True)
    words = page.options(colour="failed", surface=True, keep="y<0", camera="14,12", up="x", no_walls=True, dpi=200,
                         view=(-0.062, 0.062, -0.011, 0.011))
    pages = view_options.pages(words, [run.series[-1][1]])
    for axes, moment in zip(places, (3.0e-6, 6.0e-6, 9.0e-6)):
        snap = run.near(moment)
        axes.imshow(pages.balls(view.matter(snap, pages.options), 0.0, snap), extent=[-62, 62, -11, 11])
        axes.set(ylabel="mm", aspect="equal")
        axes.set_title(f"{1e6 * snap.time:.0f} us after the impact", fontsize=8)
        axes.grid(visible=False)
    places[0].legend(handles=panel.patches({"intact": "#0072b2", "failed": "#e69f00"}), loc="upper right", fontsize=7)
    places[-1].set_xlabel("mm")
    _support.save(figure, "talk_rod")
    scree_post.make_small(_support.FIGURES / "talk_rod.png")


def cell(options):
    """The relaxation law and cells of discs on one path: shear, reversal, stop."""
    figure, panels = pyplot.subplots(1, 3, figsize=(9.0, 3.4), sharey=True)
    runs = [read_run(str(Result(options, f"cell_{seed}", CELL, {"cell.seed": seed}, words=("--grains",)).folder))
            for seed in SEEDS]
    generator = np.random.default_rng(1)
    shears = [[rheology.steady_shear(run, stage, 1.0, generator) for stage in run.stages_of("shear")] for run in runs]
    found = [one for run, own in zip(runs, shears) for one in memory.measure_memory(run, own, 1.0, generator)]
    strains = {name: [one.strain for one in found if one.measure == name and np.isfinite(one.strain)]
               for name in ("survival", "reversal", "correlation")}
    steady = np.mean([one.mu for own in shears for one in own])
    print(f"cell: friction {steady:.4f}, of single stages {np.std([one.mu for own in shears for one in own]):.4f}")
    for name, values in strains.items():
        print(f"cell: contact strain by {name}: {np.mean(values):.4f} +- {np.std(values) / len(values) ** 0.5:.4f}")
    names = {stage.name: [next(one for one in run.stages if one.name == stage.name) for run in runs]
             for stage in runs[0].stages}
    for axes, kind, sign in zip(panels, ("shear", "reverse", "stop"), (1.0, 1.0, -1.0)):
        stages = names[kind]
        time = stages[0].middle()
        across = time * abs(stages[0].rate) if kind != "stop" else 1e3 * time
        few = across < (0.6 if kind != "stop" else 30.0)
        curves = np.array([np.interp(across, stage.middle() * abs(stage.rate) if kind != "stop" else
                                     1e3 * stage.middle(), sign * stage.rows["stress_xy"] / 1.0e3) for stage in stages])
        mean, error = curves.mean(axis=0), curves.std(axis=0) / len(curves) ** 0.5
        axes.fill_between(across[few], (mean - 2 * error)[few], (mean + 2 * error)[few], color="C0", alpha=0.25, lw=0)
        axes.plot(across[few], mean[few], "C0", label=f"cells of discs, mean of {len(runs)}")
        for name, tint in (("survival", "C1"), ("reversal", "C2")):
            gamma = np.mean(strains[name])
            start = {"shear": 0.0, "reverse": 1j * steady, "stop": 1j * steady}[kind]
            direction = -1.0 if kind == "reverse" else 1.0
            law = relaxation.follow(start, 0.0 if kind == "stop" else direction, across,
                                    relaxation.shear_modulus(steady, gamma), gamma).imag
            axes.plot(across[few], law[few], tint, label=f"law, contact strain {gamma:.3f} ({name})")
            if kind == "stop":
                tau = 1e3 * gamma / abs(names["reverse"][0].rate)
                axes.plot(across[few], steady * np.exp(-across[few] / tau), "--", color=tint,
                          label=f"law with constant tau = {tau:.0f} ms")
            print(f"cell: {kind}: law with {name}: rms of the difference "
                  f"{np.sqrt(np.mean((law - mean)[few] ** 2)) / steady:.3f} of the steady stress; at the end law "
                  f"{law[few][-1] / steady:.2f}, cells {mean[few][-1] / steady:.2f} +- {error[few][-1] / steady:.2f}")
        axes.set_xlabel("strain" if kind != "stop" else "time since the stop [ms]")
        axes.set_title({"shear": "start", "reverse": "reversal", "stop": "stop"}[kind])
    panels[0].set_ylabel("shear stress / pressure")
    panels[1].legend(fontsize=6, loc="upper right")
    lines = [line for line in panels[2].get_lines() if line.get_linestyle() == "--"]
    panels[2].legend(handles=lines, fontsize=6, loc="lower right")
    _support.save(figure, "talk_cell")


def main():
    """All figures, or those whose name contains a word."""
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--only", default="")
    only, _ = parser.parse_known_args()
    options = case.arguments()
    with matplotlib.rc_context(STYLE):
        for draw in (crater, flags, erosion, spall, cloud, rod, cell):
            if only.only in draw.__name__:
                draw(options)


if __name__ == "__main__":
    main()
