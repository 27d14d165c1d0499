# SPDX-License-Identifier: BSD-3-Clause
"""Contact of bodies with separate velocity fields: bodies touch when their surfaces meet, slide, separate, and break
bonds.

Would catch: contact that acts as soon as bodies share nodes; an inclined normal at the edge of a body, so that a block
without friction is decelerated (by 23 % with the mean of the areas); contact forces that pull bodies together after the
wave has returned; friction that is not mu times the normal force, or acts without one; contact forces of several bodies
at a node whose sum is not zero; light or soft material next to material of a million times its density or stiffness
that becomes unstable; heat of contact that is not recorded; bonds that break at another stress, in another cell than
the separated one, or form again; a single body that changes because contact is on; particles that are split by the
growth of another velocity field or by none; and snapshots with the numbers of stores in place of those of materials.

Limits. Two elastic discs (cells of 0.025 m): the first force comes at most a tenth of a cell early, as particles count
as cubes (doc/theory/contact.md), and at most half a cell late, the size of a particle. Energy: target 2 %, and 1 % with
half the cell size, because the inelastic impact of the first layer of nodes takes a fraction of the order of a cell;
kinetic energy after the rebound: that of fine runs (test_two_discs.py) within the same limits. The discs with half the
cell size miss 1 % by a little, and `usl`, which strains with velocities that particles do not get, misses all targets:
known misses, held at a tenth of the energy. Error of the energy balance with the heat of contact: half of the targets;
a quarter where particles keep their velocity, since the work of the contact forces at the velocities of the nodes has
an error of 1.3 %. Sliding block: gravity is applied suddenly, and until shear waves have crossed the floor, the floor
falls along with the block without slip, so the block is subject to friction for less than 0.4 s. After 0.04 s, four
times that crossing time, it slides, and Newton's law for the whole block says that its position along the floor plus mu
times its position normal to it has the acceleration g (sin - mu cos), however it bounces: target 1e-3. Blocks that
stick vibrate in shear: at most the speed of free fall after the time of a shear wave through their height, 2.6 % of
the final speed. Bars of equal impedance transfer all of their velocity: the remainder is at most that of the one cell
of a bar at the surface, 2 %. A light bar rebounds from a heavy one with its whole speed: 2 % for the same reason in
both directions. Bonds: the velocities of one body, or, if they break, the full velocities, within 2 % of the speed of
the impact, one cell.
"""
# tiers: smoke, full

import h5py
import numpy as np
import pytest

import bodies
import case
import slope

TARGET, REBOUND = 0.02, 0.888          # energy of the discs; kinetic energy after the rebound in fine runs
LAYER = 0.02                           # a cell of the bars over their length
SHEARED = 0.2 / 19.6                   # time of a shear wave through the height of the block [s]
SETTLED = 0.039                        # four times the shear wave through the floor, 0.2 m at 19.6 m/s [s]
CONTACT = "artificial_viscosity=.false.  contact=.true."
FIELDS = "fields='identity','body','mass','velocity'  precision='double'"

SLIDE = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,0  hi=1.2,1,0.5  dx=0.05 /
&time  t_end=0.4 /
&method {words} /
&effects  {contact}  gravity=.true.  gravity_vector={along!r},0,{down!r} /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&region  name='floor'  shape='box'  lo=0,0,0  hi=1.2,1,0.2 /
&region  name='block'  shape='box'  lo=0.2,0,0.2  hi=0.6,1,0.4 /
&body  name='floor'  region='floor'  material='m'  ppc=2,1,2 /
&body  name='block'  region='block'  material='m'  ppc=2,1,2 /
&contact  bodies='floor','block'  {law} /
&boundary  face='zlo'  type='stick' /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='symmetry' /
&output  name='p'  kind='particles'  count=20  {fields} /
"""

BARS = """
&run  dimension='1d'  method='{method}' /
&grid  lo=-2,0,0  hi=4,1,1  dx=0.02 /
&time  t_end={end} /
&method {words} /
&effects  {effects} /
&material  name='a'  density={densities[0]}  young={moduli[0]}  poisson=0 /
&material  name='b'  density={densities[1]}  young={moduli[1]}  poisson=0 /
&region  name='l'  shape='box'  lo=-1,0,0  hi=0,1,1 /
&region  name='r'  shape='box'  lo=0,0,0  hi=1,1,1 /
&body  name='left'   region='l'  material='a'  ppc=2,1,1  velocity={speed},0,0 /
&body  name='right'  region='r'  material='b'  ppc=2,1,1 /
{more}
&output  name='p'  kind='particles'  count=1  {fields} /
&output  name='history'  kind='history'  every=10 /
"""

HEATED = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,1,0.6  dx=0.1 /
&time  t_end=0.004 /
&effects  contact=.true. /
&material  name='m'  density=1000  shear=5e5  eos_model='mie_gruneisen'  mg_c0=30  mg_s=1.3  mg_gamma=1 /
&region  name='floor'  shape='box'  lo=0,0,0  hi=1,1,0.2 /
&region  name='block'  shape='box'  lo=0.2,0,0.2  hi=0.6,1,0.4 /
&body  name='floor'  region='floor'  material='m'  ppc=2,1,2 /
&body  name='block'  region='block'  material='m'  ppc=2,1,2  velocity=1,0,-1 /
&contact  friction=0.5 /
&output  name='p'  kind='particles'  count=1  {fields} /
&output  name='history'  kind='history'  every=1 /
"""

THREE = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=0.1 /
&effects  {contact} /
&material  name='m'  density=1000  young=1e5  poisson=0.3 /
&material  name='n'  density=300  young=1e5  poisson=0.3 /
&region  name='a'  shape='box'  lo=0.1,0.1,0.1  hi=0.5,0.5,0.5 /
&region  name='b'  shape='box'  lo=0.5,0.2,0.1  hi=0.9,0.6,0.5 /
&region  name='c'  shape='sphere'  centre=0.48,0.45,0.7  radius=0.2 /
&body  name='a'  region='a'  material='m'  velocity=1,0.2,0 /
&body  name='b'  region='b'  material='m'  velocity=-1,0,0.1 /
&body  name='c'  region='c'  material='n'  velocity=0.1,0,-2 /
&contact  friction=0.3 /
&contact  bodies='a','c'  law='stick' /
&output  name='p'  kind='particles'  count=1  {fields} /
&output  name='history'  kind='history'  every=1 /
"""

FAST = """
&run  dimension='axisymmetric' /
&grid  lo=0,0,0  hi=0.012,1,0.02  dx=0.0004 /
&time  t_end=2.0e-6 /
&effects  contact=.true.  thermal=.true. /
&material  name='m'  density=2785  shear=27.6e9  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2
  strength_model='von_mises'  yield=3.0e8  specific_heat=900 /
&region  name='ball'   shape='sphere'  centre=0,0,0.014  radius=0.003 /
&region  name='plate'  shape='box'  lo=0,0,0.009  hi=0.010,1,0.0108 /
&body  name='plate'  region='plate'  material='m'  ppc=2,1,2 /
&body  name='ball'   region='ball'   material='m'  ppc=2,1,2  velocity=0,0,-5000 /
&contact  friction=0.2 /
&boundary  face='xlo'  type='symmetry' /
&output  name='history'  kind='history'  every=1 /
"""


@pytest.mark.tiers("full", "long")
def test_discs(options, sheet):
    """Two elastic discs."""
    for name, words, spacing in (("discs", "", 0.025), ("discs_fine", "", 0.0125),
                                 ("discs_usl", "stress_update='usl'", 0.025)):
        result = bodies.two_discs(options, name, words=words, spacing=spacing, effects=CONTACT)
        felt = result["time"][np.flatnonzero(result["kinetics"] < 1.0 - 1.0e-6)[0]]
        early = (bodies.CONTACT - felt) * np.sqrt(0.08) / spacing
        sheet.above(f"{name}: cells felt late", -early, -0.1)
        sheet.below(f"{name}: cells felt early or late", early, 0.5)
        target = TARGET * spacing / 0.025
        for label, value in (("total energy at the end", result["energy"]),
                             ("kinetic energy after the rebound, less that of fine runs", result["kinetic"] - REBOUND)):
            if name == "discs" or (name == "discs_fine" and label.startswith("kinetic")):
                sheet.below(f"{name}: {label}", value, target)
            else:
                sheet.known(f"{name}: {label}", value, limit=0.1, target=target)
        history = result["run"].history
        if not words:
            sheet.below(f"{name}: energy that the books leave open",
                        result["energy"] + history["dissipated"][-1] / history["kinetic"][0], 0.5 * target)
        sheet.below(f"{name}: momentum", result["momentum"], 1.0e-12)
    kept = bodies.two_discs(options, "discs_flip_1", words="flip=1", effects=CONTACT)
    history = kept["run"].history
    sheet.below("discs_flip_1: energy that the books leave open",
                kept["energy"] + history["dissipated"][-1] / history["kinetic"][0], 0.25 * TARGET)


def block(options, name, law, angle, friction=0.0, method="ddmp", words=""):
    """Acceleration of a block along an incline plus friction times that normal to it, and its last velocity."""
    along, down = float(10.0 * np.sin(np.radians(angle))), float(-10.0 * np.cos(np.radians(angle)))
    run = case.Case(options, name, SLIDE.format(method=method, words=words, along=along, down=down, law=law,
                                                contact="contact=.true.", fields=FIELDS)).run("-q")
    return slope.sliding(run, lambda snap: snap.fields["body"] == 2, SETTLED, friction)


@pytest.mark.tiers("full", "long")
def test_slides(options, sheet):
    """A block on an incline."""
    sine, cosine = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    for name, law, friction, words in (
            ("rubs", "friction=0.2", 0.2, {}), ("slips", "law='frictionless'", 0.0, {}),
            ("rubs_gimp", "friction=0.2", 0.2, {"method": "mpm", "words": "basis='gimp'"})):
        exact = 10.0 * (sine - friction * cosine)
        found, _ = block(options, name, law, 20.0, friction=friction, **words)
        sheet.near(f"{name}: acceleration [m/s2]", found, exact, 1.0e-3)
    for name, law in (("sticks", "friction=0.6"), ("stick_law", "law='stick'")):
        _, speed = block(options, name, law, 20.0)
        sheet.below(f"{name}: last velocity over that of free fall", abs(speed) / (10.0 * sine * 0.4), SHEARED / 0.4)


def bars(options, name, densities=(1000, 1000), moduli=(1e6, 1e6), speed=0.1, end=0.1, **words):
    """Velocities of two bars after an impact, and their history."""
    keys = {"method": "ddmp", "words": "", "effects": CONTACT, "more": "", "fields": FIELDS, **words}
    deck = BARS.format(densities=densities, moduli=moduli, speed=speed, end=end, **keys)
    run = case.Case(options, name, deck).run("-q")
    snap = run.snapshots()[-1][1]
    means = [np.average(snap.fields["velocity"][snap.fields["body"] == number, 0]) / speed for number in (1, 2)]
    return means, run.history


def test_impacts(options, sheet):
    """Bars that collide and separate."""
    (left, right), history = bars(options, "equal")
    sheet.above("bars: velocity handed over", right, 1.0 - LAYER)
    sheet.below("bars: velocity left", abs(left), LAYER)
    # only the layer of particles that collides loses energy
    sheet.below("bars: energy that contact books as lost", history["dissipated"][-1] / history["kinetic"][0], LAYER)
    sheet.require(history["dissipated"][-1] > 0.0, "bars: contact books what it loses")
    (left, right), _ = bars(options, "one_field", effects="artificial_viscosity=.false.")
    sheet.below("bars: with one velocity they stick", right, 0.5)
    (left, _), history = bars(options, "light_target", densities=(1000, 1e-3), moduli=(1e6, 1.0))
    sheet.near("bars: heavy on light goes on", left, 1.0, 1.0e-4)
    (left, _), history = bars(options, "heavy_target", densities=(1e-3, 1000), moduli=(1.0, 1e6))
    sheet.near("bars: light on heavy bounces", left, -1.0, 2.0 * LAYER)
    sheet.below("bars: greatest energy", (history["kinetic"] + history["internal"]).max()
                / history["kinetic"][0] - 1.0, 1.0e-9)
    _, history = bars(options, "stiff_target", moduli=(1e6, 1e12), speed=10, end=2.0e-4)
    sheet.below("bars: greatest energy, stiff", (history["kinetic"] + history["internal"]).max()
                / history["kinetic"][0] - 1.0, 1.0e-9)


def test_torn(options, sheet):
    """Only bonds of particles within a cell of the broken node break."""
    deck = BARS.format(method="ddmp", words="", effects=CONTACT, densities=(1000, 1000), moduli=(1e6, 1e6),
                       speed=-0.1, end=0.01, fields=FIELDS.replace("'body'", "'body','bond'"),
                       more="&contact law='bonded'  bond_strength=400 /")
    snap = case.Case(options, "torn", deck).run("-q").snapshots()[-1][1]
    for number, side in ((1, 1.0), (2, -1.0)):
        here = snap.fields["body"] == number
        place = side * snap.points[here, 0]
        broken = place[snap.fields["bond"][here] < 0.5]
        sheet.require(len(broken) > 0, f"torn bond: body {number} loses it")
        sheet.below(f"torn bond: body {number}, cells from its end",
                    (place.max() - broken.min(initial=place.max())) / 0.02, 0.9)


def test_heat(options, sheet):
    """The kinetic energy that contact dissipates becomes heat of bodies with internal energy: in an oblique impact with
    friction the energy balance closes to rounding, and both bodies gain internal energy."""
    deck = HEATED.format(fields=FIELDS.replace("'velocity'", "'energy'"))
    run = case.Case(options, "heat", deck).run("-q")
    snap, history = run.snapshots()[-1][1], run.history
    sheet.below("heat of contact: energy books", np.abs(history["energy_error"]).max(), 1.0e-12)
    lost = 1.0 - history["kinetic"][-1] / history["kinetic"][0]
    sheet.above("heat of contact: kinetic energy that is lost", lost, 0.01)
    for number in (1, 2):
        here = snap.fields["body"] == number
        sheet.above(f"heat of contact: energy of body {number}", np.average(snap.fields["energy"][here]), 0.0)


def test_gap(options, sheet):
    """Bonds act only between bodies that touch: bars with a gap of three quarters of a cell, whose particles share a
    node, separate as if there were no bond, and without a bond approach as if there were no contact. Bars without a gap
    stay together."""
    speeds = {}
    for name, start, speed in (("coming", 0.015, 0.1), ("gap", 0.015, -0.1), ("touching", 0.0, -0.1)):
        deck = BARS.format(method="ddmp", words="", effects=CONTACT, densities=(1000, 1000), moduli=(1e6, 1e6),
                           speed=speed, end=0.002, fields=FIELDS.replace("'body'", "'body','pressure'"),
                           more="&contact law='bonded' /" if speed < 0.0 else "")
        deck = deck.replace("lo=0,0,0  hi=1,1,1", f"lo={start},0,0  hi=1,1,1").replace("ppc=2,1,1", "ppc=4,1,1")
        run = case.Case(options, name, deck).run("-q")
        snap = run.snapshots()[-1][1]
        speeds[name] = [snap.fields["velocity"][snap.fields["body"] == number, 0] for number in (1, 2)]
    sheet.below("contact across a gap: change of the speed of one bar", abs(speeds["coming"][0] - 0.1).max(), 1.0e-12)
    sheet.below("bond across a gap: change of the speed of one bar", abs(speeds["gap"][0] + 0.1).max(), 1.0e-12)
    sheet.below("bond across a gap: speed of the other bar", abs(speeds["gap"][1]).max(), 1.0e-12)
    sheet.above("bond without a gap: speed of the other bar", -speeds["touching"][1].min(), 0.04)
    found = [run.summary["extremes"][f"pressure_{end}"] for end in ("min", "max")]
    wanted = [snap.fields["pressure"].min(), snap.fields["pressure"].max()]
    sheet.require(wanted[0] < -100.0, "bond without a gap: it pulls")
    sheet.below("bond without a gap: range of the pressure in the summary",
                np.abs(np.subtract(found, wanted)).max() / np.abs(wanted).max(), 1.0e-14)


# Two lines of particles that fly apart, each by itself, and are split.
THREADS = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=40,1,1  dx=1 /
&time  t_end=2  dt_max=0.02 /
&method  split=.true.  stress_update='{update}' /
&effects  artificial_viscosity=.false.  contact={contact} /
&material  name='thread'  density=1  young=1.0e-3  poisson=0 /
{parts}
&output  name='p'  kind='particles'  count=1  {fields} /
"""


@pytest.mark.tiers("full", "long")
def test_halves(options, sheet):
    """Particles of bodies that never meet are split as without contact, also if they are strained before the force."""
    parts = "".join(
        f"&region  name='r{n}'  shape='box'  lo={start + n % 4},0,0  hi={start + n % 4 + 1},1,1 /\n"
        f"&body  name='b{n}'  region='r{n}'  material='thread'  ppc=1,1,1  velocity={0.7 * (n % 4)},0,0  {{field}} /\n"
        for n, start in enumerate((4,) * 4 + (22,) * 4))
    for update in ("usl", "usf"):
        places = []
        for contact in (".false.", ".true."):
            deck = THREADS.format(update=update, contact=contact, parts=parts, fields=FIELDS)
            for n in range(8):
                deck = deck.replace("{field}", f"field={1 + n // 4}" if contact == ".true." else "", 1)
            run = case.Case(options, f"halves_{update}_{contact[1]}", deck).run("-q")
            sheet.above(f"halves, {update}, contact {contact}: halved", run.summary["particles_halved"], 8)
            places.append(np.sort(run.snapshots()[-1][1].points[:, 0]))
        sheet.require(np.array_equal(*places), f"halves, {update}: the same places with contact as without")


@pytest.mark.tiers("full", "long")
def test_bonds(options, sheet):
    """Bonded bodies move as one body until the bond stress is reached; the impact of 0.1 m/s causes a tension of 1581
    Pa."""
    (left, right), whole = bars(options, "one_body", effects="artificial_viscosity=.false.")
    (bound, other), held = bars(options, "bound", more="&contact law='bonded' /")
    sheet.below("bond: velocity less that in one body, over that of the impact", abs(bound - left), LAYER)
    sheet.below("bond: velocity of the other less that in one body", abs(other - right), LAYER)
    (strong, _), _ = bars(options, "strong", more="&contact law='bonded'  bond_strength=4000 /")
    sheet.require(strong == bound, "bond: a strength that is not reached changes nothing")
    (weak, free), _ = bars(options, "weak", more="&contact law='bonded'  bond_strength=400 /")
    sheet.above("bond: broken, the velocity is handed over", free, 1.0 - LAYER)
    sheet.below("bond: broken, the velocity left", abs(weak), LAYER)
    sheet.require(len(whole["time"]) > 10 and len(held["time"]) > 10, "bond: histories are there")


@pytest.mark.tiers("full", "long")
def test_crowds(options, sheet):
    """Three bodies at the same nodes; self-contact of one body; a fast ball."""
    run = case.Case(options, "three", THREE.format(contact="contact=.true.", fields=FIELDS)).run("-q")
    history = run.history
    scale = np.abs([history[f"momentum_{k}"][0] for k in "xyz"]).max()
    for k in "xyz":
        sheet.below(f"three bodies: momentum {k}", np.abs(history[f"momentum_{k}"] - history[f"momentum_{k}"][0]).max()
                    / scale, 1.0e-13)
    snap = run.snapshots()[-1][1]
    turned = snap.fields["velocity"][snap.fields["body"] == 1].mean(axis=0)
    sheet.require(np.abs(turned - [1.0, 0.2, 0.0]).max() > 0.05, "three bodies: they met")
    alone = bodies.DISCS.replace("&body  name='right'", "! &body  name='right'")
    digests = []
    for name, effects in (("alone", CONTACT), ("alone_off", "artificial_viscosity=.false.")):
        deck = alone.format(method="ddmp", words="", spacing=0.05, ppc=2, cfl=0.4, effects=effects)
        digests.append(case.Case(options, name, deck).run("-q").summary["digest"])
    sheet.require(digests[0] == digests[1], "one body: the same bits with contact as without")
    history = case.Case(options, "fast", FAST).run("-q").history
    sheet.below("fast ball: energy books", np.abs(history["energy_error"]).max(), 1.0e-10)
    sheet.below("fast ball: kinetic energy left", history["kinetic"][-1] / history["kinetic"][0], 0.98)


def test_numbers(options, sheet):
    """Materials have the numbers of the deck in outputs, although each velocity field has separate stores."""
    deck = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=1,1,1  dx=0.1 /
&time  t_end=1.0e-4 /
&effects  artificial_viscosity=.false.  contact=.true. /
&material  name='none'  density=1000  young=1e6  poisson=0 /
&material  name='m1'  density=1000  young=1e6  poisson=0 /
&material  name='m2'  density=1000  young=1e6  poisson=0 /
&region  name='a'  shape='box'  lo=0,0,0  hi=0.3,1,1 /
&region  name='b'  shape='box'  lo=0.3,0,0  hi=0.6,1,1 /
&region  name='c'  shape='box'  lo=0.6,0,0  hi=0.9,1,1 /
&body  name='a'  region='a'  material='m2'  ppc=2,1,1 /
&body  name='b'  region='b'  material='m1'  ppc=2,1,1 /
&body  name='c'  region='c'  material='m2'  ppc=2,1,1 /
&output  name='p'  kind='particles'  count=1  fields='body','material' /
"""
    run = case.Case(options, "numbers", deck).run("-q")
    fields = run.snapshots()[-1][1].fields
    sheet.require({(int(body), int(material)) for body, material in zip(fields["body"], fields["material"])}
                  == {(1, 3), (2, 2), (3, 3)}, "numbers of materials are those of the deck")
    with h5py.File(run.path("_p_000001.hdf")) as file:
        names = [name.decode().strip() for name in file["/bodies/material_name"][:]]
        sheet.require(names == ["none", "m1", "m2"], "names of materials in the order of the deck")
        sheet.require(list(file["/bodies/material"][:]) == [3, 2, 3], "materials of the bodies")
