# SPDX-License-Identifier: BSD-3-Clause
# tiers: full
# timeout: 200
"""Statistics of scree-post fragments: rotation and shape, bonds, distributions, comparisons, ensembles of seeds.

Snapshots with known answers; the last tests run a small bar with two cell sizes. The first line of each test states
which bug it would catch.
"""

import math

import numpy as np
import pytest
from scipy import optimize, stats

import scree_post
from post_command import call
from sample_snapshots import write
from scree_post import fragment_bonds, fragment_curves, fragment_table
from scree_post.fragment_curves import Sample
from scree_post.fragment_table import COLUMNS, Fragments

STEP = 1.0e-3            # width of a particle [m]
TITLES = [title.split(" [")[0] for title in COLUMNS]
BAR = """
&run  dimension='1d' /
&grid  lo=-1.001,0,0  hi=1.001,0.01,0.01  dx=3.64e-3 /
&time  t_end=80e-6 /
&effects  damage=.true.  size_scatter=.true. /
&material  name='glass'  density=2500  young=70e9  poisson=0  damage_model='principal_stress'
  failure_stress=300e6  weibull_m=10  weibull_volume=1e-6 /
&region  name='bar'  shape='box'  lo=-0.91,0,0  hi=0.91,0.01,0.01 /
&body  name='bar'  region='bar'  material='glass'  ppc=2,1,1  velocity_formula='50*x','0','0' /
&output  name='p'  kind='particles'  every=1000000 /
&checkpoint  at_end=.false. /
"""


def block(corner, cells):
    """Centres of the particles of a block."""
    axes = [STEP * (np.arange(count) + 0.5) for count in cells]
    return np.array(corner, float) + np.stack([g.ravel() for g in np.meshgrid(*axes, indexing="ij")], axis=1)


def snap_of(path, points, dimension="3d", symmetry="", time=1.0e-6, echo="", **fields):
    """A snapshot of particles of one width; fields not given are those of intact matter of one body at rest."""
    count = len(points)
    volume = 2.0 * math.pi * points[:, 0] * STEP ** 2 if dimension == "axisymmetric" else np.full(count, STEP ** 3)
    if dimension == "plane_strain":
        volume = volume / STEP                           # 1 m thick
    every = {"mass": (1000.0 * volume, "kg"), "volume": (volume, "m3"), "velocity": (np.zeros((count, 3)), "m/s"),
             "body": (np.ones(count, "i4"), "1"), "failed": (np.zeros(count), "1"),
             "identity": (np.arange(1, count + 1), "1"), **{name: (values, "1") for name, values in fields.items()}}
    snap = scree_post.snapshot(write(str(path), time, points, every, dimension=dimension, symmetry=symmetry))
    snap.echo = echo
    return snap


def row_of(found, place=0):
    """A row of the table by the names of its columns."""
    return dict(zip(TITLES, found.rows[place]))


def vector(row, name):
    """Three components of a row."""
    return np.array([row[f"{name}_{axis}"] for axis in "xyz"])


def lengths(row):
    """Lengths of the axes of a row."""
    return [row[f"axis_{number}"] for number in (1, 2, 3)]


def turned(axis, angle):
    """Matrix of a rotation."""
    from scipy.spatial.transform import Rotation
    return Rotation.from_rotvec(angle * np.array(axis) / np.linalg.norm(axis)).as_matrix()


def test_spin(options):
    """Spin of the orbit counted as rotation, inertia of the wrong axis, infinite spin of a particle or a line."""
    spin, speed = np.array([30.0, -20.0, 50.0]), np.array([100.0, 20.0, -5.0])
    points = block((0.01, 0.02, 0.03), (6, 3, 2)) @ turned((1, 2, 3), 0.7).T
    middle = points.mean(axis=0)
    lone = block((0.1, 0, 0), (1, 1, 1))
    line = block((0.2, 0, 0), (3, 1, 1))
    every = np.concatenate([points, line, lone])
    velocity = speed + np.concatenate([np.cross(spin, points - middle), np.cross(spin, line - line.mean(axis=0)),
                                       np.cross(spin, lone)])
    found = fragment_table.fragments_of(snap_of(options.work / "a.hdf", every, velocity=velocity), factor=1.3)
    assert [row[2] for row in found.rows] == [36, 3, 1]
    assert np.allclose(vector(row_of(found), "spin"), spin, rtol=1e-6), row_of(found)
    assert np.allclose(vector(row_of(found, 1), "spin"), spin * (0, 1, 1), rtol=1e-6, atol=1e-6), "about its own line"
    assert not vector(row_of(found, 2), "spin").any(), "a single particle"
    flat = block((0.01, 0, 0), (4, 1, 5)) * (1, 0, 1)
    turning = np.cross((0.0, 7.0, 0.0), flat - flat.mean(axis=0))
    for dimension, right in (("plane_strain", (0.0, 7.0, 0.0)), ("axisymmetric", (0.0, 0.0, 0.0))):
        found = fragment_table.fragments_of(snap_of(options.work / "a.hdf", flat, dimension, velocity=turning))
        assert np.allclose(vector(row_of(found), "spin"), right, rtol=1e-6), f"{dimension}: {row_of(found)}"


def test_axes(options):
    """Axes without the size of the particles, in the wrong order or of the wrong direction; a wrong temperature."""
    box, turn = (7, 4, 2), turned((3, -1, 2), 0.9)
    points = block((0, 0, 0), box) @ turn.T
    warm = np.linspace(300.0, 500.0, len(points))
    found = fragment_table.fragments_of(snap_of(options.work / "a.hdf", points, temperature=warm))
    row = row_of(found)
    # second moment of a box of edge a: a^2/12; of an ellipsoid of length l: l^2/20
    assert np.allclose(lengths(row), STEP * math.sqrt(20 / 12) * np.array(box), rtol=1e-6)
    assert abs(abs(vector(row, "long") @ turn[:, 0]) - 1.0) < 1e-9
    assert abs(abs(vector(row, "short") @ turn[:, 2]) - 1.0) < 1e-9
    assert abs(row["temperature"] - warm.mean()) < 1e-4
    one = row_of(fragment_table.fragments_of(snap_of(options.work / "a.hdf", block((0, 0, 0), (1, 1, 1)))))
    assert abs(one["axis_3"] - STEP * math.sqrt(20 / 12)) < 1e-9 and math.isnan(one["temperature"])
    flat = block((1e-3, 0, 0), (3, 1, 6)) * (1, 0, 1)    # near the axis, where rings of the same width differ in mass
    for dimension in ("plane_strain", "axisymmetric"):
        row = row_of(fragment_table.fragments_of(snap_of(options.work / "a.hdf", flat, dimension)))
        assert np.allclose(lengths(row), STEP * math.sqrt(16 / 12) * np.array((6, 3, 0)), rtol=1e-6), dimension
        assert np.allclose(vector(row, "long"), (0, 0, 1)) and np.allclose(vector(row, "short"), (1, 0, 0))


def sizes(found):
    """Numbers of particles, the heaviest fragment first."""
    return [row[2] for row in found.rows]


def test_bonds(options):
    """Pieces that touch again joined, bodies that touch joined, intact material cut, new neighbours bonded."""
    first, second = block((0, 0, 0), (3, 3, 4)), block((0, 0, 4 * STEP), (3, 3, 3))
    points = np.concatenate([first, second])
    body = np.repeat([1, 2], [len(first), len(second)]).astype("i4")
    start = snap_of(options.work / "a.hdf", points, time=0.0, body=body)
    bonds = fragment_table.reference_bonds(start, 1.5, 2.0)
    random = np.random.default_rng(5).permutation(len(points))

    def later(moved, failed=None):
        return snap_of(options.work / "b.hdf", moved[random], body=body[random], identity=random + 1,
                       failed=np.zeros(len(points)) if failed is None else failed[random])

    assert sizes(fragment_table.fragments_of(later(points))) == [63], "by distance they are one"
    found = fragment_table.fragments_of(later(points), bonds=bonds)
    assert sizes(found) == [36, 27] and "bonds" in found.note
    moved = points.copy()                                # the upper layers of the first body are now at its edge
    upper = np.flatnonzero((body == 1) & (points[:, 2] > 2 * STEP))
    moved[upper] += (3 * STEP, 3 * STEP, -2 * STEP)
    assert sizes(fragment_table.fragments_of(later(moved))) == [36, 27]
    assert sizes(fragment_table.fragments_of(later(moved), bonds=bonds)) == [27, 18, 18]
    stretched = points * 1.9                             # apart by less than the limit: one piece, if nothing else
    assert sizes(fragment_table.fragments_of(later(stretched))) == [1] * 63
    assert sizes(fragment_table.fragments_of(later(stretched), bonds=bonds)) == [36, 27]
    assert sizes(fragment_table.fragments_of(later(points * 2.1), bonds=bonds)) == [1] * 63
    failed = (abs(points[:, 2] - 1.5 * STEP) < 1e-6).astype(float)
    found = fragment_table.fragments_of(later(points, failed), bonds=bonds)
    assert sizes(found) == [27, 18, 9] and abs(found.failed / found.total - 9 / 63) < 1e-9


def test_split_and_absent(options):
    """Halves of split particles without bonds, halves that are never separated, inflow taken as a fragment."""
    points = block((0, 0, 0), (4, 1, 1))
    bonds = fragment_table.reference_bonds(snap_of(options.work / "a.hdf", points, time=0.0), 1.5, 2.0)
    place = 1 << fragment_bonds.ROOT_BITS
    halves = np.array([1, 2 + 4 * place, 2 + 5 * place, 2 + 3 * place, 3, 4, 99])    # 2 has split, its first half again
    x = STEP * np.array([0.5, 1.3, 1.5, 1.7, 2.5, 3.5, 9.0])
    found = fragment_table.fragments_of(snap_of(options.work / "b.hdf", np.outer(x, (1, 0, 0)), identity=halves),
                                        bonds=bonds)
    assert sizes(found) == [6] and abs(found.absent / found.total - 1 / 7) < 1e-9, "99 is not in the reference"
    assert found.counts(8)[6] == found.absent
    x[3:6] += 2.1 * STEP                                 # the second half goes with 3 and 4
    found = fragment_table.fragments_of(snap_of(options.work / "b.hdf", np.outer(x, (1, 0, 0)), identity=halves),
                                        bonds=bonds)
    assert sizes(found) == [3, 3], found.rows
    late = fragment_table.reference_bonds(snap_of(options.work / "a.hdf", np.outer(x[1:4], (1, 0, 0)), time=0.0,
                                                  identity=halves[1:4]), 9.0, 2.0)
    assert list(fragment_bonds.ancestors(late, np.array([2 + 8 * place, 2 + 7 * place, 2]))) == [0, 2, -1]


def test_bonds_at_faces(options):
    """Bonds lost at a mirror plane or a periodic boundary, or kept there after separation."""
    points = block((0, 0, 0), (2, 1, 1))
    bonds = fragment_table.reference_bonds(snap_of(options.work / "a.hdf", points, symmetry="xlo", time=0.0), 1.5, 2.0)
    for shift, right in ((0.0, [4]), (2.0 * STEP, [2, 2])):
        found = fragment_table.fragments_of(snap_of(options.work / "b.hdf", points + (shift, 0, 0), symmetry="xlo"),
                                            bonds=bonds)
        assert sizes(found) == right and found.copies == 2
    echo = ("&grid\n lo = 0.0, 0.0, 0.0\n hi = 0.01, 0.01, 0.01\n dx = 0.002\n/\n"
            "&boundary\n face = 'zlo'\n type = 'periodic'\n/\n")
    points = np.concatenate([block((0, 0, 0), (1, 1, 2)), block((0, 0, 8 * STEP), (1, 1, 2))])
    bonds = fragment_table.reference_bonds(snap_of(options.work / "a.hdf", points, echo=echo, time=0.0), 1.5, 2.0)
    for shift, right in ((0.0, [4]), (3.0 * STEP, [4]), (1.2 * STEP, [2, 2])):
        moved = points.copy()
        moved[(slice(None) if shift > 2 * STEP else slice(0, 2)), 2] += shift        # all, or the lower two
        found = fragment_table.fragments_of(snap_of(options.work / "b.hdf", moved % 0.01, echo=echo), bonds=bonds)
        assert sizes(found) == right, f"{shift}: {found.rows}"


def drawn(masses, particle, total=None):
    """Fragments of given masses."""
    rows = [(0.0, place + 1, round(mass / particle), mass, *(0.0,) * (len(COLUMNS) - 4))
            for place, mass in enumerate(sorted(masses, reverse=True))]
    return Fragments(0.0, rows, total=total or float(np.sum(masses)), particle=particle)


def test_fits(options, sheet):
    """Fragments below the limit that are fitted, a wrong likelihood, a probability that is always large."""
    random, least = np.random.default_rng(7), 0.2
    sample = random.exponential(2.0, 500)
    found = {one.name: one for one in fragment_curves.fits(np.sort(sample[sample >= least]), least)}
    count = np.count_nonzero(sample >= least)
    sheet.below("scale of an exponential sample, in standard errors",
                abs(found["exponential"].scale / 2.0 - 1.0) * math.sqrt(count), 3.0)
    sheet.below("exponent of Weibull", abs(found["Weibull"].shape - 1.0), 0.2)
    sheet.above("p of the exponential", found["exponential"].probability, 0.05)
    for name in ("Mott", "power law"):
        sheet.below(f"p of {name}", found[name].probability, 0.01)
        sheet.above(f"AIC of {name}", found[name].aic - found["exponential"].aic, 10.0)
    above = stats.expon(loc=least, scale=found["exponential"].scale)
    sheet.near("distance to the exponential, by scipy", found["exponential"].distance,
               stats.kstest(sample[sample >= least], above.cdf).statistic, 1.0e-9)
    exact = np.exp(-(np.array([0.2, 1.0, 5.0]) - least) / found["exponential"].scale)
    sheet.require(np.allclose(found["exponential"].above(np.array([0.2, 1.0, 5.0])), exact), "curve of the fit")
    # Weibull by another parametrisation and a search in two dimensions, with the density of scipy
    sample = 3.0 * random.weibull(0.7, 300)
    sample = np.sort(sample[sample >= least])

    def minus(values):
        law = stats.weibull_min(values[0], scale=values[1])
        return -(law.logpdf(sample) - law.logsf(least)).sum()

    best = optimize.minimize(minus, (1.0, 1.0), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-10})
    one = fragment_curves.fit("Weibull", sample, least, None)
    sheet.below("Weibull: exponent and scale of another search", max(abs(one.shape / best.x[0] - 1.0), abs(
        one.scale / best.x[1] - 1.0)), 1.0e-4)
    sheet.near("its Akaike criterion", one.aic, 2.0 * best.fun + 4.0 - 2.0 * len(sample) * math.log(least), 1.0e-4)
    alpha = fragment_curves.fit("power law", least * (1.0 - random.uniform(size=500)) ** (-1 / 1.7), least, 0.0)
    sheet.below("exponent of a power law, in standard errors", abs(alpha.scale / 1.7 - 1.0) * math.sqrt(500), 3.0)
    sheet.require(fragment_curves.fits(np.ones(9), 0.5) == [], "nine fragments are not fitted")
    # under a true hypothesis small probabilities are as rare as they claim: 40 samples, 10 % below 0.1
    chances = [fragment_curves.fit("exponential", least + random.exponential(1.0, 30), least, 1.0).probability
               for _ in range(40)]
    sheet.below("samples of the law with p < 0.1", np.mean(np.array(chances) < 0.1), 0.1 + 3.0 * math.sqrt(0.09 / 40))
    sheet.above("p: the mean of a uniform one is 1/2", np.mean(chances), 0.5 - 3.0 / math.sqrt(12 * 40))


def test_comparison(options, sheet):
    """Curves that leave out failed mass, rounding taken as a difference, numbers without error, a wrong verdict."""
    random, particle = np.random.default_rng(2), 0.01
    one = Sample("a", [drawn([4.0, 3.0, 2.0], particle, 10.0)], [])
    other = Sample("b", [drawn([4.04, 2.0, 2.0], particle, 10.0)], [])
    gap, place = fragment_curves.greatest_gap(one, other, 0.1, 0.0)
    # a: 1 kg failed, curves 0.1, 0.3 from 2 kg, 0.6 from 3, 1 from 4; b: 0.196, 0.596 from 2, 1 from 4.04
    sheet.near("gap of two curves, between 4 and 4.04 kg", gap, 1.0 - 0.596, 1.0e-9)
    sheet.near("its place", place, 4.0, 1.0e-9)
    sheet.near("with shifted masses it is that from 2 to 3 kg",
               fragment_curves.greatest_gap(one, other, 0.1, 0.05)[0], 0.596 - 0.3, 1.0e-9)
    rounded = Sample("c", [drawn([4.0 * (1 + 2e-7), 3.0 * (1 - 2e-7), 2.0], particle, 10.0)], [])
    sheet.below("gap of rounding", fragment_curves.greatest_gap(one, rounded, 0.1, 0.0)[0], 1.0e-6)
    runs = {scale: Sample("", [drawn(random.exponential(scale, 60), particle) for _ in range(4)], [1, 2, 3, 4])
            for scale in (1.0, 1.0001, 2.0)}
    least = fragment_curves.resolved_mass(list(runs.values()), 8)
    sheet.near("resolved mass", least, 7.5 * particle, 1.0e-12)
    same, different = (fragment_curves.compared(runs[1.0], runs[scale], least) for scale in (1.0001, 2.0))
    sheet.require("do not differ" in fragment_curves.verdict(same), f"equal laws: {same}")
    sheet.require("masses differ" in fragment_curves.verdict(different), f"other laws: {different}")
    numbers = runs[1.0].numbers(least)
    sheet.require(same.numbers[0] == f"{numbers.mean():.5g} +- {numbers.std(ddof=1) / 2:.2g}", same.numbers[0])
    small = fragment_curves.compared(one, other, least)
    sheet.require("Too few" in fragment_curves.verdict(small) and small.paired == "", "three fragments are not tested")


@pytest.fixture(scope="module")
def bars(file_options):
    """A bar run with three seeds and two cell sizes by the command."""
    deck = file_options.work / "bar.nml"
    deck.write_text(BAR, encoding="utf-8")
    words = ("fragments", deck, "--seeds", "3", "--set", "grid.dx=3.64e-3,2.6e-3", "--bonds", "--fit", "--outdir",
             file_options.work / "out", "--scree", file_options.scree)
    answer = call(*words)
    assert answer.returncode == 0 and not answer.stderr, f"{answer.stdout} {answer.stderr}"
    return file_options, words, answer.stdout


def test_ensemble(bars):
    """Fragments of other runs or times, seeds that are not used, runs repeated, halves of a bar joined by chance."""
    options, words, text = bars
    base = options.work / "out" / "bar_seeds"
    for dx in ("3.64e-3", "2.6e-3"):
        table = scree_post.history(str(base / f"bar_dx_{dx}_seeds.csv"))
        assert list(table["seed"]) == [1, 2, 3] and len(set(table["largest"])) == 3, "seeds give other bars"
        every = scree_post.history(str(base / f"bar_dx_{dx}_pieces.csv"))
        for row, seed in enumerate((1, 2, 3)):
            series = base / f"dx_{dx}_seed_{seed}" / f"bar_dx_{dx}_seed_{seed}_p.hdf.series"
            last = scree_post.snapshot(scree_post.series(str(series))[-1][1])
            order = np.argsort(last.fields["identity"])
            intact = last.fields["failed"][order] < 0.5  # in one dimension fragments are runs of intact particles
            begins = np.flatnonzero(np.diff(np.concatenate([[0], intact.astype(int)])) == 1)
            assert table["fragments"][row] == len(begins) > 3, f"{dx} {seed}"
            heaviest = np.add.reduceat(np.where(intact, last.fields["mass"][order].astype("f8"), 0.0), begins).max()
            assert abs(table["largest"][row] / heaviest - 1.0) < 1e-6
            assert np.count_nonzero(every["seed"] == seed) == len(begins)
    assert text.count("done ") == 6 and "The distributions of the masses" in text and "Mott" in text
    assert (base / "bar_dx_3.64e-3_pieces.png").stat().st_size > 20000
    again = call(*words)
    assert again.returncode == 0 and again.stdout.count("there ") == 6 and "done " not in again.stdout
    assert again.stdout.split("bar, dx")[-1] == text.split("bar, dx")[-1]


def test_command(bars):
    """History without a snapshot, a comparison of a run with itself that differs, traceback for wrong options."""
    options, _, _ = bars
    one, two = (options.work / "out" / "bar_seeds" / f"dx_3.64e-3_seed_{seed}" for seed in (1, 2))
    answer = call("fragments", one, "--bonds", "--history", "--plot", "--resolved", "20")
    assert answer.returncode == 0, answer.stderr
    table = scree_post.history(str(one / "bar_dx_3.64e-3_seed_1_pieces_over_time.csv"))
    assert list(table["fragments"]) [0] == 1 and table["fragments"][-1] > 3 and len(table["time"]) == 2
    assert np.allclose(table["mass"], 2500.0 * 1.82e-4, rtol=1e-6) and table["failed"][0] == 0.0 < table["failed"][-1]
    assert (one / "bar_dx_3.64e-3_seed_1_pieces_over_time.png").is_file()
    same = call("fragments", one, one, "--out", options.work / "same.png")
    assert "differ by at most 0.0 % of the mass" in same.stdout and same.returncode == 0, same.stdout + same.stderr
    assert "differ by at most 0.0 %" not in call("fragments", one, two, "--out", options.work / "two.png").stdout
    last = next(one.glob("*_p_000001.hdf"))
    deck = options.work / "bar.nml"
    text = (options.work / "fixed.nml")
    text.write_text(BAR.replace("size_scatter=.true.", "").replace("t_end=80e-6", "t_end=1e-6").replace(
        "weibull_m=10  weibull_volume=1e-6", ""), encoding="utf-8")
    fixed = call("fragments", text, "--seeds", "2", "--outdir", options.work / "out", "--scree", options.scree)
    assert "nothing in this deck depends on the seed" in fixed.stdout, fixed.stdout + fixed.stderr
    for words, code, *parts in (
            ((last, "--bonds"), 2, "--bonds needs a series"), ((one, "--bonds", "--cell", "1mm"), 2, "--cell"),
            ((one, "--stretch", "3"), 2, "--bonds"), ((one, "--bonds", "--stretch", "1"), 2, "above 1"),
            ((one, two, two), 2, "3 sources"), ((one, two, "--all"), 2, "for one run"),
            ((one, "--plot"), 2, "--history"), ((one, "--jobs", "2"), 2, "--jobs needs --seeds"),
            ((deck,), 2, "is a deck", "--seeds"), ((deck, "--seeds", "1", "--outdir", deck), 3, "cannot make"),
            ((deck, "--seeds", "0"), 2, "--seeds"),
            ((deck, "--seeds", "2", "--set", "grid.dx=1,2,3"), 2, "3 ensembles"),
            ((deck, "--seeds", "2", "--set", "run.seed=1"), 2, "--seeds"),
            ((deck, deck, "--seeds", "2"), 2, "name bar"), ((options.work / "no.nml", "--seeds", "2"), 3, "no.nml")):
        answer = call("fragments", *words)
        said = answer.stderr.strip().splitlines()
        assert answer.returncode == code and len(said) == 1, f"{words}: {answer.returncode} {said}"
        assert all(part in said[0] for part in parts), f"{parts} not in {said[0]}"
