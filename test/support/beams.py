# SPDX-License-Identifier: BSD-3-Clause
"""A clamped beam in plane strain under suddenly applied gravity, and its expected motion.

    import beams
    expected = beams.expected(poisson)                 # greatest deflection of the tip, and when
    result = beams.bend(options, "name", poisson, spacing=0.25, words="antilock='bbar'")

The reference has two parts. Finite elements without locking (nine nodes, three pressures each: Q2/P1) give the static
deflection; the clamp, which prevents the end from becoming thicker, makes it some percent smaller than that of a
Timoshenko beam. The modes of that beam, with its stiffness scaled so that both agree, give the motion.
"""

import numpy as np

import bodies
import measured

LENGTH, HEIGHT, YOUNG, DENSITY, GRAVITY = 5.0, 1.0, 1.0e6, 1000.0, 0.1
DECK = """
&run  dimension='plane_strain'  method='{method}' /
&grid  lo=0,0,-1  hi=6,1,2  dx={spacing!r} /
&time  t_end={end!r}  cfl=0.5 /
&method  {words} /
&effects  gravity=.true.  gravity_vector=0,0,{gravity}  artificial_viscosity=.false. /
&material  name='rubber'  density={density}  young={young}  poisson={poisson}  strength_model='neo_hookean' /
&region  name='beam'  shape='box'  lo=0,0,0  hi={length},1,{height} /
&body  name='beam'  region='beam'  material='rubber'  ppc={ppc},1,{ppc} /
&boundary  face='xlo'  type='stick' /
"""


def elements(poisson, cells=(40, 8)):
    """Static deflection of the middle of the end, by finite elements with a pressure that is linear in each element."""
    nx, nz = cells
    columns = 2 * nz + 1
    hx, hz = LENGTH / nx, HEIGHT / nz
    shear, bulk = YOUNG / (2 + 2 * poisson), YOUNG / (3 - 6 * poisson)
    # In plane strain the deviator has a component across the plane: 2 G (I - m m'/3) and G for the shear.
    deviator = shear * np.array([[4.0 / 3.0, -2.0 / 3.0, 0.0], [-2.0 / 3.0, 4.0 / 3.0, 0.0], [0.0, 0.0, 1.0]])
    places, weights = (-np.sqrt(0.6), 0.0, np.sqrt(0.6)), (5 / 9, 8 / 9, 5 / 9)
    stiff, mean, mass, load = np.zeros((18, 18)), np.zeros((3, 18)), np.zeros((3, 3)), np.zeros(18)

    def line(s):
        return (np.array([0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)]),
                np.array([s - 0.5, -2 * s, s + 0.5]))

    for s, u in zip(places, weights):
        for t, v in zip(places, weights):
            (n, dn), (m, dm) = line(s), line(t)
            dx, dz = np.outer(dn, m).ravel() * 2 / hx, np.outer(n, dm).ravel() * 2 / hz
            area = u * v * hx * hz / 4
            strain = np.zeros((3, 18))
            strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = dx, dz, dz, dx
            linear = np.array([1.0, s, t])
            stiff += area * strain.T @ deviator @ strain
            mean += area * np.outer(linear, strain[0] + strain[1])
            mass += area * np.outer(linear, linear)
            load[1::2] += area * DENSITY * GRAVITY * np.outer(n, m).ravel()
    stiff += bulk * mean.T @ np.linalg.solve(mass, mean)
    # Nodes are numbered column by column; the unknowns of adjacent nodes are within a band, so columns are eliminated
    # in turn.
    size = 2 * columns
    total = np.zeros((2 * nx + 1, 3, size, size))          # rows of column i to columns i, i + 1, i + 2
    force = np.zeros((2 * nx + 1, size))
    for ix in range(nx):
        for iz in range(nz):
            own = [2 * (2 * iz + k) + c for k in range(3) for c in range(2)]
            for a in range(3):
                force[2 * ix + a][own] += load[6 * a:6 * a + 6]
                for b in range(a, 3):
                    total[2 * ix + a, b - a][np.ix_(own, own)] += stiff[6 * a:6 * a + 6, 6 * b:6 * b + 6]
    pairs = [np.vstack((force[2 * i + 1], force[2 * i + 2])).ravel() for i in range(nx)]
    own, next_to = [], []
    for i in range(nx):
        a, b = 2 * i + 1, 2 * i + 2
        own.append(np.block([[total[a, 0], total[a, 1]], [total[a, 1].T, total[b, 0]]]))
        if i + 1 < nx:
            next_to.append(np.block([[total[a, 2], np.zeros((size, size))], [total[b, 1], total[b, 2]]]))
    for i in range(nx - 1):
        factor = np.linalg.solve(own[i], next_to[i]).T
        own[i + 1] = own[i + 1] - factor @ next_to[i]
        pairs[i + 1] = pairs[i + 1] - factor @ pairs[i]
    return float(np.linalg.solve(own[-1], pairs[-1])[size + 2 * nz + 1])


def timoshenko(poisson):
    """Static deflection of a beam whose clamp allows it to become thicker."""
    modulus, shear = YOUNG / (1.0 - poisson ** 2), YOUNG / (2.0 + 2.0 * poisson) * 5.0 / 6.0
    load = DENSITY * GRAVITY * HEIGHT
    return load * LENGTH ** 4 / (8.0 * modulus * HEIGHT ** 3 / 12.0) + load * LENGTH ** 2 / (2.0 * shear * HEIGHT)


def expected(poisson, parts=200):
    """Greatest deflection of the tip in its first oscillation, its time, and the static deflection."""
    modulus, shear = YOUNG / (1.0 - poisson ** 2), YOUNG / (2.0 + 2.0 * poisson) * 5.0 / 6.0
    inertia, size = HEIGHT ** 3 / 12.0, LENGTH / parts
    stiff, mass = np.zeros((2 * parts + 2,) * 2), np.zeros(2 * parts + 2)
    bend = modulus * inertia / size * np.array([[1.0, -1.0], [-1.0, 1.0]])
    lift = np.array([-1.0 / size, -0.5, 1.0 / size, -0.5])
    for n in range(parts):
        own = np.arange(2 * n, 2 * n + 4)
        stiff[np.ix_(own[1::2], own[1::2])] += bend
        stiff[np.ix_(own, own)] += shear * HEIGHT * size * np.outer(lift, lift)
        mass[own] += 0.5 * size * DENSITY * np.array([HEIGHT, inertia] * 2)
    stiff, mass = stiff[2:, 2:], mass[2:]
    load = mass * GRAVITY
    load[1::2] = 0.0
    rest = elements(poisson)
    stiff *= np.linalg.solve(stiff, load)[-2] / rest
    root = np.sqrt(mass)
    squares, modes = np.linalg.eigh(stiff / np.outer(root, root))
    times = np.linspace(0.0, 1.5 * np.pi / np.sqrt(squares[0]), 3001)[1:]
    share = modes[-2] / root[-2] * (modes.T @ (load / root)) / squares
    swing = (share[:20, None] * (1.0 - np.cos(np.sqrt(squares[:20])[:, None] * times))).sum(axis=0)
    most = int(np.argmax(swing))
    return {"fall": float(swing[most]), "when": float(times[most]), "rest": rest}


@measured.recorded
def bend(options, name, poisson, spacing, words="", method="ddmp", ppc=2):
    """One beam: greatest deflection of the middle of the end, its time, and the pressure differences between cells at
    that time."""
    end = 1.15 * expected(poisson)["when"]
    deck = DECK.format(method=method, words=words, spacing=spacing, ppc=ppc, poisson=poisson, end=end, young=YOUNG,
                       density=DENSITY, gravity=-GRAVITY, length=LENGTH, height=HEIGHT)
    run, result = bodies.launch(options, name, deck, every=50, count=60)
    snaps = run.snapshots()
    first = snaps[0][1]
    order = np.argsort(first.fields["identity"])
    start = first.points[order][:, [0, 2]]
    across = np.round(HEIGHT / spacing * ppc)
    near = start[:, 0] > LENGTH - spacing / ppc
    behind = (start[:, 0] > LENGTH - 2 * spacing / ppc) & ~near
    times, falls, states = [], [], []
    for time, snap in snaps:
        rank = np.argsort(snap.fields["identity"])
        drop = start[:, 1] - snap.points[rank, 2]
        assert near.sum() == across
        times.append(time)
        falls.append(1.5 * drop[near].mean() - 0.5 * drop[behind].mean())
        states.append(-snap.fields["stress"][rank, :3].sum(axis=1) / 3.0)
    most = int(np.argmax(falls))
    result.update(fall=falls[most], when=times[most], jump=jumps(start, states[most], spacing),
                  spread=spread(start, states[most], spacing))
    return result


def cells_of(start, pressure, spacing):
    """Mean pressure of the initial cells, along the beam and across."""
    place = np.floor(start / spacing).astype(int)
    shape = place.max(axis=0) + 1
    index = place[:, 0] * shape[1] + place[:, 1]
    return (np.bincount(index, pressure) / np.bincount(index)).reshape(shape)


def jumps(start, pressure, spacing):
    """Greatest difference of a cell from the mean of its neighbours along the beam, over the greatest pressure;
    without the parts within one height of the beam from the clamp and the tip."""
    mean = cells_of(start, pressure, spacing)
    off = int(HEIGHT / spacing)
    jump = mean[1:-1] - 0.5 * (mean[2:] + mean[:-2])
    return float(np.abs(jump[off - 1:1 - off]).max() / np.abs(mean[off:-off]).max())


def spread(start, pressure, spacing):
    """Root mean square difference of particles from their cell, over the greatest mean pressure of a cell."""
    mean = cells_of(start, pressure, spacing)
    place = np.floor(start / spacing).astype(int)
    inside = (start[:, 0] > HEIGHT) & (start[:, 0] < LENGTH - HEIGHT)
    return bodies.rms((pressure - mean[place[:, 0], place[:, 1]])[inside]) / np.abs(mean).max()
