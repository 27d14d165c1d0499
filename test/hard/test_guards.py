# SPDX-License-Identifier: BSD-3-Clause
"""Runs with errors stop with exit code 4 and name the particle, with the same words for any ranks and threads.

Would catch: a bound that is not checked, a reported particle that is within its bounds, a message that depends on ranks
or threads, an invalid state that replaces a valid checkpoint, a state before the failing step that cannot be
reproduced, a step that the summary counts under the wrong limit.
"""
# timeout: 600

import re
import subprocess

import numpy as np
import pytest

import case

# With a step of 0.08 s, fourteen times the stable one, all quantities grow without bound.
DECK = """
&run  dimension='3d' /
&grid  lo=0,0,0  hi=12,12,12  dx=1 /
&time  t_end=10  {time} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3  strength_model='{law}' /
&region  name='low'   shape='box'  lo=1,1,1  hi=5,11,9 /
&region  name='high'  shape='box'  lo=6,1,1  hi=11,11,9 /
&body  name='left'   region='low'   material='rubber'  velocity=3,-6,9  spin=1,2,3 /
&body  name='right'  region='high'  material='rubber'  velocity=3,-6,9  spin=1,2,3 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'
  fields='identity','velocity','stress','volume','mass' /
&checkpoint  {checkpoint} /
"""
# name: time, law, text of the message, field of the snapshot that shows the error
UNSTABLE = "dt_fixed=0.08 dt_collapse=0"
CASES = {
    "not_finite": (UNSTABLE, "elastic", "stress is not a finite number"),
    "fast": (UNSTABLE + " speed_max=50", "elastic", "is above speed_max"),
    "small": (UNSTABLE + " volume_ratio_min=0.1", "elastic", "is below volume_ratio_min"),
    "large": (UNSTABLE + " volume_ratio_max=3", "elastic", "is above volume_ratio_max"),
    "inverted": (UNSTABLE + " volume_ratio_min=0", "neo_hookean", "is inverted"),
    "collapse": ("dt_fixed=0.08", "elastic", "has fallen below dt_collapse"),
    "dt_min": ("dt_min=0.01", "elastic", "is below dt_min"),
}
NAMED = re.compile(r"step (\d+), time +(\S+) s, .*particle (\d+) of body '(left|right)', "
                   r"material 'rubber', at +(\S+) +(\S+) +(\S+) m: (.*)")


def message(run):
    """Lines of the error, without the output of mpiexec and the hint at scree --explain."""
    lines = run.output.split("-----")[0].splitlines()
    return [line for line in lines if line.strip() and "scree --explain" not in line]


def shown(kind, particle):
    """True if the particle in the snapshot has the error of the message."""
    speed = np.sqrt((particle["velocity"] ** 2).sum())
    ratio = particle["volume"] * 1000.0 / particle["mass"]
    return {"not_finite": not np.isfinite(particle["stress"]).all(),
            "fast": speed > 50.0, "small": ratio < 0.1, "large": ratio > 3.0,
            "inverted": ratio < 0.1, "collapse": speed > 1.0e3, "dt_min": True}[kind]


@pytest.fixture(autouse=True)
def needs_guards(options):
    """A build that traps floating point exceptions stops before the bounds do."""
    answer = subprocess.run([options.scree, "--version"], stdout=subprocess.PIPE, text=True, check=True)
    if " Debug " in answer.stdout:
        pytest.skip("a build that traps bad numbers stops before the bounds do")


@pytest.mark.parametrize("kind", CASES)
def test_stops(options, sheet, kind):
    """One kind of error, with two numbers of ranks and threads."""
    time, law, words = CASES[kind]
    texts = []
    for ranks, threads in ((1, 1), (2, 2)):
        run = case.Case(options, f"{kind}_{ranks}_{threads}",
                        DECK.format(time=time, law=law, checkpoint=""), ranks, threads)
        run.run("-q", "--force", expect=4)
        texts.append(message(run))
    sheet.require(all(text == texts[0] for text in texts), f"{kind}: same words: {texts}")
    text = " ".join(texts[0])
    sheet.require(words in text, f"{kind}: says '{words}': {text}")
    named = NAMED.search(text)
    sheet.require(named is not None, f"{kind}: names the particle: {text}")
    if named is None:
        return
    last = run.snapshots()[-1][1] if kind != "dt_min" else run.snapshots()[0][1]
    place = np.flatnonzero(last.fields["identity"] == int(named.group(3)))
    sheet.require(len(place) == 1, f"{kind}: there is particle {named.group(3)}")
    particle = {name: values[place[0]] for name, values in last.fields.items()}
    sheet.require(shown(kind, particle), f"{kind}: the particle shows it: {particle}")
    where = np.array([float(word) for word in named.group(5, 6, 7)])
    sheet.below(f"{kind}: named place against the snapshot [cell]",
                np.abs(where - last.points[place[0]]).max(), 1.0e-2)
    sheet.require(run.summary["exit_code"] == 4, f"{kind}: the summary has the code")
    print("         " + "\n           ".join(texts[0]))


def test_state_before(options, sheet):
    """Valid checkpoints are kept, and the same run up to the step before reproduces that state."""
    run = case.Case(options, "before", DECK.format(
        time=UNSTABLE + " speed_max=1e6", law="elastic", checkpoint="dt=0.08 keep=1"))
    run.run("-q", "--force", expect=4)
    steps = run.summary["steps"]
    kept = sorted(run.folder.glob("*_chk_*.h5"))
    sheet.require(len(kept) == 1 and steps > 2, f"before: a checkpoint, stopped at step {steps}")
    text = message(run)
    sheet.require(f"time.max_steps={steps - 1}" in text[-1], f"before: says how: {text}")
    run.run("-q", "--force", "--restart", "-s", f"time.max_steps={steps - 1}")
    sheet.require(run.summary["steps"] == steps - 1, "before: the state before the step")
    sheet.below("before: greatest speed over the bound", run.summary["extremes"]["speed_max"] / 1e6,
                1.0)
    sheet.require(len(list(run.folder.glob("*_chk_*.h5"))) == 1, "before: it is a checkpoint")
    run.run("-q", "--force", "--restart", expect=4)
    sheet.require(message(run) == text, f"before: the step fails again alike: {message(run)}")


def test_what_limits(options, sheet):
    """Steps are counted by what limits them."""
    deck = DECK.format(time="", law="elastic", checkpoint="at_end=.false.")
    for words, rule, end in (("time.dt_max=1.0e-3", "deck", 0.3), ("time.dt_fixed=1.0e-3", "deck", 0.3),
                             ("time.strain_max=1.0e-3", "strain", 0.05), ("time.cfl=0.3", "signal", 0.3)):
        run = case.Case(options, f"limits_{words[5:10]}", deck)
        run.run("-q", "-s", words, "-s", f"time.t_end={end}")
        limits = run.summary["steps_limited_by"]
        sheet.require(sum(limits.values()) == run.summary["steps"], f"limits: all steps: {limits}")
        sheet.require(limits[rule] > 0.5 * run.summary["steps"], f"{words}: {limits}")
        sheet.require(limits["end"] == 1, f"{words}: the last step ends at t_end: {limits}")
