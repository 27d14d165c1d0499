# SPDX-License-Identifier: BSD-3-Clause
"""Stability of the time step in one dimension, from the equations of doc/theory/method.md alone.

    body = stable_step.Operator(places, volume, cells)            # positions in cells
    body.limits()                                                 # greatest steps over h/c with usl, and with musl
    stable_step.growth("usavg", courant=0.8, speed=0.1)           # of a lattice that moves through its cells

Lengths are in cells, speeds in wave speeds and densities in that of the body, so that a step is a Courant number.
"""

import numpy as np


class Operator:
    """Mapping S and strain B of the particles, and the masses of the nodes, at fixed positions."""

    def __init__(self, places, volume, cells, dual=True, control=False, periodic=False):
        places = np.asarray(places)
        count, nodes = len(places), cells if periodic else cells + 1
        cell, self.volume = np.floor(places).astype(int), volume
        xi, row = places - cell, np.arange(count)
        left, right = cell % nodes, (cell + 1) % nodes
        smooth = 3.0 * xi**2 - 2.0 * xi**3                                       # (M.11)
        self.map, mapped, self.strain = (np.zeros((count, nodes)) for _ in range(3))
        for values, low, high in ((self.map, 1.0 - xi, xi), (mapped, 1.0 - smooth, smooth), (self.strain, -1.0, 1.0)):
            values[row, left] += low
            values[row, right] += high
        self.mass = volume * self.map.sum(axis=0)
        if dual:
            self._add_nodes(xi, mapped, periodic, control, cell % cells)
        alive = self.mass > 1.0e-12
        self.map, self.strain, self.mass = self.map[:, alive], self.strain[:, alive], self.mass[alive]

    def _add_nodes(self, xi, mapped, periodic, control, cell):
        """The dual gradient (M.2), with the weights of the cells (M.13), and the control variate (Q.4)."""
        nodes, volume = len(self.mass), self.volume
        whole = np.ones(nodes)
        if not periodic:
            whole[[0, -1]] = 0.5
        fill, density = volume * mapped.sum(axis=0) / whole, self.mass / whole
        cells = nodes if periodic else nodes - 1
        covered = 2.0 * volume * np.minimum(np.bincount(cell, xi, cells), np.bincount(cell, 1.0 - xi, cells))
        around, jumps = np.zeros(nodes), np.zeros((nodes, nodes))                # V and D of (M.3)
        for k in range(cells):
            ends = [k, (k + 1) % nodes]
            low, high = np.sort(density[ends])
            weight = min(1.0, 2.0 * fill[ends].min(), 4.0 * low / high if high > 0.0 else 0.0,
                         max(0.0, 4.0 * covered[k], 2.0 - 2.0 * (2.0 - fill[ends].sum())))
            around[ends] += 0.5 * weight
            jumps[np.ix_(ends, ends)] += 0.5 * weight * np.array([[-1.0, 1.0], [-1.0, 1.0]])
        alpha = 4.0 * xi * (1.0 - xi)                                            # (M.8)
        slope = jumps * np.divide(1.0, around, out=np.zeros(nodes), where=around > 0.0)[:, None]
        self.strain = alpha[:, None] * self.strain + ((1.0 - alpha)[:, None] * mapped) @ slope
        if control:
            inside = np.maximum(0.0, 1.0 - 2.0 * (1.0 - around / whole))         # (Q.5)
            share = np.divide(inside, self.mass, out=np.zeros(nodes), where=self.mass > 1.0e-12)
            self.strain = self.strain - self.map @ (share[:, None] * (volume * self.map.T @ self.strain - jumps))

    def limits(self):
        """Greatest stable steps with usl, and with musl."""
        root = np.sqrt(self.mass)
        stiff = self.volume * self.strain.T @ self.strain / np.outer(root, root)
        spread = self.volume * self.map.T @ self.map / np.outer(root, root)
        one = np.eye(len(root))

        def stable(step):
            """Does no mode grow?"""
            modes = np.block([[one - step**2 * stiff, step * one], [-step * spread @ stiff, one]])
            return abs(np.linalg.eigvals(modes)).max() < 1.0 + 3.0e-5

        low, high = 0.0, 3.0 / np.sqrt(np.linalg.eigvalsh(stiff)[-1])
        while high - low > 1.0e-3 * high:
            middle = 0.5 * (low + high)
            low, high = (middle, high) if stable(middle) else (low, middle)
        return low, float(2.0 / np.sqrt(np.linalg.eigvals(stiff @ spread).real.max()))


def lattice(count, ppc, offset=0.0):
    """Positions of a lattice with a number of particles per cell; the offset is in cells."""
    return (np.arange(count * ppc) + 0.5) / ppc + offset


def growth(update, courant, speed, ppc=2, cells=12, **rule):
    """Exponent of the fastest growing amplitude, for each cell through which a lattice moves: the product of the steps
    until each particle is at the position of the next one."""
    step = courant / (1.0 + speed)
    steps = max(1, int(np.ceil(1.0 / (ppc * speed * step))))
    step = 1.0 / (ppc * speed * steps)
    count, total = cells * ppc, None
    one, zero = np.eye(count), np.zeros((count, count))
    for number in range(steps):
        body = Operator((lattice(cells, ppc) + number * speed * step + 1.0e-7) % cells, 1.0 / ppc, cells,
                        periodic=True, **rule)
        nodes = body.map.T / (ppc * body.mass[:, None])                          # velocities of the nodes
        gain = -step * body.strain.T / (ppc * body.mass[:, None])                # of the nodes, by the stress
        before = body.strain @ nodes
        after = body.strain @ (gain if update == "usl" else nodes @ body.map @ gain)
        if update == "usavg":                                                    # (T.9)
            change = np.block([[one, body.map @ gain, zero],
                               [1.5 * step * before, one + step * after, -0.5 * step * one], [before, after, zero]])
        else:
            change = np.block([[one, body.map @ gain], [step * before, one + step * after]])
        total = change if total is None else change @ total
    turn = np.kron(np.eye(len(total) // count), np.roll(one, 1, axis=1))
    return float(np.log(abs(np.linalg.eigvals(turn @ total)).max()) * ppc)
