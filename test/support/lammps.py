# SPDX-License-Identifier: BSD-3-Clause
"""Cells of spheres in LAMMPS (pair_style gran), which Debian packages as `lammps`: input and dumps.

    import lammps
    if not lammps.PROGRAM:
        report.skip_all("LAMMPS (lmp) is not installed; apt-get install lammps")
    state = lammps.State.of_checkpoint(path)
    force, torque = lammps.forces(folder, state, density, "pair_style ...", steps=100)

Pairs in LAMMPS have k_n, k_t in N/m and dashpots m gamma v with the reduced mass m; those of scree have g sqrt(m) v.
"""

import os
import shutil
import subprocess
from dataclasses import dataclass

import h5py
import numpy as np

PROGRAM = shutil.which("lmp")
# each of the two ranks of a pair computes the forces on both grains, as in scree; dashpots need the velocities of
# ghosts
HEAD = """units si
atom_style sphere
boundary p p p
newton off
comm_modify vel yes
read_data {data}
neighbor {skin} bin
neigh_modify delay 0 every 1 check yes
{pair}
pair_coeff * *
timestep {dt:.17g}
"""


@dataclass
class State:
    """Spheres in a cell, by identity."""

    edges: np.ndarray                                    # columns: edges of the cell [m]
    position: np.ndarray                                 # (grain, axis) [m]
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    dt: float                                            # time step [s]

    @classmethod
    def of_checkpoint(cls, path):
        """The state of a checkpoint of scree --grains."""
        with h5py.File(path) as handle:
            state = {name: np.array(values) for name, values in handle["state"].items()}
            dt = float(handle.attrs["dt_next"])
        edges = state["edges"][:9].reshape(3, 3).T
        order = np.argsort(state["identity"])
        rows = {name: state[name].reshape(-1, 3)[order] for name in ("place", "velocity", "spin", "force", "torque")}
        place = rows["place"] - np.floor(rows["place"])
        return cls(edges, place @ edges.T, rows["velocity"], rows["spin"], state["radius"][order], rows["force"],
                   rows["torque"], dt)

    def write(self, path, density):
        """A data file of LAMMPS."""
        h = self.edges
        lines = ["spheres", "", f"{len(self.radius)} atoms", "1 atom types", "", *(
            f"0 {h[axis, axis]:.17g} {name}lo {name}hi" for axis, name in enumerate("xyz")),
            f"{h[0, 1]:.17g} {h[0, 2]:.17g} {h[1, 2]:.17g} xy xz yz", "", "Atoms # sphere", ""]
        for n, at in enumerate(self.position):
            lines.append(f"{n + 1} 1 {2 * self.radius[n]:.17g} {density:.17g} " + " ".join(f"{x:.17g}" for x in at))
        lines += ["", "Velocities", ""]
        for n, (v, w) in enumerate(zip(self.velocity, self.spin)):
            lines.append(f"{n + 1} " + " ".join(f"{x:.17g}" for x in (*v, *w)))
        path.write_text("\n".join(lines) + "\n", encoding="ascii")


def run(folder, state, density, pair, commands, timeout=600):
    """Run LAMMPS from a state in an empty folder."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    state.write(folder / "state.data", density)
    text = HEAD.format(data="state.data", skin=0.3 * 2 * state.radius.max(), pair=pair, dt=state.dt) + commands
    (folder / "in.txt").write_text(text, encoding="ascii")
    answer = subprocess.run([PROGRAM, "-in", "in.txt", "-log", "log.txt", "-screen", "none"], cwd=folder,
                            timeout=timeout, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            env={**os.environ, "OMP_NUM_THREADS": "1"})
    if answer.returncode:
        raise AssertionError(f"LAMMPS ended with {answer.returncode}\n{answer.stdout}"
                             f"{(folder / 'log.txt').read_text(encoding='utf-8')[-2000:]}")


def forces(folder, state, density, pair, steps=0):
    """Forces and torques by identity after some steps of velocity Verlet."""
    run(folder, state, density, pair, "fix move all nve/sphere\n"
        f"run {steps}\nwrite_dump all custom last.txt id fx fy fz tqx tqy tqz modify format float %.17g\n")
    rows = np.loadtxt(folder / "last.txt", skiprows=9)
    rows = rows[np.argsort(rows[:, 0])]
    return rows[:, 1:4], rows[:, 4:7]


def shear(folder, state, density, pair, rate, strain, timeout=900):
    """Stress in shear at constant volume: columns strain, p_xy, p_yy, p, with the motion relative to the flow."""
    sheared = State(**{**state.__dict__, "velocity": state.velocity + rate * state.position[:, 1:2] * [1.0, 0, 0]})
    steps = round(strain / rate / state.dt)
    every = max(steps // 400, 1)
    run(folder, sheared, density, pair, "fix move all nve/sphere\n"
        f"fix flow all deform 1 xy erate {rate:.17g} remap v\n"
        "compute heat all temp/deform\ncompute press all pressure heat\n"
        f"fix mean all ave/time 1 {every} {every} c_press[4] c_press[2] c_press file mean.txt\n"
        f"run {steps}\n", timeout)
    rows = np.loadtxt(folder / "mean.txt")
    rows[:, 0] *= state.dt * rate
    return rows
