# SPDX-License-Identifier: BSD-3-Clause
"""Modes that nodes do not resolve, and modes that the mean gradient does not resolve.

Would catch: a velocity filter that does not damp opposite velocities of the particles in a cell; a dual gradient
without a local part, which gives no strain for nodes that move in opposite directions.

Opposite velocities of the particles in a cell give no node velocity, so no force acts and only the transfer from nodes
to particles can damp the mode: FLIP keeps the fraction `flip` of it in each step, so `flip`**100 after 100 steps, to
rounding; with APIC the mode must decay by 99 % in 100 steps. Opposite velocities of nodes: with alpha_0 of a quarter
and more this is an oscillation, whose amplitude does not grow (5 % for the half step between velocity and stress); with
alpha_0 = 0 it causes no stress and remains unchanged to rounding.
"""
# timeout: 120

import numpy as np

import case

BAR = """
&run  dimension='1d' /
&grid  lo=0,0,0  hi=16,1,1  dx=1 /
&time  t_end=1e6  max_steps={steps} /
&method  {words} /
&effects  artificial_viscosity=.false. /
&material  name='bar'  density=1  young=1  poisson=0 /
{halves}
&boundary  face='all'  type='periodic' /
&output  name='p'  kind='particles'  every={every}  precision='double'  fields='identity','velocity' /
&checkpoint  at_end=.false. /
"""
SPEED = 1.0e-4


def halves(sign):
    """Bodies of one particle each, two per cell; `sign` gives the sign of the velocity of a particle from its
    number."""
    text = ""
    for n in range(32):
        text += (f"&region  name='r{n}'  shape='box'  lo={n / 2},0,0  hi={(n + 1) / 2},1,1 /\n"
                 f"&body  name='b{n}'  region='r{n}'  material='bar'  ppc=2,1,1  "
                 f"velocity={SPEED * sign(n)},0,0 /\n")
    return text


def amplitude(run, sign):
    """Fraction of a pattern in the velocities, in each snapshot."""
    shares = []
    for _, snap in run.snapshots():
        velocity = snap.fields["velocity"][np.argsort(snap.points[:, 0]), 0]
        shares.append((velocity * [sign(n) for n in range(32)]).mean() / SPEED)
    return np.array(shares)


def test_in_cells(options, sheet):
    """Particles of a cell with opposite velocities."""
    def sign(n):
        return (-1) ** n
    for name, words, kept in (("usl", "stress_update='usl'", 0.999),
                              ("average", "stress_update='usavg'", 1.0), ("flip", "transfer='flip' flip=1", 1.0),
                              ("apic", "transfer='apic'", None)):
        run = case.Case(options, f"cells_{name}", BAR.format(
            steps=100, every=100, words=words, halves=halves(sign))).run("-q")
        shares = amplitude(run, sign)
        sheet.require(abs(shares[0] - 1.0) < 1.0e-6 and run.summary["steps"] == 100, "modes: begins")
        if kept is None:
            sheet.below(f"in cells, {name}: what is left after 100 steps", shares[-1], 0.01)
        else:
            sheet.near(f"in cells, {name}: what is left after 100 steps", float(shares[-1]), kept ** 100, 1.0e-12)


def test_of_nodes(options, sheet):
    """Nodes with opposite velocities: particles on both sides of a node move with it."""
    def sign(n):
        return (-1) ** ((n + 1) // 2)
    for alpha in (0.0, 0.25, 0.5, 1.0):
        run = case.Case(options, f"nodes_{alpha}", BAR.format(
            steps=60, every=1, words=f"alpha_0={alpha} flip=1", halves=halves(sign))).run("-q")
        shares = amplitude(run, sign)
        least = shares.min()
        sheet.require(abs(shares[0] - 1.0) < 1.0e-6, "nodes: begins")
        if alpha >= 0.25:
            sheet.above(f"of nodes, alpha_0 = {alpha}: share that turns round", -least, 0.1)
            sheet.below(f"of nodes, alpha_0 = {alpha}: greatest share", shares.max(), 1.05)
        else:
            sheet.near(f"of nodes, alpha_0 = {alpha}: least share", float(least), 1.0, 1.0e-12)
            sheet.near(f"of nodes, alpha_0 = {alpha}: greatest share", float(shares.max()), 1.0, 1.0e-12)
