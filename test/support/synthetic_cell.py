# SPDX-License-Identifier: BSD-3-Clause
"""Results of a cell of grains with known constants, in the format of scree --grains.

    import synthetic_cell
    synthetic_cell.write(folder, seed=1)       # CASE_history.csv, CASE.echo.nml, contacts, grains, moduli
"""

import json
import shutil
from pathlib import Path

import h5py
import numpy as np

CASE = "synthetic"
DIAMETER, DENSITY, PRESSURE = 1.0e-3, 2500.0, 1.0e3
MU_S, A, PHI_C, B = 0.25, 1.1, 0.81, 0.3
W, CORRELATION, AGE, RETURN = 0.08, 0.03, 0.1, 0.05          # strains
HOLD_TAU, HOLD_BETA, HOLD_REST = 2.0e-3, 1.5, 0.4
SHEAR, LAME = 8.0e4, 2.0e5
NOISE = 0.1                                                   # of the shear stress over its mean
#: name, inertial number (0: hold; None: compression), strain or time [s], rows
STAGES = (("compress", None, 0.1, 20), ("fast", 0.1, 12.0, 1200), ("middle", 0.05, 12.0, 1200),
          ("slow", 0.01, 12.0, 2400), ("reverse", -0.01, 8.0, 1600), ("stop", 0.0, 0.04, 400))
COLUMNS = ("step", "stage", "time [s]", "strain [1]", "rate_xx [1/s]", "rate_yy [1/s]", "rate_xy [1/s]",
           "volume_fraction [1]", "stress_xx [Pa]", "stress_yy [Pa]", "stress_xy [Pa]", "coordination_held [1]")


def rate_of(inertial):
    """Shear rate of an inertial number [1/s]."""
    return inertial * np.sqrt(PRESSURE / DENSITY) / DIAMETER


def noise(generator, rows, width, inner=5):
    """Means over intervals of a series with the correlation exp(-strain/CORRELATION) and variance 1."""
    kept = np.exp(-width / inner / CORRELATION)
    steps = generator.standard_normal(rows * inner)
    steps[1:] *= np.sqrt(1.0 - kept * kept)
    values = np.empty_like(steps)
    value = 0.0
    for n, step in enumerate(steps):
        value = step if n == 0 else kept * value + step
        values[n] = value
    return values.reshape(rows, inner).mean(axis=1)


def rows_of(stages, generator):
    """Rows of the history and the end time of each stage."""
    rows = [[0.0, 1, 0.0, 0.0, -10.0, -10.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0]]
    time = strain = stress = 0.0
    ends = []
    for number, (_, inertial, length, count) in enumerate(stages, 1):
        part = (np.arange(count) + 1.0) / count
        middle = (np.arange(count) + 0.5) / count
        rate = rate_of(inertial or 0.0)
        duration = length / abs(rate) if rate else length
        mu = MU_S + A * abs(inertial or 0.0)
        steady = np.sign(rate) * mu * PRESSURE
        if rate:
            shear = steady + (stress - steady) * np.exp(-length * middle / RETURN)
            shear = shear + NOISE * abs(steady) * noise(generator, count, length / count)
            stress = steady
        elif inertial is None:
            shear = np.zeros(count)
        else:
            kept = np.exp(-(length * middle / HOLD_TAU) ** HOLD_BETA)
            shear = stress * (HOLD_REST + (1.0 - HOLD_REST) * kept)
        normal = -PRESSURE * np.ones(count)
        other = normal + 2.0 * W * shear * np.sign(rate)
        fraction = PHI_C - B * abs(inertial or 0.0) + 1.0e-3 * noise(generator, count, 0.01)
        squeeze = -5.0 if inertial is None else 0.0
        for k in range(count):
            rows.append([len(rows), number, time + duration * part[k], strain + abs(rate) * duration * part[k], squeeze,
                         squeeze, rate, fraction[k], other[k], normal[k], shear[k], 3.0])
        time, strain = time + duration, strain + abs(rate) * duration
        ends.append((time - duration, time))
    return rows, ends


def echo(stages):
    """The echo of the deck, as the program writes it."""
    lines = ["&run", f"   case = '{CASE}'", "/", "&grains", "   shape = 'discs'", "   number = 100",
             f"   diameter = {DIAMETER}", f"   density = {DENSITY}", "   friction = 0.4", "/", "&cell",
             f"   pressure = {PRESSURE}", "/"]
    for name, *_ in stages:
        lines += ["&stage", f"   name = '{name}'", "/"]
    return "\n".join(lines) + "\n"


def write_snapshot(path, time, generator, ages, rate):
    """A file of grains and one of contacts."""
    edges = np.array([[0.01, 0.0, 0.0], [0.002, 0.01, 0.0], [0.0, 0.0, 1.0]])
    count = len(ages)
    for kind, points in (("grains", 100), ("contacts", 2 * count)):
        with h5py.File(str(path).replace("KIND", kind), "w") as handle:
            place = generator.random((points, 3)) @ edges
            place[:, 2] = 0.0
            handle["VTKHDF/Points"] = place
            handle["VTKHDF/FieldData/TimeValue"] = [time]
            handle["VTKHDF/FieldData/edges"] = edges
            handle["VTKHDF/PointData/radius"] = np.full(points, 0.5 * DIAMETER)
            handle["VTKHDF/PointData/contacts"] = np.full(points, 3.0)
            if kind == "contacts":
                handle["VTKHDF/CellData/age_strain"] = ages
                handle["VTKHDF/CellData/age"] = ages / rate
                handle["VTKHDF/CellData/normal_force"] = generator.random(count)


def write_contacts(folder, stages, ends, generator, snapshots, count):
    """Snapshots of all shear stages with ages of the survival law exp(-a/AGE)."""
    entries = {"grains": [], "contacts": []}
    for (_, inertial, length, _), (begin, end) in zip(stages, ends):
        for k in range(snapshots if inertial else 0):
            time = begin + (end - begin) * (k + 1) / snapshots
            window = length * (k + 1) / snapshots
            ages = generator.exponential(AGE, count)
            # older contacts began in the previous stage, where they had longer lifetimes
            ages = np.where(ages < window, ages, window + generator.exponential(10.0 * AGE, count))
            name = f"{CASE}_KIND_{len(entries['grains']):06d}.hdf"
            write_snapshot(folder / name, time, generator, ages, abs(rate_of(inertial)))
            for kind, found in entries.items():
                found.append({"name": name.replace("KIND", kind), "time": time})
    for kind, found in entries.items():
        if found:
            (folder / f"{CASE}_{kind}.hdf.series").write_text(
                json.dumps({"file-series-version": "1.0", "files": found}), encoding="utf-8")


def write(folder, seed=1, stages=STAGES, snapshots=12, count=300):
    """Write all files of a run into a new folder; the result is the folder."""
    folder = Path(folder)
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    generator = np.random.default_rng(seed)
    rows, ends = rows_of(stages, generator)
    lines = [",".join(COLUMNS), *(",".join(f"{value:.17g}" for value in row) for row in rows)]
    (folder / f"{CASE}_history.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    (folder / f"{CASE}.echo.nml").write_text(echo(stages), encoding="utf-8")
    summary = json.dumps({"exit_code": 0, "reason": "last stage finished"})
    (folder / f"{CASE}.summary.json").write_text(summary, encoding="utf-8")
    write_contacts(folder, stages, ends, generator, snapshots, count)
    head = "step,stage,time [s],relaxed,component,xx [Pa],yy [Pa],zz [Pa],xy [Pa],xz [Pa],yz [Pa],pressure [Pa]"
    push, last = LAME + 2.0 * SHEAR, len(stages)
    stiffness = {1: (push, LAME, 0, 0, 0, 0), 2: (LAME, push, 0, 0, 0, 0), 4: (0, 0, 0, SHEAR, 0, 0)}
    table = [head] + [f"1,{last},{ends[-1][1]},{relaxed},{component}," + ",".join(
        str(value * (1 + relaxed)) for value in row) + f",{PRESSURE}"
        for relaxed in (0, 1) for component, row in stiffness.items()]
    (folder / f"{CASE}_moduli.csv").write_text("\n".join(table) + "\n", encoding="utf-8")
    return folder
