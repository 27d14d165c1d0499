# SPDX-License-Identifier: BSD-3-Clause
"""Strength laws in shared libraries, in whole runs.

Would catch: components, units or fields that reach a library in another place; rows outside of those of a call; a field
of a library that is not sorted, sent to other ranks or stored in checkpoints; a library that only one rank has; plastic
work that the program computes with a wrong sign or factor; a damage model that does not see the flow of a library.

* Johnson-Cook as a library (input/laws/johnson_cook.c) makes the same operations as the built-in law: the same digest
  in an impact with rates, temperatures and damage, for any ranks and threads and after a restart.
* input/laws/voce.c and voce.f90 have the same bits. In simple shear their stress follows the closed form to the error
  of steps of explicit hardening, half an increment of the exponent; the plastic work of a bar that flows balances its
  energy to the drift of the built-in law of von Mises, which integrates the same mean of stresses.
* A VUMAT with kinematic hardening (test/support/kinematic_vumat.for), compiled unchanged with the adapter: in simple
  shear by the angle g the backstress of Prager with the Jaumann rate is H/3 sin(g) in shear and H/3 (1 - cos(g)) along
  the shear (J. C. Nagtegaal, J. E. de Jong, 1982), up to elastic strains; a backstress that did not turn would grow
  with g. Without hardening a bar ends as with the built-in law of von Mises without an equation of state.
* An elastic law that returns the whole stress (`stress whole`) rotates and strains as the built-in elastic law: the
  stresses of a bar that turns and vibrates agree to rounding.
"""
# timeout: 240

import math

import numpy as np

import case
import law_libraries

BLOCKS = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=0.08,1,0.04  dx=0.001 /
&time  t_end=1  max_steps=60 /
&effects  rate=.true.  thermal=.true.  damage=.true. /
&material  name='steel'  density=7850  eos_model='mie_gruneisen'  mg_c0=4570  mg_s=1.49  mg_gamma=1.93
  shear=81e9  specific_heat=477  t_melt=1793  {law}
  damage_model='johnson_cook'  jcd=0.05, 0.3, -2.12, 0.002, 0.61 /
&region  name='a'  shape='box'  lo=0.01,0,0.01  hi=0.04,1,0.03 /
&region  name='b'  shape='sphere'  centre=0.047,0,0.02  radius=0.007 /
&body  name='a'  region='a'  material='steel'  ppc=2,1,2  temperature=400 /
&body  name='b'  region='b'  material='steel'  ppc=2,1,2  velocity=-700,0,0 /
&parallel  balance='auto'  balance_every=7  imbalance=1.01 /
"""
BUILT_IN = "strength_model='johnson_cook'  jc_a=792 MPa  jc_b=510 MPa  jc_n=0.26  jc_c=0.014  jc_m=1.03"
LIBRARY = """strength_model='library'  library='johnson_cook.so'
  library_constants='A = 792 MPa', 'B = 0.51 GPa', 'n = 0.26', 'C = 0.014', 'm = 1.03', 't_melt = 1793 K'"""

SHEAR = """
&material  name='steel'  density=7850  bulk=160e9  shear=80e9  strength_model='library'  library='voce.so'
  library_constants='Y0 = 300 MPa', 'Q = 200 MPa', 'b = {rate}' /
&point  path='shear'  strain=0.3  rate=1  steps={steps} /
"""

BAR = """
&run  dimension='plane_strain' /
&grid  lo=-1,0,-1  hi=0.75,1,1  dx=0.0625 /
&time  t_end=1  max_steps={steps} /
&material  name='bar'  density=1000  bulk=2e6  shear=1e6  {law} /
&region  name='bar'  shape='box'  lo=-0.6,0,-0.2  hi=0.6,1,0.2 /
&body  name='bar'  region='bar'  material='bar'  ppc=2,1,2  {motion} /
&output  name='p'  kind='particles'  count=1  precision='double'  fields='identity','stress' /
"""
SPIN = "spin=0,15,0"
IMPACT = "velocity=12,0,3 /\n&boundary  face='all'  type='slip'"
WHOLE = """
#include "scree_law.h"
int32_t scree_law_interface(void) { return SCREE_LAW_INTERFACE; }
const char *scree_law_declaration(void) { return "law hooke\\nstress whole\\nflow none\\n"; }
void scree_law_update(scree_rows *r)
{
   for (int64_t i = 0; i < r->count; i++) {
      double e[6], mean;
      scree_strain(r, i, e);
      mean = (e[0] + e[1] + e[2]) / 3.0;
      for (int n = 0; n < 6; n++)
         r->stress[n][i] += n < 3 ? 3.0 * r->bulk * mean + 2.0 * r->shear * (e[n] - mean) : 2.0 * r->shear * e[n];
   }
}
"""


def test_johnson_cook(options, sheet):
    """The digest of the built-in law, in any layout and after a restart."""
    built = case.Case(options, "built_in", BLOCKS.format(law=BUILT_IN)).run("-q").summary
    digests = {}
    for ranks, threads in ((1, 1), (2, 1), (1, 2)):
        run = case.Case(options, f"library_{ranks}_{threads}", BLOCKS.format(law=LIBRARY), ranks, threads)
        law_libraries.build_c(law_libraries.LAWS / "johnson_cook.c", run.folder / "johnson_cook.so")
        digests[ranks, threads] = run.run("-q").summary["digest"]
    stopped = case.Case(options, "library_restart", BLOCKS.format(law=LIBRARY), 2)
    law_libraries.build_c(law_libraries.LAWS / "johnson_cook.c", stopped.folder / "johnson_cook.so")
    stopped.run("-q", "-s", "time.max_steps=25")
    sheet.require(stopped.summary["digest"] != built["digest"], "the middle is not the end")
    stopped.ranks = 1
    digests["restart"] = stopped.run("-q", "--restart").summary["digest"]
    sheet.require(set(digests.values()) == {built["digest"]}, f"the digest of the built-in law: {digests}")
    soft = case.Case(options, "library_soft", BLOCKS.format(law=LIBRARY.replace("792 MPa", "791 MPa")))
    law_libraries.build_c(law_libraries.LAWS / "johnson_cook.c", soft.folder / "johnson_cook.so")
    sheet.require(soft.run("-q").summary["digest"] != built["digest"], "a constant changes the run")


def voce(options, name, deck, language):
    """A run with the law of Voce in a language."""
    run = case.Case(options, f"{name}_{language}", deck)
    if language == "c":
        law_libraries.build_c(law_libraries.LAWS / "voce.c", run.folder / "voce.so")
    else:
        law_libraries.build_fortran(options, [law_libraries.LAWS / "voce.f90"], run.folder / "voce.so")
    return run


def test_voce(options, sheet):
    """Closed form in shear; both languages have the same bits in a run."""
    rate, steps = 12.0, 400
    run = voce(options, "shear", SHEAR.format(rate=rate, steps=steps), "c").run("--point")
    values = np.genfromtxt(run.path("_point.csv"), delimiter=",", names=True)
    elastic = 300.0e6 / 80.0e9
    plastic = (values["strain"] - elastic) / math.sqrt(3.0)
    flows = plastic > 0.01
    sheet.above("steps in which the point flows", flows.sum(), 300)
    exact = 300.0e6 + 200.0e6 * (1.0 - np.exp(-rate * plastic[flows]))
    # explicit hardening is late by half a step; the elastic strain changes by dY/(3 G) and is neglected with it
    allowed = 0.5 * rate * (0.3 / steps + 200.0e6 / 80.0e9) / math.sqrt(3.0)
    sheet.below("shear: yield stress over its increase", abs(values["mises"][flows] - exact).max() / 200.0e6, allowed)
    sheet.near("shear: the field of the law", values["voce_r"][-1], values["mises"][-1] - 300.0e6, 1.0)
    law = "strength_model='library'  library='voce.so'  library_constants='Y0 = 2 kPa', 'Q = 2 kPa', 'b = 20'"
    digests = [voce(options, "flow", BAR.format(law=law, motion=IMPACT, steps=80), language).run("-q").summary["digest"]
               for language in ("c", "fortran")]
    sheet.require(digests[0] == digests[1], f"C and Fortran have the same bits: {digests}")


def test_plastic_work(options, sheet):
    """The plastic work that the program finds from the stresses: the same heat as that of a law that gives its own."""
    perfect = "strength_model='library'  library='voce.so'  library_constants='Y0 = 2 kPa', 'Q = 0'"
    own = "strength_model='von_mises'  yield=2 kPa"
    ends = {}
    for name, law in (("library", perfect), ("built_in", own)):
        deck = BAR.format(law=law, motion=IMPACT, steps=80).replace(
            "&material", "&effects  thermal=.true. /\n&material").replace("density", "specific_heat=1  density")
        deck = deck.replace("'identity','stress'", "'identity','stress','temperature'")
        run = voce(options, f"work_{name}", deck, "c").run("-q")
        last = run.snapshots()[-1][1]
        order = np.argsort(last.fields["identity"])
        ends[name] = {key: last.fields[key][order] for key in ("stress", "temperature")}
    warmth = ends["built_in"]["temperature"] - 293.0
    sheet.above("heat of the plastic work [K]", warmth.max(), 0.01)
    sheet.below("heat: difference of library and von Mises",
                abs(ends["library"]["temperature"] - 293.0 - warmth).max() / warmth.max(), 1.0e-8)


def test_whole_stress(options, sheet):
    """An elastic law with the whole stress turns as the built-in one."""
    law = "strength_model='library'  library='hooke.so'"
    ends = {}
    for name, words in (("whole", law), ("elastic", "strength_model='elastic'")):
        deck = BAR.format(law=words, motion=SPIN, steps=150)
        # without an equation of state the mean stress has a rate form, as that of the library
        deck = deck.replace("&material", "&effects  eos=.false. /\n&material")
        run = case.Case(options, f"turn_{name}", deck)
        (run.folder / "hooke.c").write_text(WHOLE, encoding="utf-8")
        law_libraries.build_c(run.folder / "hooke.c", run.folder / "hooke.so")
        last = run.run("-q").snapshots()[-1][1]
        ends[name] = last.fields["stress"][np.argsort(last.fields["identity"])]
        sheet.below(f"{name}: energy", run.summary["ledger"]["energy_error"], 0.02)
    largest = abs(ends["elastic"]).max()
    sheet.above("stress of the bar [Pa]", largest, 1.0e4)
    sheet.below("whole stress and built-in elasticity", abs(ends["whole"] - ends["elastic"]).max() / largest, 1.0e-8)


VUMAT_NAMES = """
module vumat_names
   implicit none
   character(len=*), parameter :: nl = new_line("a")
   character(len=*), parameter :: cmname = "prager"
   character(len=*), parameter :: names = "constant E [Pa] > 0 : Young's modulus"//nl// &
      "constant nu [1] : Poisson's ratio"//nl//"constant Y [Pa] > 0 : yield stress"//nl// &
      "constant H [Pa] >= 0 : hardening"//nl//"field sdv1 [1] : plastic strain"//nl// &
      "field sdv2 [Pa] : backstress 11"//nl//"field sdv3 [Pa] : backstress 22"//nl// &
      "field sdv4 [Pa] : backstress 33"//nl//"field sdv5 [Pa] : backstress 12"//nl// &
      "field sdv6 [Pa] : backstress 23"//nl//"field sdv7 [Pa] : backstress 31"
end module vumat_names
"""
VUMAT_SHEAR = """
&material  name='steel'  density=7850  young=200e9  poisson=0.3  strength_model='library'  library='prager.so'
  library_constants='E = 200 GPa', 'nu = 0.3', 'Y = 100 MPa', 'H = 900 MPa' /
&point  path='shear'  strain=4  rate=1  steps=4000 /
"""


def with_vumat(options, name, deck, ranks=1):
    """A case with the VUMAT."""
    run = case.Case(options, name, deck, ranks)
    (run.folder / "names.f90").write_text(VUMAT_NAMES, encoding="utf-8")
    folder = law_libraries.LAWS / "vumat"
    vumat = case.ROOT / "test/support/kinematic_vumat.for"
    law_libraries.build_fortran(options, [run.folder / "names.f90", folder / "vumat_law.f90", vumat],
                                run.folder / "prager.so", f"-I{folder}", f"-J{run.folder}",
                                "-Wno-unused-dummy-argument")
    return run


def test_vumat(options, sheet):
    """A VUMAT, unchanged."""
    run = with_vumat(options, "prager", VUMAT_SHEAR).run("--point")
    values = np.genfromtxt(run.path("_point.csv"), delimiter=",", names=True)
    angle, third = values["strain"], 900.0e6 / 3.0
    flows = angle > 0.05
    # the elastic strain delays flow by Y/(G sqrt(3)), and the direction of flow by as much
    allowed = 4.0 * (100.0e6 / math.sqrt(3.0) + third) / 77.0e9
    shear = 100.0e6 / math.sqrt(3.0) + third * np.sin(angle)
    sheet.below("VUMAT: shear stress over H/3", abs(values["xy"] - shear)[flows].max() / third, allowed)
    along = third * (1.0 - np.cos(angle))
    sheet.below("VUMAT: normal stress over H/3", abs(values["xx"] - along)[flows].max() / third, allowed)
    sheet.near("VUMAT: time of a particle [s]", values["vumat_time"][-1], 4.0, 1e-9)

    motion = BAR.replace("&material", "&effects  eos=.false. /\n&material").replace("bulk=2e6  shear=1e6",
                                                                               "young=2.5e6  poisson=0.3")
    own = "strength_model='von_mises'  yield=2 kPa"
    words = ("strength_model='library'  library='prager.so'  "
             "library_constants='E = 2.5 MPa', 'nu = 0.3', 'Y = 2 kPa', 'H = {}'")
    ends, digests = {}, {}
    for name, law, ranks in (("own", own, 1), ("vumat", words.format("0"), 1), ("hard_1", words.format("1 MPa"), 1),
                             ("hard_2", words.format("1 MPa"), 2)):
        run = with_vumat(options, f"flow_{name}", motion.format(law=law, motion=IMPACT, steps=80), ranks).run("-q")
        last = run.snapshots()[-1][1]
        ends[name] = last.fields["stress"][np.argsort(last.fields["identity"])]
        digests[name] = run.summary["digest"]
    largest = abs(ends["own"]).max()
    sheet.above("flow: largest stress [Pa]", largest, 2.0e3)
    sheet.below("flow: VUMAT and von Mises", abs(ends["vumat"] - ends["own"]).max() / largest, 1.0e-6)
    sheet.above("flow: effect of hardening", abs(ends["hard_1"] - ends["own"]).max() / largest, 1.0e-2)
    sheet.require(digests["hard_1"] == digests["hard_2"], "VUMAT: the same bits on two ranks")
    check = with_vumat(options, "vumat_check", motion.format(law=words.format("1 MPa"), motion=IMPACT, steps=80))
    check.run("--check")
    sheet.require("F128" not in check.output, f"VUMAT: the tests of --check pass: {check.output}")
