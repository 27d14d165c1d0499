# SPDX-License-Identifier: BSD-3-Clause
"""The state is the same to the last bit for any number of ranks and threads, and after a restart.

Would catch: sums whose order depends on ranks or threads, race conditions, particles in the order of their arrival,
ghosts that differ from the tiles of the owner, any data missing in a checkpoint, a digest that does not include a
field. Controls: the state differs from that at the start, runs make many steps, particles cross tiles and borders of
ranks, and the digest changes when one velocity changes in its last bit.
"""
# timeout: 900
# cores: 2

import numpy as np

import case
import layouts

LAYOUTS = ((1, 1), (1, 2), (2, 1), (3, 1), (2, 2))      # ranks, threads


BLOCK = """
&run  dimension='3d'  method='{method}' /
&grid  lo=0,0,0  hi=8,8,8  dx=1  block={block} /
&time  t_end=1  max_steps={steps} /
&method  {words} /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=4.3,4.2,4.1  hi=8,7.2,7.6 /
&region  name='ball'  shape='sphere'  centre=2,3,2.5  radius=1.4 /
&body  name='block'  region='box'   material='rubber'  velocity={speed},-6,4 /
&body  name='ball'   region='ball'  material='rubber'  velocity=12,3,-5  spin=1,2,3 /
&boundary  face='all'  type='periodic' /
&parallel  balance_every=13  imbalance=1.01 /
"""

BAR = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=60,1,1  dx=0.5 /
&time  t_end=1  max_steps=150 /
&effects  thermal=.true. /
&material  name='al'  density=2785  eos_model='mie_gruneisen'  mg_c0=5328  mg_s=1.338  mg_gamma=2
  shear=27.6e9  specific_heat=875  strength_model='johnson_cook'  jc_a=265e6  jc_b=426e6  jc_n=0.34
  jc_c=0.015  jc_m=1  t_ref=293  t_melt=775 /
&region  name='left'   shape='box'  lo=3.2,0,0  hi=25,1,1 /
&region  name='right'  shape='box'  lo=25,0,0   hi=50,1,1 /
&body  name='left'   region='left'   material='al'  ppc=2,1,1  velocity=900,0,0 /
&body  name='right'  region='right'  material='al'  ppc=3,1,1  velocity=-300,0,0 /
&boundary  face='xlo'  type='symmetry' /
"""

# Shape functions with extended support, nodes that farther particles reach, and tiles of the least thickness.
CROSSED = """
&run  dimension='plane_strain' /
&grid  lo=-1,0,-1  hi=3,1,2  dx=0.1  block=4 /
&time  t_end=0.03 /
&method  quadrature='sub_points' /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='left'   shape='box'  lo=0,0,0      hi=0.8,1,0.8 /
&region  name='right'  shape='box'  lo=0.8,0,0.1  hi=1.6,1,0.9 /
&body  name='left'   region='left'   material='rubber'  velocity=5,0,0 /
&body  name='right'  region='right'  material='rubber'  velocity=-5,0,0.4 /
"""


def checkpoint(run):
    """The newest checkpoint."""
    return sorted(run.folder.glob(f"{run.name}_chk_*.h5"))[-1]


def compare(options, sheet, name, deck, layouts=LAYOUTS):
    """One deck in several layouts; returns the first run and its digest."""
    runs = []
    for ranks, threads in layouts:
        run = case.Case(options, f"{name}_{ranks}x{threads}", deck, ranks, threads)
        # the name of the case is in the checkpoint, so it must be the same in all runs
        run.name, run.deck = name, run.deck.rename(run.folder / f"{name}.nml")
        runs.append(run.run("-q"))
        seen = run.summary
        sheet.require((seen["ranks"], seen["threads"]) == (ranks, threads),
                      f"{name}: runs on {ranks} x {threads}")
        sheet.require(seen["digest"] == runs[0].summary["digest"],
                      f"{name}: digest of {ranks} x {threads} is {seen['digest']}, that of 1 x 1 "
                      f"{runs[0].summary['digest']}")
        sheet.require(checkpoint(run).read_bytes() == checkpoint(runs[0]).read_bytes(),
                      f"{name}: checkpoint of {ranks} x {threads} is that of 1 x 1")
    first = runs[0].summary
    print(f"         {name}: {first['digest']}, {first['steps']} steps, {first['particles']} "
          f"particles, {', '.join('%d x %d' % layout for layout in layouts)}")
    sheet.require(first["steps"] >= 40, f"{name}: makes many steps")
    return runs[0], first["digest"]


def restart(options, sheet, name, deck, digest, before, after, steps):
    """Stop in the middle, continue with other numbers of ranks and threads."""
    run = case.Case(options, f"{name}_restart", deck, *before)
    run.run("-q", "-s", f"time.max_steps={steps}")
    sheet.require(run.summary["digest"] != digest, f"{name}: the middle is not the end")
    sheet.require(run.summary["steps"] == steps, f"{name}: stops at step {steps}")
    run.ranks, run.threads = after
    run.run("-q", "--restart")
    sheet.require(run.summary["digest"] == digest,
                  f"{name}: restart from {before} on {after}: {run.summary['digest']}, "
                  f"not {digest}")
    answer = case.Case(options, "unused", deck, keep=True).run("--digest", checkpoint(run))
    sheet.require(answer.output.split()[0] == digest,
                  f"{name}: --digest tells the digest of the file")
    print(f"         {name}: stopped at step {steps} on {before}, went on on {after}")


def test_bits(options, sheet):
    """Cloud, block, bar; then the methods, restarts, and changes that must change the digest."""
    cloud = layouts.coarse_cloud(150)
    run, digest = compare(options, sheet, "cloud", cloud)
    start = case.Case(options, "cloud_start", layouts.coarse_cloud(0)).run("-q")
    sheet.require(start.summary["digest"] != digest, "the cloud moves")
    restart(options, sheet, "cloud", cloud, digest, (1, 2), (3, 1), 77)
    echo = run.path(".echo.nml").read_text(encoding="utf-8")
    again = case.Case(options, "cloud_echo", echo, 2, 1).run("-q")
    sheet.require(again.summary["digest"] == digest, "the echo of a deck gives the same state")

    words = {"method": "ddmp", "words": "", "speed": "-9", "steps": 120, "block": 0}
    block = BLOCK.format(**words)
    _, digest = compare(options, sheet, "block", block)
    restart(options, sheet, "block", block, digest, (3, 1), (1, 1), 1)
    restart(options, sheet, "block", block, digest, (1, 1), (2, 2), 119)
    changed = BLOCK.format(**{**words, "speed": repr(float(np.nextafter(-9.0, 0.0)))})
    other = case.Case(options, "block_last_bit", changed).run("-q").summary["digest"]
    sheet.require(other != digest, "a velocity that differs in its last bit gives another digest")

    seen = set()
    transfers = ("flip", "pic", "apic", "aflip", "rflip")
    pairs = [("usl", name) for name in transfers] + [("musl", name) for name in transfers] + [("usavg", "rflip")]
    pairs += [("usf", name) for name in ("flip", "aflip")]
    for method in ("ddmp", "mpm"):
        for update, transfer in pairs:
            # affine transfers with linear functions of the plain method are unstable
            basis = "quadratic" if method == "mpm" else "linear"
            text = f"basis='{basis}' stress_update='{update}' transfer='{transfer}'"
            deck = BLOCK.format(**{**words, "method": method, "words": text, "steps": 40})
            _, digest = compare(options, sheet, f"block_{method}_{update}_{transfer}", deck,
                                ((1, 1), (2, 2)))
            seen.add(digest)
    sheet.require(len(seen) == 2 * len(pairs), "every method gives another state")
    affine = BLOCK.format(**{**words, "words": "transfer='aflip'", "steps": 60})
    _, digest = compare(options, sheet, "affine", affine, ((1, 1), (3, 1)))
    restart(options, sheet, "affine", affine, digest, (2, 1), (1, 2), 31)

    # cells so small that there are several tiles to distribute
    wide = BLOCK.replace("dx=1", "dx=0.8")
    seen = set()
    for basis in ("linear", "gimp", "cpgimp", "cpdi", "quadratic", "cubic"):
        deck = wide.format(**{**words, "method": "mpm", "words": f"basis='{basis}'", "steps": 40,
                              "block": 5})
        _, digest = compare(options, sheet, f"block_{basis}", deck, ((1, 1), (2, 2)))
        seen.add(digest)
        if basis in ("cpgimp", "cpdi"):
            restart(options, sheet, f"block_{basis}", deck, digest, (2, 1), (1, 2), 21)
    sheet.require(len(seen) == 6, "every basis gives another state")

    seen = set()
    for rule in ("point", "sub_points", "control"):
        deck = wide.format(**{**words, "words": f"quadrature='{rule}'", "steps": 40, "block": 5})
        _, digest = compare(options, sheet, f"block_{rule}", deck, ((1, 1), (2, 2), (3, 1)))
        seen.add(digest)
        if rule != "point":
            restart(options, sheet, f"block_{rule}", deck, digest, (2, 1), (1, 2), 21)
    sheet.require(len(seen) == 3, "every rule of the dual gradient gives another state")

    _, digest = compare(options, sheet, "crossed", CROSSED, ((1, 1), (2, 1), (3, 1)))
    restart(options, sheet, "crossed", CROSSED, digest, (2, 1), (1, 2), 21)

    _, digest = compare(options, sheet, "bar", BAR)
    restart(options, sheet, "bar", BAR, digest, (2, 1), (1, 2), 75)
