# SPDX-License-Identifier: BSD-3-Clause
"""Draw the figures of doc/theory/hard_cases.md: gas at rest and two rings that collide.

    python test/verify/draw_hard_cases.py --scree build/bin/scree --work FOLDER
"""

import matplotlib
import numpy as np
from matplotlib import pyplot
from PIL import Image

import _support
import bodies
import case

matplotlib.use("Agg")
END = "&output  name='h'  kind='history'  every=20 /\n&checkpoint  at_end=.false. /\n"
GAS = """&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=1,0.3,0.6  dx=0.05 /
&time  t_end=100  max_steps=300 /
&effects  strength=.false. /
&method  normalise='{0}' /
&material  name='gas'  density=1.225  eos_model='ideal_gas'  ig_gamma=1.4 /
&region  name='all'  shape='box'  lo=0,0,0  hi=1,0.3,0.6 /
&body  name='all'  region='all'  material='gas'  ppc=3,1,3  packing='jitter'  specific_energy=206786 /
&boundary  face='all'  type='slip' /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='velocity' /
""" + END
RINGS = """&run  dimension='plane_strain' /
&grid  lo=-0.12,0,-0.08  hi=0.12,0.004,0.08  dx=0.002 /
&time  t_end=4e-3 /
&method  {0} /
&effects  eos=.false.  artificial_viscosity=.false. /
&material  name='rubber'  density=1010  bulk=121.7e6  shear=26.1e6  strength_model='neo_hookean' /
""" + bodies.RINGS + """&output  name='p'  kind='particles'  times=1.0e-3  fields='mises' /
""" + END


def save(figure, name):
    """Write a figure with few colours, so that pictures of many particles stay small."""
    path = _support.FIGURES / f"{name}.png"
    figure.tight_layout()
    figure.savefig(path, dpi=150)
    pyplot.close(figure)
    Image.open(path).convert("RGB").quantize(192).save(path, optimize=True)
    print(f"{path.name} {path.stat().st_size // 1000} kB", flush=True)


def run(options, name, deck, value):
    """One run; the case and its last snapshot."""
    trial = case.Case(options, f"draw_{name}", deck.format(value)).run("-q", timeout=500)
    return trial, trial.snapshots()[-1][1]


def gas(options):
    """Speed over that of sound, on a logarithmic scale."""
    figure, both = pyplot.subplots(1, 2, figsize=(7.0, 2.3), sharey=True)
    for axes, words in zip(both, ("none", "gases")):
        last = run(options, f"gas_{words}", GAS, words)[1]
        speed = np.linalg.norm(last.need("velocity")[0], axis=1) / np.sqrt(1.4 * 0.4 * 206786)
        dots = axes.scatter(*last.points[:, (0, 2)].T, c=np.log10(np.maximum(speed, 1e-16)), s=4, vmin=-16, vmax=0)
        axes.set(title=f"normalise = '{words}'", xlabel="x [m]", aspect="equal")
        figure.colorbar(dots, ax=axes, label="log10 of speed over sound", shrink=0.8)
    both[0].set_ylabel("z [m]")
    save(figure, "hard_gas")


def rings(options):
    """The rings at their greatest deformation, and the energy of three ways to update the stress."""
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(7.0, 2.5))
    for label, words in (("default", ""), ("'musl'", "stress_update='musl'"), ("'usl'", "stress_update='usl'")):
        trial, _ = run(options, f"rings_{label.strip(chr(39))}", RINGS, words)
        history = trial.history
        energy = history["kinetic"] + history["internal"]
        right.plot(np.array(history["time"]) * 1e3, np.array(energy) / energy[0], label=label)
        if not words:
            early = trial.snapshots()[0][1]
            dots = left.scatter(*early.points[:, (0, 2)].T * 1e3, c=early.need("mises")[0] / 1e6, s=1, vmax=10)
    left.set(xlabel="x [mm]", ylabel="z [mm]", aspect="equal", title="1 ms, default")
    figure.colorbar(dots, ax=left, label="von Mises stress [MPa]")
    right.set(xlabel="time [ms]", ylabel="energy over that at the start", ylim=(0, 1.1))
    right.legend()
    save(figure, "hard_rings")


if __name__ == "__main__":
    OPTIONS = case.arguments()
    pyplot.rcParams.update({"font.size": 8, "axes.titlesize": 8, "axes.grid": True, "grid.alpha": 0.3})
    for draw in (gas, rings):
        draw(OPTIONS)
