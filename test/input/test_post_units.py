# SPDX-License-Identifier: BSD-3-Clause
# tiers: full, long
# timeout long: 900
"""Every command of scree-post on every kind of output, in each system of units, against the same run in SI.

The run has the same bits for any `output_units`, so all that scree-post prints, writes and draws must be the same:
words, units, names, and numbers to nine digits, of which the last may be rounded differently.

Would catch: a time, a length, a column or a field that is taken for SI in a file in other units (times were wrong by
1e6), a unit in a table or a title that does not belong to its number, a valid run that `check` reports as wrong, and a
command that reads files directly instead of through scree_post/units.py.
"""

import re
import shutil

import numpy as np

import case
import post_command
import tier

# Length, mass and time of the first two differ from SI and from each other.
SYSTEMS = ("cgs", "mm-us-mg") if tier.NAME == "full" else ("cgs", "mm-ms-kg", "mm-ms-g", "cm-us-g", "mm-us-mg")
BODY = """
&units system = '{system}'  output_units = '{units}' /
&grid lo = 0 0 0  hi = {20} {1} {10}  dx = {1} /
&time t_end = {t} /
&material name = 'metal'  density = {rho}  young = {young}  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = {5} 0 {5}  radius = {3} /
&region name = 'wall'  shape = 'box'  lo = {8} 0 0  hi = {12} {1} {10} /
&body name = 'one'  region = 'ball'  material = 'metal'  velocity = {v} 0 {w} /
&body name = 'two'  region = 'wall'  material = 'metal' /
&output name = 'h'  kind = 'history'  count = 4  fields = 'default' 'front_x' 'noise' /
&output name = 'p'  kind = 'particles'  count = 2  precision = 'double'  fields = 'default' 'stress'  'density' /
&output name = 'g'  kind = 'grid'  count = 2  precision = 'double' /
&output name = 's'  kind = 'slice'  axis = 'z'  at = {5.1}  count = 2  precision = 'double' /
&output name = 'f'  kind = 'profile'  count = 2  bins = 10 /
&output name = 'b'  kind = 'fragments'  count = 2 /
"""
HEAD = "&run dimension = 'plane_strain'  title = 'A ball and a wall' /"
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?(?![\w])")
CLOSE, NOISE = 1.0e-4, 1.0e-9      # for numbers of five digits; relative to the greatest number of a line


def deck(system, units):
    """The scene with its lengths in mm, written in SI or in mm, us, mg."""
    mm = {"si": 1.0e-3, "mm-us-mg": 1.0}[system]
    values = {word: f"{float(word) * mm:.12g}" for word in re.findall(r"\{([\d.]+)\}", BODY)}
    values |= {"si": {"t": "1e-6", "rho": "2700", "young": "70e9", "v": "1000", "w": "300"},
               "mm-us-mg": {"t": "1", "rho": "2.7", "young": "70", "v": "1", "w": "0.3"}}[system]
    text = BODY
    for name, value in {**values, "system": system, "units": units}.items():
        text = text.replace("{" + name + "}", value)
    return HEAD + text


def commands(run):
    """All command lines, with the pictures and tables that they write; OUT stands for a folder of their own."""
    path = {ending: run.path(ending) for ending in (
        "_p.hdf.series", "_g.hdf.series", "_s.hdf.series", "_p_000001.hdf", "_g_000001.hdf", "_chk_0001.h5",
        "_history.csv", "_profile.csv", "_fragments.csv")}
    folder = path["_history.csv"].parent
    yield ["info", folder], ()
    for file in path.values():
        yield ["info", file], ()
    for ending in ("_p.hdf.series", "_g.hdf.series", "_s.hdf.series"):
        yield ["info", path[ending], "--time", "0.6us"], ()
        yield ["check", path[ending]], ()
    yield ["info", path["_p.hdf.series"], "--all"], ()
    for ending in ("_history.csv", "_profile.csv", "_fragments.csv"):
        y = {"_history.csv": "kinetic,impulse_x,front_x,noise,torque_impulse_y", "_profile.csv": "mass,position",
             "_fragments.csv": "kinetic,centre_x,angular_momentum_y"}[ending]
        yield ["plot", path[ending], "--y", y, "--title", "columns", "--out", "OUT/y.png"], ["y.png"]
    yield ["plot", folder, "--title", "ledger", "--out", "OUT/ledger.png"], ["ledger.png"]
    for colour in ("velocity", "stress.xx", "density", "body"):
        yield ["picture", folder, "--colour", colour, "--time", "0.6us", "--out", "OUT/c.png"], ["c.png"]
    yield ["movie", folder, "--colour", "pressure", "--from", "0.4us", "--out", "OUT/m.png"], [
        "m_000000.png", "m_000001.png"]
    yield ["radiograph", folder, "--time", "0.5", "--view", "-1", "11", "0", "20", "--out", "OUT/r.png"], ["r.png"]
    yield ["radiograph", folder, "--time", "500ns", "1us", "--pixel", "0.05", "--out", "OUT/r.png"], ["r.png"]
    yield ["fragments", folder, "--time", "0.5us", "1us", "--table", "OUT/t.csv", "--out", "OUT/f.png"], [
        "t.csv", "f.png"]
    yield ["compare", folder, folder], ()
    yield ["compare", path["_history.csv"], path["_history.csv"], "--interpolate"], ()


def studies(run, options):
    """The commands that run the program themselves."""
    same = shutil.copy(run.deck, options.work / "study.nml")     # its name is in the title
    yield ["sweep", same, "--set", "material.poisson=0.2,0.3", "--scree", options.scree, "--outdir", "OUT/sweep",
           "--take", "time,kinetic,front_x,length,impulse_x"], ["sweep/sweep.csv", "sweep/sweep.png"]
    yield ["accuracy", same, "--quantity", "front_x", "kinetic:at=0.6us", "length", "ledger.energy_error",
           "--factors", "4,2,1", "--scree", options.scree, "--work", "OUT/work", "--tolerance", "0.1mm",
           "--csv", "OUT/a.csv"], ["a.csv"]


def differences(one, two):
    """Positions where two texts differ: other words, or numbers that are not the same."""
    lines = one.splitlines(), two.splitlines()
    if len(lines[0]) != len(lines[1]):
        return [f"{len(lines[0])} and {len(lines[1])} lines"]
    found = []
    for left, right in zip(*lines):
        values = [[float(word) for word in NUMBER.findall(line)] for line in (left, right)]
        words = [re.sub(r"[ ,]+", " ", NUMBER.sub("#", line)) for line in (left, right)]
        noise = NOISE * max(map(abs, values[0]), default=0.0)
        if words[0] != words[1] or any(abs(a - b) > max(CLOSE * abs(a), noise) for a, b in zip(*values)):
            found.append(f"'{left}' is '{right}'")
    return found


def seconds_left_out(text):
    """The output of a study without parts that depend on the machine: core-seconds, forecasts from them, and
    the progress."""
    kept = [line for line in text.splitlines() if ("core-seconds" not in line or "cells [" in line)
            and not re.search(r"\d+ of \d+ runs|^done .*\(\d+ of \d+\)", line)]
    return "\n".join(re.sub(r"^( +\S+ +\d+ +\d+) +\S+", r"\1", line) for line in kept)


def results(run, options, work, wanted):
    """All output, files and pictures of all commands."""
    found = {}
    for words, files in wanted(run, options) if wanted is studies else wanted(run):
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir(parents=True)
        line = [str(word).replace("OUT", str(work)) for word in words]
        if words[0] in ("plot", "picture", "movie", "radiograph", "fragments"):
            line += ["--dpi", "50"]
        answer = post_command.call(*line, folder=work)
        name = " ".join(line).replace(str(work), "").replace(run.name, "CASE").replace(str(options.work), "")
        text = (answer.stdout + answer.stderr).replace(str(work), "").replace(run.name, "CASE")
        text = seconds_left_out(text.replace(str(options.work), ""))
        found[name] = [f"exit code {answer.returncode}", text]
        for file in files:
            path = work / file
            found[name].append(path.read_bytes() if path.suffix == ".csv" else picture(path))
    return found


def picture(path):
    """The pixels of a picture."""
    import matplotlib.image
    return matplotlib.image.imread(str(path)) if path.exists() else np.zeros((1, 1, 3))


def table_text(data):
    """A table without folders and without times measured on the machine."""
    rows = [line.split(",") for line in data.decode("utf-8").splitlines()]
    drop = {column for column, head in enumerate(rows[0]) if head in ("folder", "core_seconds", "wall_s")}
    return "\n".join(" ".join(word for column, word in enumerate(row) if column not in drop) for row in rows)


def compare(sheet, system, one, two):
    """All results of one system of units against those in SI."""
    sheet.require(list(one) == list(two), f"{system}: {len(two)} commands, {len(one)} in SI")
    for name in one:
        wrong = []
        for left, right in zip(one[name], two.get(name, [])):
            if isinstance(left, bytes):
                wrong += differences(table_text(left), table_text(right))
            elif isinstance(left, str):
                wrong += differences(left, right)
            elif left.shape != right.shape or np.mean(np.abs(left - right) > 0.1) > 1.0e-4:
                wrong.append("another picture")
        sheet.require(not wrong, f"{system}: {name}: {'the same as in SI' if not wrong else ' | '.join(wrong[:3])}")


def test_post_units(options, sheet):
    """The same scene in all systems."""
    si = case.Case(options, "in_si", deck("si", "si")).run("--quiet")
    wanted = results(si, options, options.work / "post", commands)
    for name, (code, text, *_) in wanted.items():
        sheet.require(code == "exit code 0", f"si: {name}: {code}{'' if code[-1] == '0' else ': ' + text[-200:]}")
    sheet.require(any("1e-06 s" in text[1] for text in wanted.values()), "times are in seconds")
    for system in SYSTEMS:
        run = case.Case(options, "in_" + system.replace("-", "_"), deck("si", system)).run("--quiet")
        compare(sheet, system, wanted, results(run, options, options.work / "post", commands))
    both = [si, run]
    answer = post_command.call("compare", *(run.path("_history.csv") for run in both), "--tolerance", "1e-12")
    sheet.require(answer.returncode == 0, f"histories of two systems are the same: {answer.stdout[-200:]}")
    answer = post_command.call("compare", *(run.folder for run in both), "--tolerance", "1e-12")
    sheet.require(answer.returncode == 0, f"particles of two systems are the same: {answer.stdout[-200:]}")
    own = case.Case(options, "in_own", deck("mm-us-mg", "deck")).run("--quiet")
    compare(sheet, "deck in mm, us, mg", wanted, results(own, options, options.work / "post", commands))
    told = results(si, options, options.work / "post", studies)
    for name, (code, text, *_) in told.items():
        sheet.require(code == "exit code 0", f"si: {name}: {code}{'' if code[-1] == '0' else ': ' + text[-300:]}")
    compare(sheet, "cm-us-g", told, results(case.Case(options, "in_cm_us_g", deck("si", "cm-us-g")).run("--quiet"),
                                            options, options.work / "post", studies))
    answer = post_command.call("accuracy", own.deck, "--quantity", "length", "--factors", "4,2,1", "--scree",
                               options.scree, "--work", options.work / "own_work")
    sheet.require(answer.returncode == 0 and "cells [mm]" in answer.stdout and "length [m]" in answer.stdout,
                  f"cells are in the unit of the deck, the length in m: {answer.stdout[-300:]}{answer.stderr}")
