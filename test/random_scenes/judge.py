# SPDX-License-Identifier: BSD-3-Clause
"""Run a random deck and check it by invariants alone.

    verdict = judge.judge(options, generate.scene(17))
    verdict.result, verdict.reason, verdict.detail     # "ok", "check" or "bad"

Limits; none of them was chosen from measurements:

exit code        0: the deck is legal and such matter exists. Exit code 4 of a method that is documented as unstable is
                 only rated "check", and so is that of a deck if the run reports at its start that a law does not hold.
mass, momentum   1e-12 of M, and of the greatest of sum m v, impulse, and M c where the start has pressure: rounding.
                 Methods whose documentation says that momentum or energy is not exact are only rated "check".
energy           1e-9 where all matter carries it, since what transfers filter is heat there. Else 2 %, the target
                 of the ledger, of the greatest of energy and work, 5 % with contact, as the mean of the last quarter of
                 the run. With transfers that filter by intent only what is made counts.
speed            frame + (f - 1) impact + 1.5 fall + 1.2 expansion, and 0.02 c of a gas. f = 1.5 for like matter and
                 flat faces, where a free surface reaches 1; 2.2 for unlike matter, as heavy matter throws what is light
                 with at most 2; 3 for oblique or curved faces and rows of bodies, where jets reach 2 to 2.6.
energy per mass  3 times that of the start, and of impact, fall and expansion, times the ratio of densities, as heavy
                 matter leaves its energy in light matter; not below the heat of 293 K and 1 % of c0^2.
volume           of solids that hold: between that of the shock of the impact and 1 + v/c, each with 10 %, as the strain
                 is v/c. Of all matter: the cells with particles and those around; a full closed box within 10 %.
bits             the same on two ranks (first 60 steps) and after a restart in the middle, in every fifth deck.

Speeds or energies per mass beyond a limit in at most 0.5 % of the mass or two particles, and by a factor of less than
2, are listed for inspection. So are jets of curved or oblique surfaces at more than a tenth of the speed of sound: at
most 2 % of the mass and 2 (c + v), since the point of contact emits a jet as soon as it is slower than sound, at twice
its speed (G. Birkhoff and others, J. Appl. Phys. 19 (1948) 563). So is a run that needs six times the steps that its
scales suggest.
"""

import dataclasses
import os
import subprocess

import numpy as np

import case

# A waiting rank releases its core to the other one; otherwise two ranks on one core take minutes.
os.environ.setdefault("OMPI_MCA_mpi_yield_when_idle", "1")
HANG = 300.0       # seconds of wall time; a run is designed for a few, and max_steps limits it to six times that
RANK_STEPS = 60    # first steps, which are compared between one rank and two
JET = 0.02         # fraction of the mass in jets of a closing angle of 16 degrees, (1 - cos)/2
FEW = 0.005        # fraction of the mass that may exceed a limit and is only listed for inspection
ENDS = (("dt_collapse", "step collapses"), ("dt_min", "step collapses"), ("not a finite", "not finite"),
        ("inside out", "inside out"), ("volume_ratio_min", "pressed to nothing"),
        ("volume_ratio_max", "grown without bound"), ("speed_max", "too fast"), ("come nearer", "nodes cross"),
        ("would move", "nodes cross"), ("retire_max", "retired"))


@dataclasses.dataclass
class Verdict:
    """Result of a deck."""

    seed: int
    result: str = "ok"
    reason: str = ""
    detail: str = ""
    who: str = ""
    seconds: float = 0.0
    steps: int = 0
    trust: str = ""               # verdict of the run itself
    findings: list = dataclasses.field(default_factory=list)

    def find(self, result, reason, detail=""):
        """Record a finding; the first of the worst ones is the reason of the verdict."""
        self.findings.append((result, reason, detail))
        if self.result == "ok" or (self.result == "check" and result == "bad"):
            self.result, self.reason, self.detail = result, reason, detail


def who(scene):
    """Families of materials, and settings that are not the default."""
    words = ["+".join(sorted({matter.family for matter in scene.matters}))]
    if scene.effects.get("damage"):
        words.append("damage")
    if scene.contact:
        words.append("contact")
    if not scene.method.default:
        words.append("other method")
    return ", ".join(words)


def judge(options, scene, layouts=None):
    """Run a deck and check it; several numbers of ranks and a restart in every fifth deck, or in all or none of
    them."""
    verdict = Verdict(scene.seed, who=who(scene))
    run = case.Case(options, f"s{scene.seed}", scene.deck)
    for name, content in scene.files.items():
        (run.folder / name).write_bytes(content)
    try:
        run.run("-q", expect=None, timeout=HANG)
    except subprocess.TimeoutExpired:
        verdict.find("bad", "hang", f"more than {HANG:.0f} s")
        return verdict
    if run.code == 4:
        ended(verdict, scene, run)
        return verdict
    if run.code:
        lines = [line for line in run.output.splitlines() if "error" in line] or [run.output[-200:]]
        verdict.find("bad", "illegal deck" if run.code == 2 else "crash", f"exit code {run.code}: {lines[0][-200:]}")
        return verdict
    summary = run.summary
    verdict.seconds, verdict.steps = summary["wall_s"], summary["steps"]
    verdict.trust = summary["trust"]["verdict"]
    books(verdict, scene, run)
    for time, snap in run.snapshots():
        state(verdict, scene, time, snap)
    if summary["time"] < 0.999 * scene.t_end:
        verdict.find("check", "short steps", f"reaches {summary['time'] / scene.t_end:.2f} of t_end in "
                     f"{summary['steps']} steps, {scene.steps} expected")
    if layouts or layouts is None and scene.seed % 5 == 0:
        ranks(verdict, scene, options, summary)
    if layouts or layouts is None and scene.seed % 5 == 2:
        restart(verdict, scene, options, summary)
    return verdict


def ended(verdict, scene, run):
    """Finding if the run did not end by itself; only for inspection if the method is known to be unstable."""
    text = " ".join(run.output.split())
    word = next((name for key, name in ENDS if key in text), "other")
    try:
        summary = run.summary
        verdict.steps, share = summary["steps"], summary["time"] / scene.t_end
    except (OSError, ValueError, KeyError):
        share = float("nan")
    excused = scene.method.unstable or "is elastic at any stress" in text
    verdict.find("check" if excused else "bad", f"ends: {word}",
                 f"at {share:.2f} of t_end, step {verdict.steps}: {text[-230:]}")


def finite(verdict, name, values):
    """All numbers are finite."""
    values = np.asarray(values, dtype=float)
    if not np.isfinite(values).all():
        verdict.find("bad", "not finite", f"{name}: {int((~np.isfinite(values)).sum())} numbers")
        return False
    return True


def books(verdict, scene, run):
    """Mass, momentum and energy over the whole run."""
    table = run.history
    if not all([finite(verdict, name, table[name]) for name in table]):
        return
    mass = float(table["mass"][0])
    worst = float(np.abs(table["mass_error"]).max())
    if worst > 1.0e-12:
        verdict.find("bad", "mass", f"{worst:.1e}")
    axes = "z" if scene.dimension == "axisymmetric" else {"1d": "x", "plane_strain": "xz", "3d": "xyz"}[scene.dimension]
    miss, scale = 0.0, float(np.sqrt(2.0 * mass * table["kinetic"].max()))
    for axis in axes:
        lost, impulse = table[f"lost_momentum_{axis}"], table[f"impulse_{axis}"]
        whole = table[f"momentum_{axis}"] + lost + table[f"removed_momentum_{axis}"] - impulse
        miss = max(miss, float(np.abs(whole - whole[0]).max()))
        scale = max(scale, float(np.abs(impulse).max()), float(np.abs(lost).max()))
    if any(body.energy or body.stress for body in scene.bodies):
        scale = max(scale, mass * max(matter.bulk_speed for matter in scene.matters))
    if scale > 0.0 and miss > 1.0e-12 * scale:
        told = any("momentum is not conserved" in line for line in run.output.splitlines())
        verdict.find("check" if scene.method.loses_momentum and told else "bad", "momentum", f"{miss / scale:.1e}")
    energy(verdict, scene, table, any("of the energy is lost" in line for line in run.output.splitlines()))


def energy(verdict, scene, table, told):
    """Energy: to rounding where all material carries it, to percent otherwise. A loss that the run reports with a
    remedy is only listed for inspection, energy gained is not."""
    begin = table["kinetic"][0] + table["internal"][0]
    stake = np.maximum(np.abs(begin), np.abs(table["external_work"]))
    if stake.max() <= 0.0:
        return
    error = table["energy_error"] * stake / stake.max()
    exact = all(matter.carries for matter in scene.matters)
    if not exact:
        # velocities are half a step behind positions, so a single row may be off by a fraction of an oscillation
        error = np.atleast_1d(error[-max(1, len(error) // 4):].mean())
    made, lost = float(error.max()), float(-error.min())
    limit = 1.0e-9 if exact else 0.05 if scene.contact else 0.02
    if made > limit:
        verdict.find("bad", "energy made" + (" (carried)" if exact else ""), number(made, exact))
    if lost > limit and (exact or not scene.method.filters):
        excused = not exact and (told or lost < 1.5 * limit)
        verdict.find("check" if excused else "bad", "energy lost" + (" (carried)" if exact else ""),
                     number(lost, exact))


def number(share, exact):
    """A fraction for the table."""
    return f"{share:.1e}" if exact else f"{100.0 * share:.1f} %"


def state(verdict, scene, time, snap):
    """Speed, energy per mass and volume of particles in one snapshot."""
    fields = snap.fields
    if not len(snap.points):
        return          # all particles have left the box
    if not all([finite(verdict, name, fields[name]) for name in fields]) or not finite(verdict, "place", snap.points):
        return
    mass = np.asarray(fields["mass"])
    when = f"at {time / scene.t_end:.2f} of t_end"
    speed = np.sqrt((np.asarray(fields["velocity"]) ** 2).sum(axis=-1))
    limit = speed_limit(scene)
    sound = max(matter.bulk_speed for matter in scene.matters)
    if scene.oblique and scene.impact > 0.1 * sound:
        most, share = 2.0 * (sound + scene.impact) / limit, JET
    else:
        most, share = 2.0, FEW
    beyond(verdict, "speed", speed / limit, mass, f"{when}: {speed.max():.4g} m/s, impact {scene.impact:.4g}, "
           f"limit {limit:.4g}", max(most, 2.0), share)
    # bodies are numbered as in the deck; with contact the numbers in the field material are not
    bodies = np.asarray(fields["body"]).astype(int) - 1 if "body" in fields else np.zeros(len(mass), int)
    rows = np.array([body.matter for body in scene.bodies])[bodies]
    if "energy" in fields:
        heat(verdict, scene, np.asarray(fields["energy"]), rows, mass, when)
    volume(verdict, scene, snap, rows, time, when)


def speed_factor(scene):
    """Greatest speed over that of an impact."""
    if scene.dimension == "1d":
        return 1.5 if len(scene.matters) == 1 else 2.2
    return 3.0


def speed_limit(scene):
    """Greatest speed that the initial and boundary conditions explain [m/s]."""
    factor = speed_factor(scene)
    floor = max([0.02 * matter.bulk_speed for matter in scene.matters if matter.family == "gas"], default=0.0)
    thermal = max(1.0e-6 * matter.bulk_speed for matter in scene.matters)
    speed = 1.001 * scene.frame + (factor - 1.0) * scene.impact + factor * scene.fall + 1.2 * scene.push + floor
    return max(speed, thermal)


def beyond(verdict, name, ratio, mass, text, most=2.0, part=FEW):
    """Some particles are beyond a limit: a few slightly beyond it are only listed for inspection."""
    over = ratio > 1.0
    if not over.any():
        return
    share = float(mass[over].sum() / mass.sum())
    few = (share <= part or over.sum() <= 2) and ratio.max() < most
    verdict.find("check" if few else "bad", name, f"{text}, {int(over.sum())} of {len(mass)} particles")


def heat(verdict, scene, values, rows, mass, when):
    """Energy per mass of material that carries it."""
    start = max([body.energy or 0.0 for body in scene.bodies])
    densities = np.array([matter.density for matter in scene.matters])
    # heavy material can transfer its energy to light material
    heavier = (densities.max() / densities)[rows]
    most = 3.0 * (start + 0.5 * (scene.impact ** 2 + scene.fall ** 2 + scene.push ** 2) * heavier)
    flow = np.array([0.0 if matter.family in ("gas", "liquid") else 0.01 * matter.bulk_speed ** 2
                     for matter in scene.matters])[rows]
    most = np.maximum(most + flow, 1.0e-4 * max(matter.bulk_speed for matter in scene.matters) ** 2)
    carries = np.array([matter.carries for matter in scene.matters])[rows]
    if not carries.any():
        return
    least = np.array([1.0e-9 * start if matter.family == "gas" else 2.5e5 + 0.01 * matter.bulk_speed ** 2
                      for matter in scene.matters])[rows]
    ratio = np.where(carries, np.maximum(values / most, -values / least), 0.0)
    worst = int(ratio.argmax())
    text = (f"{when}: {values[worst]:.3g} J/kg of {scene.matters[rows[worst]].model}, limits "
            f"-{least[worst]:.2g} and {most[worst]:.3g}")
    if values[worst] > 0.0:
        beyond(verdict, "heat", ratio, mass, text, max(2.0, speed_factor(scene) ** 2 / 3.0), JET)
    else:
        beyond(verdict, "negative energy", ratio, mass, text)


def volume(verdict, scene, snap, rows, time, when):
    """Volumes of intact solids, and of all material compared with the available space."""
    fields, mass = snap.fields, np.asarray(snap.fields["mass"])
    volumes = np.asarray(fields["volume"])
    whole = np.ones(len(mass), bool) if "failed" not in fields else np.asarray(fields["failed"]) < 0.5
    for number_of, matter in enumerate(scene.matters):
        own = (rows == number_of) & whole
        rate = scene.impact / matter.bulk_speed
        if matter.family in ("gas", "liquid", "grains") or rate > 0.6 or not own.any():
            continue
        rest = float(mass[own].sum()) / matter.density
        ratio = float(volumes[own].sum()) / rest
        least = 0.9 * (1.0 - rate / (1.0 + 1.2 * rate)) if matter.family != "porous" else 0.3
        most = 1.1 + rate
        if ratio < least or ratio > most and not (matter.opens or matter.melts):
            verdict.find("bad", "volume of solid", f"{when}: V/V0 = {ratio:.3g} of {matter.model}, limits "
                         f"{least:.2f} and {most:.2f}")
    if scene.full:
        space = scene.full - scene.swept * time / scene.t_end
        share = float(volumes.sum()) / space
        if abs(share - 1.0) > 0.1:
            verdict.find("bad", "volume of full box", f"{when}: sum v = {share:.3g} of the box")
        return
    share = float(volumes.sum()) / space_around(scene, snap.points)
    if share > 1.0:
        verdict.find("bad", "volume beyond space", f"{when}: sum v = {share:.3g} of the cells around particles")


def space_around(scene, points):
    """Volume of the cells with particles and of their neighbours; for gases that of their bounding box."""
    axes = {"1d": (0,), "plane_strain": (0, 2), "axisymmetric": (0, 2), "3d": (0, 1, 2)}[scene.dimension]
    cells = np.floor(np.asarray(points)[:, axes] / scene.dx).astype(int)
    low, high = cells.min(axis=0) - 1, cells.max(axis=0) + 1
    if any(matter.family == "gas" for matter in scene.matters):
        ranges = np.meshgrid(*[np.arange(a, b + 1) for a, b in zip(low, high)], indexing="ij")
        found = np.stack([item.ravel() for item in ranges], axis=1)
    else:
        steps = np.stack(np.meshgrid(*[(-1, 0, 1)] * len(axes), indexing="ij"), axis=-1).reshape(-1, len(axes))
        found = np.unique((cells[:, None, :] + steps[None, :, :]).reshape(-1, len(axes)), axis=0)
    if scene.dimension == "axisymmetric":
        inner = np.maximum(found[:, 0], 0)
        return float((np.pi * (2 * inner + 1) * (found[:, 0] >= 0)).sum()) * scene.dx ** 3
    return len(found) * scene.dx ** len(axes)


def ranks(verdict, scene, options, summary):
    """Two ranks end with the same bits; of long runs only the first steps are compared, since ranks wait for each
    other."""
    words = ["-q", "-s", f"time.max_steps={RANK_STEPS}"]
    first = None
    for number_of in (1, 2):
        if number_of == 1 and summary["steps"] <= RANK_STEPS:
            first = summary
            continue
        run = case.Case(options, f"s{scene.seed}_ranks", scene.deck, ranks=number_of)
        for name, content in scene.files.items():
            (run.folder / name).write_bytes(content)
        if number_of == 2:
            compare(verdict, run, first, "bits on two ranks", *words)
        else:
            first = run.run(*words, timeout=HANG).summary


def restart(verdict, scene, options, summary):
    """A run that is stopped in the middle and continued ends with the same bits."""
    run = case.Case(options, f"s{scene.seed}_restart", scene.deck)
    for name, content in scene.files.items():
        (run.folder / name).write_bytes(content)
    try:
        run.run("-q", "-s", f"time.max_steps={max(1, summary['steps'] // 2)}", expect=None, timeout=HANG)
    except subprocess.TimeoutExpired:
        verdict.find("bad", "hang", f"first half: more than {HANG:.0f} s")
        return
    if run.code:
        verdict.find("bad", "bits after restart", f"first half: exit code {run.code}")
        return
    compare(verdict, run, summary, "bits after restart", "-q", "--restart")


def compare(verdict, run, summary, name, *words):
    """Run and compare digest and steps."""
    try:
        run.run(*words, expect=None, timeout=HANG)
    except subprocess.TimeoutExpired:
        verdict.find("bad", "hang", f"{name}: more than {HANG:.0f} s")
        return
    if run.code:
        verdict.find("bad", name, f"exit code {run.code}: {run.output[-200:]}")
    elif run.summary["digest"] != summary["digest"]:
        verdict.find("bad", name, f"digest {run.summary['digest']}, not {summary['digest']}, after "
                     f"{run.summary['steps']} and {summary['steps']} steps")
