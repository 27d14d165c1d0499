# SPDX-License-Identifier: BSD-3-Clause
"""Modified Cam-clay of a deck in triaxial and oedometer tests, against integrals of its rate equations.

Would catch: keys that do not reach the law, a sign of the pressure, flow that is not normal to the ellipse, hardening
by the strain of another volume, steps that are not of first order, a path of --point that starts without the pressure
of the clay, and wrong combinations of keys without a message.

`scree --point` returns implicitly to the surface with the density as state. Here drained compression is a differential
equation in the stress ratio eta = q/p (D. M. Wood, Soil behaviour and critical state soil mechanics, 1990, chapter
5): p follows from the stress path, the strains from the flow rule. Undrained compression has closed forms; compression
without lateral strain is a differential equation in the strain, with the compliance of stress ratio and pressure.
"""
# tiers: smoke

import subprocess

import numpy as np
from scipy.integrate import solve_ivp

M, LAMBDA, KAPPA, V0, P0, G = 0.9, 0.25, 0.05, 2.1, 1.5e5, 6.0e6
RATIO = (LAMBDA - KAPPA) / LAMBDA
CLAY = """
&material  name='clay'  density=1750  shear=6.0e6  strength_model='cam_clay'
  mcc_m=0.9  mcc_lambda=0.25  mcc_kappa=0.05  mcc_v0=2.1  mcc_p0=1.5e5  {more} /
&point  {path} /
"""
WRONG = {"mcc_kappa=0.3": "mcc_kappa must be below mcc_lambda", "mcc_pc=1e5": "mcc_pc must not be below mcc_p0",
         "mcc_pc=2e5  mcc_ocr=2": "both given", "bulk=1e7": "as strength_model gives it",
         "mcc_ocr=0.5": "mcc_ocr", "spall=1e5": "spall is not used"}


def run(options, name, path, more=""):
    """Run a deck for a point; its finished process and its folder."""
    folder = options.work / name
    folder.mkdir(parents=True, exist_ok=True)
    text = CLAY.format(path=path, more=more)
    if "mcc_kappa" in more:
        text = text.replace("mcc_kappa=0.05", "")
    (folder / "clay.nml").write_text(text, encoding="ascii")
    return folder, subprocess.run([options.scree, "--point", "clay.nml"], cwd=folder, text=True, capture_output=True,
                                  check=False)


def drive(options, name, path, more=""):
    """Table of a path by column, with p, q and the specific volume."""
    folder, done = run(options, name, path, more)
    if done.returncode != 0:
        raise SystemExit(f"{name}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    table = np.genfromtxt(folder / "out" / "clay" / "clay_point.csv", delimiter=",", names=True)
    return table["strain"], table["pressure"], table["mises"], V0 * 1750.0 / table["density"], table["preconsolidation"]


def drained(strain):
    """q and v at axial strains (positive in compression) of drained compression of normally consolidated clay."""
    def rates(eta, y):
        v = V0 * np.exp(-y[0])
        p = P0 / (1.0 - eta / 3.0)
        growth = 1.0 / (3.0 - eta)                               # dp/p over d eta
        plastic = (LAMBDA - KAPPA) / v * (growth + 2.0 * eta / (M**2 + eta**2))
        shear = p * (1.0 + eta * growth) / (3.0 * G) + plastic * 2.0 * eta / (M**2 - eta**2)
        volume = KAPPA / v * growth + plastic
        return [volume, shear + volume / 3.0]

    end = M * (1.0 - 1.0e-9)
    path = solve_ivp(rates, (0.0, end), [0.0, 0.0], method="LSODA", rtol=1.0e-11, atol=1.0e-13, dense_output=True)
    etas = M * (1.0 - np.geomspace(1.0, 1.0e-9, 20001))
    volume, axial = path.sol(etas)
    eta = np.interp(strain, axial, etas)
    return 3.0 * P0 * eta / (3.0 - eta), V0 * np.exp(-np.interp(strain, axial, volume))


def confined(strain):
    """p and q at axial strains of compression without lateral strain, from the rates of the stresses."""
    def rates(axial, y):
        p, q = y
        v, eta = V0 * np.exp(-axial), q / p
        normal = np.array([M**2 - eta**2, 2.0 * eta])            # of volume and shear strain
        stiffness = np.array([v * p / KAPPA, 3.0 * G])
        # gradient of q**2/p + M**2 p, which is M**2 pc, with respect to p and q
        slope = np.array([M**2 - eta**2, 2.0 * eta])
        hardening = M**2 + eta**2                                # times p: M**2 pc
        total = np.array([1.0, 2.0 / 3.0])
        flow = slope @ (stiffness * total) / (slope @ (stiffness * normal)
                                              + hardening * p * v / (LAMBDA - KAPPA) * normal[0])
        return stiffness * (total - flow * normal)

    return solve_ivp(rates, (0.0, strain[-1]), [P0, 0.0], method="LSODA", rtol=1.0e-11, atol=1.0e-6,
                     t_eval=strain).y


def near_all(sheet, name, values, expected, share):
    """All numbers of a path must equal others: the worst one counts."""
    worst = np.argmax(np.abs(values / expected - 1.0))
    sheet.near(name, values[worst], expected[worst], share)


def test_clay(options, sheet):
    """Four paths and six wrong decks."""
    strain, p, q, v, consolidated = drive(options, "lines", "path='hydrostatic'  strain=-0.25  steps=40  returns=T")
    near_all(sheet, "compression line", v[1:41], V0 - LAMBDA * np.log(p[1:41] / P0), 1.0e-10)
    near_all(sheet, "swelling line", v[40:], v[40] - KAPPA * np.log(p[40:] / p[40]), 1.0e-10)

    worst = []
    for steps in (1000, 4000):
        strain, p, q, v, consolidated = drive(options, f"drained_{steps}", f"path='triaxial'  confinement={P0}"
                                              f"  strain=-0.4  steps={steps}")
        known_q, known_v = drained(-strain)
        worst.append(max(np.abs(q - known_q).max() / known_q[-1], np.abs(v - known_v).max()))
    print(f"drained: worst errors {worst[0]:.2e} and {worst[1]:.2e}")
    sheet.require(worst[1] < 6.0e-4, "drained compression")
    sheet.require(3.0 < worst[0] / worst[1] < 5.5, "first order in the step")

    square = "path='free'  velocity_gradient=-1,0,0,0,0.5,0,0,0,0.5  strain=1.0  steps=4000"
    strain, p, q, v, consolidated = drive(options, "undrained", square)
    eta = q / p
    near_all(sheet, "undrained path", p / P0, (M**2 / (M**2 + eta**2)) ** RATIO, 1.0e-9)
    sheet.near("undrained strength", q[-1], M * P0 * 0.5**RATIO, 1.0e-9)
    strain, p, q, v, consolidated = drive(options, "dry", square, "mcc_ocr=10")
    sheet.near("critical state of overconsolidated clay", p[-1], P0 * 5.0**RATIO, 1.0e-9)
    sheet.near("its stress ratio", q[-1], M * p[-1], 1.0e-9)
    sheet.require((q / p).max() > 1.5 * M, "a stress ratio above that of the critical state")

    strain, p, q, v, consolidated = drive(options, "confined", "strain=-0.2  steps=2500")
    known_p, known_q = confined(-strain)
    sheet.near("confined pressure", p[-1], known_p[-1], 2.0e-5)
    sheet.near("confined shear", q[-1], known_q[-1], 4.0e-5)

    for number, (more, words) in enumerate(WRONG.items()):
        _, done = run(options, f"wrong_{number}", "path='hydrostatic'", more)
        sheet.require(done.returncode != 0 and words in done.stdout + done.stderr, f"a message for {more}")
