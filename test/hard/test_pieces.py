# SPDX-License-Identifier: BSD-3-Clause
"""Parts of one body that failed material separates: they slide with friction, separate, meet again and rebound.

Would catch: parts that stick to each other through the velocities of the grid, as they do without self-contact;
friction between them that is not mu times the normal force; sides that are determined by noise, so that a part drags
particles of the other one along; parts that return and stick, or attract each other; momentum that the sums of both
sides lose; sides that depend on ranks, threads or a restart; a disc that splits at another load; a body that changes
although nothing in it fails; and heat of contact that is not recorded.

Limits. Block on a failed bed: as for two bodies (test_contact.py), 1e-3 of the acceleration once it slides, and the
speed of free fall for the time of a pressure wave through its height if it sticks. Two halves of a bar: the velocity
that remains with two bodies, within 2 %, one cell of a bar; momentum to rounding. Disc between platens: it splits where
the greatest tension of the line load, 2 P/(pi D t), is the strength (G. Hondros, Aust. J. Appl. Sci. 10 (1959) 243), 5
%.
"""
# tiers: smoke, full
# timeout: 600

import numpy as np
import pytest

import case
import slope

CROSSED = 0.2 / 36.7                   # time of a pressure wave through the height of the block [s]
SETTLED = 0.039                        # four times the shear wave through the floor [s]
LAYER = 0.02                           # a cell of the bar over the length of its half

SLIDE = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1.2,1,0.5  dx=0.05 /
&time  t_end=0.4 /
&effects  {contact}  damage=.true.  gravity=.true.  gravity_vector={along!r},0,{down!r} /
&method  stress_update='usl' /
&material  name='m'  density=1000  young=1e6  poisson=0.3 /
&material  name='weak'  density=1000  young=1e6  poisson=0.3  damage_model='principal_stress'  failure_stress=1.0e-3
  failure_shear=1.0e-3  failed_as='drucker_prager'  failed_friction_angle=60 /
&region  name='floor'  shape='box'  lo=0,0,0        hi=1.2,1,0.175 /
&region  name='bed'    shape='box'  lo=0,0,0.175    hi=1.2,1,0.2 /
&region  name='sole'   shape='box'  lo=0.2,0,0.2    hi=0.6,1,0.225 /
&region  name='block'  shape='box'  lo=0.2,0,0.225  hi=0.6,1,0.4 /
&body  name='floor'  region='floor'  material='m'     ppc=2,1,2  {field} /
&body  name='bed'    region='bed'    material='weak'  ppc=2,1,2  {field} /
&body  name='sole'   region='sole'   material='weak'  ppc=2,1,2  {field} /
&body  name='block'  region='block'  material='m'     ppc=2,1,2  {field} /
{law}
&boundary  face='zlo'  type='stick' /
&boundary  face='xlo'  type='symmetry' /
&boundary  face='xhi'  type='symmetry' /
&output  name='p'  kind='particles'  count=20  fields='identity','body','mass','velocity'  precision='double' /
"""

# Two halves of a bar fly apart, reverse at the ends of the box, meet and separate again. The material between them
# fails as they separate.
BAR = """
&run  dimension='1d' /
&grid  lo=-1.1,0,0  hi=1.1,1,1  dx=0.02 /
&time  t_end=3.6 /
&method  stress_update='usl' /
&effects  artificial_viscosity=.false.  damage=.true.  {contact} /
&material  name='m'  density=1000  young=1e6  poisson=0 /
&material  name='weak'  density=1000  young=1e6  poisson=0  damage_model='principal_stress'  failure_stress=1.0e-3 /
&region  name='l'  shape='box'  lo=-1,0,0     hi=-0.02,1,1 /
&region  name='a'  shape='box'  lo=-0.02,0,0  hi=0,1,1 /
&region  name='b'  shape='box'  lo=0,0,0      hi=0.02,1,1 /
&region  name='r'  shape='box'  lo=0.02,0,0   hi=1,1,1 /
&body  name='l'  region='l'  material='m'     ppc=2,1,1  velocity=-0.1,0,0  {fields[0]} /
&body  name='a'  region='a'  material='weak'  ppc=2,1,1  velocity=-0.1,0,0  {fields[0]} /
&body  name='b'  region='b'  material='weak'  ppc=2,1,1  velocity=0.1,0,0   {fields[1]} /
&body  name='r'  region='r'  material='m'     ppc=2,1,1  velocity=0.1,0,0   {fields[1]} /
{law}
&boundary  face='xlo'  type='slip' /
&boundary  face='xhi'  type='slip' /
&output  name='p'  kind='particles'  count=36  fields='identity','body','mass','velocity'  precision='double' /
&output  name='history'  kind='history'  every=10 /
"""

DISC = """
&run  dimension='plane_strain' /
&grid  lo=-0.6,0,-0.6  hi=0.6,1,0.6  dx={spacing} /
&time  t_end={end} /
&method  stress_update='usl' /
&effects  contact=.true.  damage=.true. /
&material  name='rock'  density=1000  young=1e9  poisson=0.2  damage_model='principal_stress'  failure_stress=1e6 /
&material  name='platen'  density=1000  young=1e9  poisson=0.2 /
&region  name='disc'   shape='cylinder'  centre=0,0,0  axis=0,1,0  radius={radius}  height=10 /
&region  name='upper'  shape='box'  lo=-0.2,0,0.5     hi=0.2,1,0.575 /
&region  name='lower'  shape='box'  lo=-0.2,0,-0.575  hi=0.2,1,-0.5 /
&region  name='top'    shape='box'  lo=-9,-9,0.55     hi=9,9,9 /
&region  name='base'   shape='box'  lo=-9,-9,-9       hi=9,9,-0.55 /
&body  name='disc'   region='disc'   material='rock'    ppc=2,1,2 /
&body  name='upper'  region='upper'  material='platen'  ppc=2,1,2  field=2  velocity=0,0,-{speed} /
&body  name='lower'  region='lower'  material='platen'  ppc=2,1,2  field=2  velocity=0,0,{speed} /
&contact  bodies='disc','disc'  friction=0.5 /
&boundary  region='top'   type='velocity'  velocity=0,0,-{speed} /
&boundary  region='base'  type='velocity'  velocity=0,0,{speed} /
&boundary  face='all'  type='outflow' /
&output  name='p'  kind='particles'  count=5  fields='body','velocity','failed'  precision='double' /
&output  name='f'  kind='forces'  every=5 /
"""


# A brittle ball bursts on a plate, in space and with internal energy.
BALL = """
&run  dimension='3d'  seed=7 /
&grid  lo=-8,-8,0  hi=8,8,8  dx=1  block=4 /
&units  system='mm-us-mg' /
&time  t_end=1000  max_steps={steps} /
&effects  damage=.true.  thermal=.true.  contact=.true. /
&material  name='glass'  preset='glass_soda_lime' /
&region  name='ball'   shape='sphere'  centre=0.3,0.2,4.5  radius=3.4 /
&region  name='plate'  shape='box'  lo=-5,-5,0  hi=5,5,1 /
&body  name='ball'   region='ball'   material='glass'  velocity=0,0,-0.5 /
&body  name='plate'  region='plate'  material='glass' /
{law}
&boundary  face='zlo'  type='symmetry' /
&output  name='p'  kind='particles'  count=1  fields='failed'  precision='double' /
"""


def slide_deck(law, angle, itself=True):
    """A block whose base has failed on a bed that has failed."""
    along, down = float(10.0 * np.sin(np.radians(angle))), float(-10.0 * np.cos(np.radians(angle)))
    return SLIDE.format(along=along, down=down, contact="contact=.true." if itself else "",
                        field="field=1" if itself else "",
                        law=f"&contact  bodies='block','block'  {law} /" if itself else "")


def block(options, name, law, friction=0.0, itself=True):
    """Acceleration of the block along the slope plus friction times that normal to it, and its last velocity."""
    run = case.Case(options, name, slide_deck(law, 20.0, itself)).run("-q")
    return slope.sliding(run, lambda snap: snap.fields["body"] >= 3, SETTLED, friction)


@pytest.mark.tiers("full", "long")
def test_slides(options, sheet):
    """A block on an incline."""
    sine, cosine = np.sin(np.radians(20.0)), np.cos(np.radians(20.0))
    for name, law, friction in (("rubs", "friction=0.2", 0.2), ("slips", "law='frictionless'", 0.0)):
        found, _ = block(options, name, law, friction)
        sheet.near(f"{name}: acceleration [m/s2]", found, 10.0 * (sine - friction * cosine), 1.0e-3)
    for name, law, itself in (("sticks", "friction=0.6", True), ("one_velocity", "", False)):
        _, speed = block(options, name, law, itself=itself)
        sheet.below(f"{name}: last velocity over that of free fall", abs(speed) / (10.0 * sine * 0.4), CROSSED / 0.4)


def test_halves(options, sheet):
    """Halves of a bar that meet again, as one body and as two."""
    kept = {}
    for name, fields, law in (("halves", ("field=1", "field=1"), "&contact  bodies='l','l' /"),
                              ("bodies", ("field=1", "field=2"), "")):
        run = case.Case(options, name, BAR.format(contact="contact=.true.", fields=fields, law=law)).run("-q")
        history = run.history
        scale = np.sqrt(2.0 * history["kinetic"][0] * history["mass"][0]) if "mass" in history else 200.0
        met, speeds = False, []
        for time, snap in run.snapshots():
            right = snap.fields["body"] >= 3
            speeds.append(np.average(snap.fields["velocity"][right, 0], weights=snap.fields["mass"][right]))
            met = met or (time > 0.5 and np.ptp(snap.points[:, 0]) < 2.0 * 1.01)
        kept[name] = (speeds, history["kinetic"][-1] / history["kinetic"][0])
        sheet.below(f"{name}: sum of momenta", np.abs(history["momentum_x"]).max() / scale, 1.0e-12)
        sheet.require(met, f"{name}: they meet again")
    speeds = np.array([kept[name][0] for name in ("halves", "bodies")]) / 0.1
    turns = np.flatnonzero(np.diff(np.sign(speeds[1])))
    sheet.require(len(turns) == 3, "bodies: out, back, and out again, and back")
    sheet.below("halves: velocity against that of two bodies", np.abs(speeds[0] - speeds[1])[-1], LAYER)
    sheet.below("halves: kinetic energy against that of two bodies", abs(kept["halves"][1] - kept["bodies"][1]), LAYER)
    return speeds, kept


def test_layouts(options, sheet):
    """The same bits."""
    deck = slide_deck("friction=0.2", 20.0)
    digest, steps = {}, "time.max_steps=160"
    for ranks, threads in ((1, 1), (2, 1), (1, 2)):
        run = case.Case(options, f"bits_{ranks}_{threads}", deck, ranks=ranks, threads=threads).run("-q", "-s", steps)
        digest[ranks, threads] = run.summary["digest"]
    stopped = case.Case(options, "bits_restart", deck, ranks=2).run("-q", "-s", "time.max_steps=83")
    sheet.require(stopped.summary["digest"] != digest[1, 1], "the middle is not the end")
    stopped.ranks = 1
    digest["restart"] = stopped.run("-q", "--restart", "-s", steps).summary["digest"]
    sheet.require(len(set(digest.values())) == 1, f"same bits, {digest}")
    strong = deck.replace("failure_stress=1.0e-3\n  failure_shear=1.0e-3", "failure_stress=1.0e30")
    whole = [case.Case(options, name, text).run("-q", "-s", steps).summary["digest"]
             for name, text in (("strong", strong), ("strong_plain", strong.replace("&contact ", "! &contact ")))]
    sheet.require(whole[0] == whole[1], "where nothing fails contact with itself changes no bit")


@pytest.mark.tiers("full", "long")
def test_ball(options, sheet):
    """In space, with internal energy: the same bits, closed balances."""
    balls = {}
    law = "&contact  bodies='ball','ball'  friction=0.3 /"
    for name, words, ranks, threads in (("ball", law, 1, 1), ("ball_ranks", law, 2, 1), ("ball_threads", law, 1, 2),
                                        ("ball_whole", "", 1, 1)):
        run = case.Case(options, name, BALL.format(law=words, steps=120), ranks=ranks, threads=threads).run("-q")
        balls[name] = run.summary["digest"]
        sheet.below(f"{name}: momentum", abs(run.summary["ledger"]["momentum_error"]), 1.0e-11)
        sheet.below(f"{name}: energy books", abs(run.summary["ledger"]["energy_error"]), 1.0e-10)
    sheet.above("ball: failed share", run.snapshots()[-1][1].fields["failed"].mean(), 0.1)
    sheet.require(balls["ball"] == balls["ball_ranks"] == balls["ball_threads"], f"ball: same bits, {balls}")
    sheet.require(balls["ball"] != balls["ball_whole"], "ball: contact with itself acts")


@pytest.mark.tiers("full", "long")
def test_disc(options, sheet):
    """A disc between platens splits."""
    radius = 0.497
    deck = DISC.format(spacing=0.025, radius=radius, speed=0.02, end=0.15)
    run = case.Case(options, "disc", deck).run("-q", timeout=500)
    with open(run.path("_forces.csv"), encoding="utf-8") as file:
        names = file.readline().split(",")
        table = np.array([[float(word) for word in line.split(",")] for line in file])
    force = np.abs(table[:, [at for at, name in enumerate(names) if "force_z" in name]]).mean(axis=1).max()
    sheet.near("disc: 2 P/(pi D t) over the strength", 2.0 * force / (np.pi * 2.0 * radius) / 1.0e6, 1.0, 0.05)
    snap = run.snapshots()[-1][1]
    mine = snap.fields["body"] == 1
    for side, sign in (("left", -1.0), ("right", 1.0)):
        here = mine & (sign * snap.points[:, 0] > 0.1) & (snap.fields["failed"] < 0.5)
        sheet.above(f"disc: the {side} half flies off [m/s]", sign * snap.fields["velocity"][here, 0].mean(), 0.05)
