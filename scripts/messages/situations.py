# SPDX-License-Identifier: BSD-3-Clause
"""Commands for the page of messages that no wrong deck produces by itself: options, files, and runs that end early.

SITUATIONS: code: a dictionary of
  files      by name, written before; "scene.nml" is the deck
  before     commands that make the situation; they are not shown and must end with 0 or 75
  text       a sentence above what is shown, shows: lines of a file
  commands   run and shown, with the message; a pair is what is shown and what is run
  then       commands that do better: shown, without what they print, and must end with exit code 0
  right      lines of a file that do better, right_files: the whole files, with which what was run
             before and the last of the commands end with exit code 0 and no warning
  see        documents to read on
  traps      the numbers of the run end a Debug build before the message
"""

from examples import GRAINS, THREE

BAR = """&run dimension = '1d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.1 /
&time t_end = 1e-4 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'bar'  shape = 'box'  lo = 0.3 0 0  hi = 0.7 1 1 /
&body name = 'one'  region = 'bar'  material = 'metal'  velocity = 1 0 0 /
"""
STATES_DECK = BAR.replace("young = 70e9  poisson = 0.3", "eos_model = 'table'  eos_table = 'states.txt'").replace(
    "density = 2700", "density = 1500  elastic = 'none'").replace("t_end = 1e-4", "t_end = 1e-3")
STATES = """# density temperature pressure energy
1000  250  7.175e7  1.79375e5
1000  600  1.722e8  4.305e5
2000  250  1.435e8  1.79375e5
2000  600  3.444e8  4.305e5
"""
COLD = STATES.replace("1000  600  1.722e8  4.305e5", "1000  600  1.722e8  1.5e5")
LAW = r'''int scree_law_interface(void) { return 1; }
const char *scree_law_declaration(void) { return "law soft\nconstant Y [Pa] > 0 : yield stress\n"; }
void scree_law_update(void *rows) { (void)rows; }
'''
COMPILED = "cc -fPIC -shared law.c -o law.so"
OWN_LAW = BAR.replace("poisson = 0.3 /", "poisson = 0.3\n  strength_model = 'library'  library = 'law.so'  "
                      "library_constants = 'Y = 90 MPa' /")
WARM_LAW = LAW.replace("nconstant", "nneeds temperature\\nconstant")
STATIC_LAW = '''#include <stdint.h>
struct rows { int64_t count; double numbers[4], *constants, *stress[6]; };
static double calls;
int scree_law_interface(void) { return 1; }
const char *scree_law_declaration(void) { return "law soft\\nconstant Y [Pa] > 0 : yield stress\\n"; }
void scree_law_update(struct rows *r) { calls += 1; for (int i = 0; i < r->count; i++) r->stress[3][i] += calls; }
'''
SERIES = BAR + """&output name = 'p'  kind = 'particles'  every = 2 /
&checkpoint dt = 2e-5  keep = 0 /
"""
BLOCK = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 8 1 4  dx = 1 /
&time t_end = 2  dt_fixed = 0.08 /
&method stress_update = 'usl' /
&material name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 1 0 1  hi = 3 1 3 /
&body name = 'one'  region = 'block'  material = 'rubber'  velocity = 5 0 0 /
&boundary face = 'all'  type = 'symmetry' /
"""
FREE = "&time t_end = 2 /\n"
INSIDE_OUT = BLOCK.replace("dt_fixed = 0.08", "dt_fixed = 0.08  dt_collapse = 0  volume_ratio_min = 0").replace(
    "0.3 /", "0.3  strength_model = 'neo_hookean' /")
CUBE = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 8 8 8  dx = 1 /
&time t_end = 10  dt_fixed = 0.08  dt_collapse = 0 /
&material name = 'rubber'  density = 1000  young = 1e60  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 2 2 2  hi = 5 6 6 /
&body name = 'one'  region = 'block'  material = 'rubber'  velocity = 3 -6 9  spin = 1 2 3 /
&boundary face = 'all'  type = 'slip' /
"""
MEET = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 8 1 4  dx = 1 /
&time t_end = 0.02  cfl = 0.9  dt_min = 2e-3 /
&material name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region name = 'left'   shape = 'box'  lo = 1 0 1  hi = 3 1 3 /
&region name = 'right'  shape = 'box'  lo = 5 0 1  hi = 7 1 3 /
&body name = 'left'   region = 'left'   material = 'rubber'  velocity = 300 0 0 /
&body name = 'right'  region = 'right'  material = 'rubber'  velocity = -300 0 0 /
"""
PRESSED = MEET.replace("cfl = 0.9  dt_min = 2e-3", "volume_ratio_min = 0.6").replace("lo = 5", "lo = 4").replace(
    "hi = 7", "hi = 6")
PULLED = BAR.replace("1e-4", "1e-3  volume_ratio_max = 1.02").replace("lo = 0.3 0 0", "lo = 0 0 0").replace(
    "1 0 0 /\n", "100 0 0 /\n&boundary face = 'xlo'  type = 'stick' /\n")
DROP = """&run dimension = '3d' /
&effects gravity = .true.  gravity_vector = 0 0 -9.81 /
&grid lo = 0 0 0  hi = 1 1 4  dx = 0.25 /
&time t_end = 0.5  dt_max = 0.01  speed_max = 3 /
&material name = 'rubber'  density = 1000  young = 1e4  poisson = 0.3 /
&region name = 'cube'  shape = 'box'  lo = 0.25 0.25 3  hi = 0.75 0.75 3.5 /
&body name = 'one'  region = 'cube'  material = 'rubber' /
"""
FAST = BLOCK.replace("t_end = 2  dt_fixed = 0.08", "t_end = 2  dt_fixed = 0.04  dt_collapse = 0")
GAS = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 1 0.5  dx = 0.05 /
&method normalise = 'none' /
&time t_end = 0.02 /
&effects strength = .false.  eos = .true.  artificial_viscosity = .false. /
&material name = 'gas'  density = 100  eos_model = 'ideal_gas'  ig_gamma = 1.4 /
&region name = 'box'  shape = 'box'  lo = 0 0 0  hi = 1 1 0.5 /
&body name = 'gas'  region = 'box'  material = 'gas'  specific_energy = 2e5  packing = 'jitter' /
&boundary face = 'all'  type = 'slip' /
"""
JET = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 8 1 4  dx = 1 /
&time t_end = 0.1  dt_fixed = 0.015  dt_collapse = 0 /
&effects strength = .false.  eos = .true. /
&material name = 'gas'  density = 100  eos_model = 'ideal_gas'  ig_gamma = 1.4 /
&region name = 'box'  shape = 'box'  lo = 1 0 1  hi = 3 1 3 /
&body name = 'gas'  region = 'box'  material = 'gas'  velocity = 100 0 0  specific_energy = 1e3 /
&boundary face = 'all'  type = 'slip' /
"""
GUM = """&run dimension = '1d' /
&grid lo = 0 0 0  hi = 40 1 1  dx = 1 /
&time t_end = 70 /
&method stress_update = 'usl' /
&material name = 'gum'  density = 1000  young = 1e5  poisson = 0 /
&region name = 'bar'  shape = 'box'  lo = 0 0 0  hi = 10 1 1 /
&region name = 'grip'  shape = 'box'  lo = 9 0 0  hi = 11 1 1 /
&body name = 'bar'  region = 'bar'  material = 'gum' /
&boundary face = 'xlo'  type = 'stick' /
&boundary region = 'grip'  type = 'stick'  velocity = 0.1 0 0 /
"""
SOFT = """&run dimension = 'plane_strain' /
&grid lo = -0.1 0 -0.05  hi = 0.1 1 0.05  dx = 0.005 /
&time t_end = 4e-3 /
&effects eos = .false.  artificial_viscosity = .false. /
&method stress_update = 'usl' /
&material name = 'rubber'  density = 1010  young = 1e8  poisson = 0.3  strength_model = 'neo_hookean' /
&region name = 'left'  shape = 'box'  lo = -0.06 0 -0.03  hi = -0.01 1 0.03 /
&region name = 'right'  shape = 'box'  lo = 0.01 0 -0.03  hi = 0.06 1 0.03 /
&body name = 'left'  region = 'left'  material = 'rubber'  velocity = 10 0 0 /
&body name = 'right'  region = 'right'  material = 'rubber'  velocity = -10 0 0 /
"""
LOCKED = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 16 1 12  dx = 1 /
&time t_end = 6 /
&effects artificial_viscosity = .false. /
&material name = 'clay'  density = 1000  young = 1e6  poisson = 0.49  strength_model = 'von_mises'  yield = 1e3 /
&region name = 'soil'  shape = 'box'  lo = 0 0 0  hi = 16 1 8 /
&region name = 'foot'  shape = 'box'  lo = 6 0 8  hi = 10 1 11 /
&body name = 'soil'  region = 'soil'  material = 'clay' /
&boundary face = 'all'  type = 'slip' /
&boundary region = 'foot'  type = 'stick'  velocity = 0 0 -0.1 /
"""
TURNING = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 10 1 10  dx = 1 /
&time t_end = 2 /
&method transfer = 'pic' /
&material name = 'rubber'  density = 1000  young = 1e6  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 3 0 3  hi = 7 1 7 /
&body name = 'one'  region = 'block'  material = 'rubber'  spin = 0 1 0 /
"""
PUSHED = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 1e-4 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&region name = 'ram'   shape = 'box'  lo = 0 0 0.8  hi = 1 1 1 /
&body name = 'one'  region = 'ball'  material = 'metal' /
&boundary region = 'ram'  type = 'slip'  table = 'ram.csv' /
"""
RAM = "# t, vx, vy, vz\n0,    0, 0, 0\n1e-6, 0, 0, -1\n1e-4, 0, 0, -1\n"
STONE = GRAINS.replace("'grains'", "'stone'").replace("shape = 'points'  file = 'grains.csv'",
                                                      "shape = 'stl'  file = 'stone.stl'").replace(
    "  packing = 'file'", "")
FACETS = "\n".join(["solid stone", *(line for three in ("021", "013", "032", "123") for line in [
    "facet normal 0 0 0", "outer loop",
    *("vertex " + ("0.2 0.2 0.2", "0.8 0.2 0.2", "0.2 0.8 0.2", "0.2 0.2 0.8")[int(k)] for k in three),
    "endloop", "endfacet"]), "endsolid stone", ""])
SCAN = STONE.replace("shape = 'stl'  file = 'stone.stl'",
                     "shape = 'voxel'  file = 'first.hdf'  dataset = '/VTKHDF/Points'  voxel_value = 7")
TERRAIN_PAGE = "../guide/shapes.md#terrain-shape--terrain"
SLOPE = """&run dimension = '3d' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.125 /
&time t_end = 0.1 /
&material name = 'sand'  density = 1500  bulk = 1e7  shear = 5e6 /
&region name = 'slope'  shape = 'terrain'  file = 'slope.asc' /
&region name = 'block'  shape = 'box'  lo = 0 0 0.5  hi = 1 1 1 /
&body name = 'one'  region = 'block'  material = 'sand' /
&boundary region = 'slope'  type = 'slip' /
"""
HEIGHTS = """ncols 3
nrows 2
xllcorner 0
yllcorner 0
cellsize 0.5
nodata_value -9999
0.5 0.4 0.3
0.5 0.4 0.3
"""
FURTHER = GRAINS.replace("grains.csv", "first.hdf").replace(
    "packing = 'file'", "packing = 'file'  initial_stress = 'file'")
FIRST = GRAINS.replace("shape = 'points'  file = 'grains.csv'",
                       "shape = 'sphere'  centre = 0.5 0.5 0.5  radius = 0.3").replace("  packing = 'file'", "")
STATE = FIRST + "&output name = 'p'  kind = 'particles'  every = 1  precision = 'double'  fields = 'state' /\n"
BOXES = STATE.replace("'3d' /", "'3d'  method = 'mpm' /\n&method basis = 'gimp' /")
TURNED = FURTHER.replace("'3d' /", "'3d'  method = 'mpm' /\n&method basis = 'gimp' /").replace(
    "'first.hdf' /", "'first.hdf'  rotate = 0 0 30  translate = 0.3 -0.2 0 /")
QUARTER = ("30  translate = 0.3 -0.2 0", "90  translate = 1 0 0")
LAST = ["scree -q first.nml --outdir first", "cp first/first_p_000001.hdf first.hdf"]
SNAPSHOT = ["scree -q first.nml --outdir first", "cp first/first_p_000000.hdf first.hdf"]
CHECK = "scree --check scene.nml"
RUN = "scree -q scene.nml"
FORCED = "scree -q --force scene.nml"                 # a fixed step above the stability limit
AGAIN = "scree -q --restart scene.nml"
OTHER_DECK = "../guide/running.md#a-restart-with-another-deck"

GRAIN_CELL = """&grains shape = 'discs'  number = 100  diameter = 1e-3  density = 2500  stiffness = 1e6 /
&cell pressure = 1e3 /
&stage servo = 'isotropic'  duration = 1e-4 /
"""
SOFT_GRAINS = GRAIN_CELL.replace("1e6", "1e2").replace("1e3 /", "1e3  speed = 0.1 /").replace("1e-4", "1")

SOLID_LATTICE = GRAIN_CELL.replace("'discs'  number = 100", "'spheres'").replace(
    "&cell", "&cell packing = 'fcc'  cells = 4 4 4 ")
FIXED = """&run dimension = 'plane_strain' /
&grid lo = 0 0 0  hi = 1 1 1  dx = 0.1 /
&time t_end = 1e-3  dt_fixed = 3e-5 /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'block'  shape = 'box'  lo = 0.2 0 0.2  hi = 0.8 1 0.8 /
&body name = 'one'  region = 'block'  material = 'metal' /
"""

SITUATIONS = {
    # fixed time steps
    "D230": {
        "files": {"scene.nml": FIXED}, "shows": "&time t_end = 1e-3  dt_fixed = 3e-5 /", "commands": [CHECK],
        "right": "&time t_end = 1e-3  dt_fixed = 7e-6 /",
        "right_files": {"scene.nml": FIXED.replace("3e-5", "7e-6")}},
    "D231": {
        "files": {"scene.nml": FIXED.replace("3e-5", "1.4e-5")}, "shows": "&time t_end = 1e-3  dt_fixed = 1.4e-5 /",
        "commands": [CHECK], "right": "&time t_end = 1e-3  dt_fixed = 7e-6 /",
        "right_files": {"scene.nml": FIXED.replace("3e-5", "7e-6")}},
    # cells of grains
    "D448": {
        "files": {"cell.nml": SOLID_LATTICE.replace("4 4 4", "2000 2000 2000")},
        "shows": "&cell packing = 'fcc'  cells = 2000 2000 2000  pressure = 1e3 /",
        "commands": ["scree --grains --check cell.nml"],
        "right": "&cell packing = 'fcc'  cells = 4 4 4  pressure = 1e3 /", "right_files": {"cell.nml": SOLID_LATTICE}},
    "D449": {
        "files": {"cell.nml": GRAIN_CELL.replace("1e-4", "1e300")},
        "shows": "&stage servo = 'isotropic'  duration = 1e300 /", "commands": ["scree --grains --check cell.nml"],
        "right": "&stage servo = 'isotropic'  duration = 1e-4 /", "right_files": {"cell.nml": GRAIN_CELL}},
    "D347": {
        "files": {"cell.nml": GRAIN_CELL.replace("'isotropic'", "'xyz'")},
        "text": "Discs with servos along three axes:",
        "shows": "&stage servo = 'xyz'  duration = 1e-4 /", "commands": ["scree --grains --check cell.nml"],
        "right": "&stage servo = 'isotropic'  duration = 1e-4 /", "right_files": {"cell.nml": GRAIN_CELL}},
    "R125": {
        "files": {"cell.nml": SOFT_GRAINS}, "text": "Grains collide at 0.1 m/s with springs of 100 N/m:",
        "shows": SOFT_GRAINS.splitlines()[0], "commands": ["scree --grains -q --overwrite cell.nml"],
        "right": GRAIN_CELL.splitlines()[0], "right_files": {"cell.nml": GRAIN_CELL}},
    "R126": {
        "files": {"cell.nml": GRAIN_CELL}, "before": ["scree --grains -q cell.nml"],
        "commands": ["scree --grains -q --restart cell.nml"]},
    # the command line
    "D109": {
        "files": {"scene.nml": "! density 2700, young 70e9\n"}, "text": "A deck that contains only a comment:",
        "shows": "! density 2700, young 70e9", "commands": [CHECK],
        "then": ["scree --template > scene.nml"], "see": ["../learn/first_deck.md"]},
    "C101": {"files": {"scene.nml": BAR}, "commands": ["scree --chek scene.nml"],
                       "then": [CHECK], "see": ["../guide/running.md"]},
    "C102": {
        "files": {"scene.nml": BAR}, "commands": ["scree --check scene.nml --set dx=0.05"],
        "then": ["scree --check scene.nml --set grid.dx=0.05"],
        "see": ["../guide/deck.md#values-from-the-command-line"]},
    "C103": {
        "files": {"scene.nml": BAR}, "commands": ["scree --check scene.nml --set 'material[steel].young=200e9'"],
        "then": ["scree --check scene.nml --set 'material[metal].young=200e9'"],
        "see": ["../guide/deck.md#values-from-the-command-line"]},
    "C104": {
        "files": {"scene.nml": BAR}, "commands": ["scree --check scene.nml --set 'time.t_end=1e-4 /'"],
        "then": ["scree --check scene.nml --set time.t_end=1e-4"],
        "see": ["../guide/deck.md#values-from-the-command-line"]},
    "C105": {"files": {"scene.nml": BAR}, "commands": ["scree --check --case= scene.nml"],
                              "then": ["scree --check --case=first scene.nml"], "see": ["../guide/running.md"]},
    "C106": {"files": {"scene.nml": BAR}, "commands": ["scree --check --force=yes scene.nml"],
                       "then": ["scree --check --force scene.nml"], "see": ["../guide/running.md"]},
    "R133": {
        "files": {"scene.nml": TURNING}, "text": "The complete deck of a rubber block that turns:", "shows": TURNING,
        "commands": [RUN], "right": "&method transfer = 'rflip' /",
        "right_files": {"scene.nml": TURNING.replace("'pic'", "'rflip'")}, "see": ["output.md#trust"]},
    "R132": {
        "text": "The disk is full:",
        "commands": [("TMPDIR=/full scree --self-test -q",
                      "PMIX_MCA_gds=hash OMPI_MCA_btl=self sh -c 'ulimit -f 8; scree --self-test -q'")],
        "then": ["scree --self-test -q"], "see": ["../guide/install.md#self-test"]},
    "C107": {"files": {"scene.nml": BAR}, "commands": ["scree --check --restart scene.nml"],
                           "then": [CHECK], "see": ["../guide/running.md"]},
    "C108": {"files": {"scene.nml": BAR}, "commands": ["scree --no-estimate scene.nml"],
                          "then": ["scree --check --no-estimate scene.nml"],
                          "see": ["../guide/running.md#check-a-deck-and-estimate-its-cost"]},
    "C109": {"commands": ["scree --list material"], "then": ["scree --list materials"],
                   "see": ["materials.md"]},
    "C110": {
        "files": {"scene.nml": BAR}, "commands": ["scree --check scene.nml --set run.title=my first run"],
        "then": ["scree --check scene.nml --set \"run.title='my first run'\""], "see": ["../guide/running.md"]},
    # examples and jobs
    "C201": {"commands": ["scree --new two_disks my_discs"],
                            "then": ["scree --new two_discs my_discs"],
                            "see": ["../guide/running.md#a-case-of-your-own"]},
    "C202": {
        "before": ["mkdir my_discs", "touch my_discs/notes.txt"], "commands": ["scree --new two_discs my_discs"],
        "then": ["scree --new two_discs other_discs"], "see": ["../guide/running.md#a-case-of-your-own"]},
    "C203": {
        "before": ['cp "$(command -v scree)" scree'],
        "text": "The program was copied to another folder without its other files:",
        "commands": ["./scree --list examples"], "see": ["../guide/running.md#a-case-of-your-own"]},
    "C204": {"files": {"scene.nml": BAR}, "commands": ["scree --job sge scene.nml"],
                                "then": ["scree --job slurm scene.nml > job.sh"],
                                "see": ["../guide/running.md#a-batch-script"]},
    "C205": {
        "files": {"scene.nml": BAR + "&checkpoint on_signal = 'TERM' /\n"}, "text": "With this line in the deck:",
        "shows": "&checkpoint on_signal = 'TERM' /", "commands": ["scree --job slurm scene.nml"],
        "right": "&checkpoint on_signal = 'TERM' 'USR1' /",
        "right_files": {"scene.nml": BAR + "&checkpoint on_signal = 'TERM' 'USR1' /\n"},
        "see": ["../guide/running.md#a-batch-script"]},
    "C206": {"files": {"scene.nml": BAR}, "commands": ["scree --ranks 4 scene.nml"],
                  "then": ["scree --job slurm --ranks 4 scene.nml > job.sh"],
                  "see": ["../guide/running.md#ranks-and-threads"]},
    "C207": {"files": {"scene.nml": BAR}, "commands": ["scree --job slurm --nodes 2 --ranks 5 scene.nml"],
             "then": ["scree --job slurm --nodes 2 --ranks 6 scene.nml > job.sh"],
             "see": ["../guide/clusters.md#job-scripts"]},
    # runs that end early
    "R137": {
        "files": {"scene.nml": BAR}, "before": ["scree -q scene.nml --set \"time.wall_limit='00:00:00'\""],
        "text": "In a batch job without time to compute:",
        "commands": [("scree -q --restart scene.nml --set \"time.wall_limit='00:00:00'\"",
                      "SLURM_JOB_ID=12 scree -q --restart scene.nml --set \"time.wall_limit='00:00:00'\"")],
        "then": [AGAIN], "see": ["../guide/clusters.md#job-scripts"]},
    "R101": {
        "files": {"scene.nml": BAR.replace("1e-4", "1e-4  dt_min = 1e-5")}, "text": "The complete deck:",
        "shows": BAR.replace("1e-4", "1e-4  dt_min = 1e-5"), "commands": [RUN],
        "then": ["scree -q --overwrite scene.nml --set time.dt_min=1e-9"]},
    "R102": {
        "files": {"scene.nml": BLOCK},
        "text": "The complete deck; the time step is ten times the stable one:", "shows": BLOCK,
        "commands": [FORCED], "right": FREE,
        "right_files": {"scene.nml": BLOCK.replace("  dt_fixed = 0.08", "")}},
    "R103": {
        "files": {"scene.nml": MEET}, "text": "The complete deck:", "shows": MEET, "commands": [RUN],
        "right": "&time t_end = 0.02 /",
        "right_files": {"scene.nml": MEET.replace("  cfl = 0.9  dt_min = 2e-3", "")}},
    "R104": {
        "files": {"scene.nml": CUBE}, "text": "The complete deck; the modulus is mistyped, and `dt_fixed` and "
        "`dt_collapse = 0` prevent an earlier end because of the time step:", "shows": CUBE, "commands": [FORCED],
        "right": "&time t_end = 10 /", "traps": True,
        "right_files": {"scene.nml": CUBE.replace("10  dt_fixed = 0.08  dt_collapse = 0", "0.5").replace(
            "1e60", "1e6")}},
    "R105": {
        "files": {"scene.nml": INSIDE_OUT}, "text": "The complete deck; the time step is far too long, and "
        "two limits that would end the run earlier are switched off:", "shows": INSIDE_OUT, "commands": [FORCED],
        "right": FREE,
        "right_files": {"scene.nml": INSIDE_OUT.replace(
            "  dt_fixed = 0.08  dt_collapse = 0  volume_ratio_min = 0", "")}},
    "R106": {
        "files": {"scene.nml": PRESSED}, "text": "The complete deck of soft blocks that collide at eight times "
        "their speed of sound; the limit of compression is 60 % of the volume:", "shows": PRESSED, "commands": [RUN],
        "then": ["scree -q --overwrite scene.nml --set time.volume_ratio_min=0.01"]},
    "R107": {
        "files": {"scene.nml": PULLED}, "text": "The complete deck of a bar that is pulled from a wall; the limit "
        "of expansion is 2 %:", "shows": PULLED, "commands": [RUN],
        "then": ["scree -q --overwrite scene.nml --set time.volume_ratio_max=1e12"]},
    "R108": {
        "files": {"scene.nml": DROP}, "text": "The complete deck of a falling cube:", "shows": DROP,
        "commands": [RUN], "then": ["scree -q --overwrite scene.nml --set time.speed_max=100"]},
    "R109": {
        "files": {"scene.nml": PRESSED.replace("min = 0.6", "min = 0.6  on_bad = 'retire'")},
        "text": "The deck of R106 with `on_bad = 'retire'`:",
        "shows": "&time t_end = 0.02  volume_ratio_min = 0.6  on_bad = 'retire' /", "commands": [RUN],
        "then": ["scree -q --overwrite scene.nml --set time.retire_max=0.5"]},
    "R110": {
        "files": {"scene.nml": DROP}, "text": "The deck of R108:",
        "shows": DROP.split("\n")[3], "commands": [RUN],
        "then": ["scree -q --overwrite scene.nml -s time.max_steps={max_steps}"]},
    "R111": {
        "files": {"scene.nml": FAST},
        "text": "The complete deck; the time step is slightly longer than the stable one:",
        "shows": FAST, "commands": [FORCED], "right": FREE,
        "right_files": {"scene.nml": FAST.replace("  dt_fixed = 0.04  dt_collapse = 0", "")}},
    "R112": {
        "files": {"scene.nml": FAST}, "text": "The deck of R111:", "shows": FAST.split("\n")[2], "commands": [FORCED],
        "right": FREE,
        "right_files": {"scene.nml": FAST.replace("  dt_fixed = 0.04  dt_collapse = 0", "")},
        "see": ["output.md#trust"]},
    "R113": {
        "files": {"scene.nml": JET}, "text": "The complete deck of a gas with too long a time step:", "shows": JET,
        "commands": [FORCED], "right": JET.split("\n")[2].replace("  dt_fixed = 0.015  dt_collapse = 0", ""),
        "right_files": {"scene.nml": JET.replace("  dt_fixed = 0.015  dt_collapse = 0", "")},
        "see": ["output.md#trust"]},
    "R114": {
        "files": {"scene.nml": GUM}, "text": "The complete deck of a bar that is stretched:", "shows": GUM,
        "commands": [RUN], "then": ["scree -q --overwrite scene.nml --set method.split=T"], "see": ["output.md#trust"]},
    "R115": {
        "files": {"scene.nml": GAS},
        "text": "The complete deck of a gas at rest in a box, with irregular particles and without normalised sums:",
        "shows": GAS, "commands": [RUN], "right": "&method normalise = 'gases' /",
        "right_files": {"scene.nml": GAS.replace("'none'", "'gases'")}, "see": ["output.md#trust"]},
    "R116": {
        "files": {"scene.nml": LOCKED}, "text": "The complete deck of a footing on clay:",
        "shows": LOCKED, "commands": [RUN], "right": "&method antilock = 'bbar' /",
        "right_files": {"scene.nml": LOCKED + "&method antilock = 'bbar' /\n"}, "see": ["output.md#trust"]},
    "R117": {
        "files": {"scene.nml": SOFT}, "text": "The complete deck of two rubber blocks that collide:", "shows": SOFT,
        "commands": [RUN], "right": "&method stress_update = 'usavg' /",
        "right_files": {"scene.nml": SOFT.replace("'usl'", "'usavg'")},
        "see": ["output.md#trust"]},
    "R120": {
        "files": {"scene.nml": BAR}, "commands": ["scree scene.nml --set \"time.wall_limit='00:00:00'\""],
        "then": [AGAIN], "see": ["../guide/running.md#checkpoints-and-restart"]},
    "R121": {
        "files": {"scene.nml": BAR}, "commands": [(
            "scree scene.nml --set time.t_end=10 & sleep 60; kill -USR1 $!; wait $!",
            "scree scene.nml --set time.t_end=10 > screen & child=$!; for try in $(seq 600); do "
            "grep -q t/t_end screen && break; sleep 0.1; done; kill -USR1 $child; wait $child; code=$?; "
            "tail -n 2 screen; exit $code")],
        "then": [("scree -q --restart scene.nml --set time.t_end=10",
                  "scree -q --restart scene.nml --set time.t_end=10 --set \"time.wall_limit='00:00:00'\"")],
        "see": ["../guide/running.md#signals"]},
    "R122": {
        "files": {"scene.nml": BAR}, "text": "In a job that `squeue` does not list:",
        "commands": ["SLURM_JOB_ID=12 scree -q scene.nml --set \"time.wall_limit='slurm'\""],
        "then": ["scree -q --overwrite scene.nml --set \"time.wall_limit='03:30:00'\""],
        "see": ["../guide/running.md#signals"]},
    "R123": {
        "files": {"scene.nml": BAR}, "text": "Outside a Slurm job:",
        "commands": ["scree -q scene.nml --set \"time.wall_limit='slurm'\""],
        "then": ["scree -q --overwrite scene.nml --set \"time.wall_limit='03:30:00'\""],
        "see": ["../guide/running.md#signals"]},
    "R131": {
        "files": {"scene.nml": BAR}, "text": "On one processor:",
        "commands": ["OMP_NUM_THREADS=2 taskset -c 0 scree -q scene.nml"],
        "then": ["OMP_NUM_THREADS=1 taskset -c 0 scree -q --overwrite scene.nml"],
        "see": ["../guide/clusters.md#ranks-and-threads-on-processors"]},
    "R119": {
        "files": {"scene.nml": BAR.replace("velocity = 1 ", "velocity = 5000 ")},
        "text": "Boundaries without a `&boundary` group are open, and the bar leaves through one of them:",
        "commands": ["scree -q scene.nml --set time.t_end=1e-3"],
        "then": ["scree -q --overwrite scene.nml"], "see": ["../guide/running.md#how-a-run-ends"]},
    # files
    "F101": {
        "before": ["scree --new two_discs my_discs"], "commands": ["scree --check my_discs"],
        "then": ["scree --check my_discs/two_discs.nml"], "see": ["../guide/running.md#a-case-of-your-own"]},
    "F102": {
        "files": {"scene.nml": BAR, "results": "a file\n"}, "text": "A file `results` exists already:",
        "commands": ["scree -q scene.nml --outdir results"], "then": ["scree -q scene.nml --outdir results_2"],
        "see": ["output.md"]},
    "F103": {
        "files": {"scene.nml": BAR}, "text": "With a limit on the size of files that is too small:",
        "commands": [(f"ulimit -f 8; {RUN}", f"PMIX_MCA_gds=hash OMPI_MCA_btl=self sh -c 'ulimit -f 8; {RUN}'")],
        "then": [AGAIN], "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F104": {
        "files": {"scene.nml": BAR}, "before": ["scree -q scene.nml --set checkpoint.at_end=F"],
        "text": "The run wrote no checkpoint:", "commands": [AGAIN], "then": ["scree -q --overwrite scene.nml"],
        "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F105": {
        "files": {"scene.nml": BAR}, "before": [RUN, "cp out/scene/scene_chk_0001.h5 whole.h5",
                                                "head -c 9999 whole.h5 > out/scene/scene_chk_0001.h5"],
        "text": "The only checkpoint was copied incompletely:", "commands": [AGAIN],
        "then": ["cp whole.h5 out/scene/scene_chk_0001.h5", AGAIN],
        "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F106": {"files": {"secne.nml": BAR}, "commands": [CHECK], "then": ["scree --check secne.nml"],
                    "see": ["../guide/running.md"]},
    "F107": {
        "files": {"scene.nml": SERIES},
        "before": [RUN, "head -c 9999 out/scene/scene_chk_0002.h5 > out/scene/scene_chk_0009.h5"],
        "text": "A checkpoint was copied incompletely:",
        "commands": ["scree -q --restart out/scene/scene_chk_0009.h5 scene.nml"],
        "then": [AGAIN], "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F108": {
        "files": {"scene.nml": SERIES},
        "before": [RUN, "cp out/scene/scene_chk_0002.h5 bad.h5",
                   "printf X | dd of=bad.h5 bs=1 seek=3000 conv=notrunc 2> /dev/null"],
        "text": "One byte of a checkpoint was changed:", "commands": ["scree --digest bad.h5"],
        "then": [AGAIN], "see": ["output.md#checkpoints-and-the-digest"]},
    "F109": {
        "files": {"scene.nml": BAR},
        "before": [RUN, "sed 's/scree-checkpoint-[0-9]/scree-checkpoint-0/' out/scene/scene_chk_0001.h5 > old.h5",
                   "mv old.h5 out/scene/scene_chk_0002.h5"],
        "text": "A checkpoint of an older version of the program:",
        "commands": ["scree -q --restart out/scene/scene_chk_0002.h5 scene.nml"],
        "see": ["output.md#checkpoints-and-the-digest"]},
    "F110": {
        "files": {"scene.nml": BAR}, "before": [RUN],
        "text": "A finished run is restarted with smaller cells and another density, then with another modulus:",
        "commands": ["scree -q --restart scene.nml --set grid.dx=0.05 --set material.density=2650",
                     "scree -q --restart scene.nml --set material.poisson=0.25"],
        "then": ["scree -q --restart scene.nml --set time.t_end=2e-4"], "see": [OTHER_DECK]},
    "F111": {
        "files": {"scene.nml": BAR}, "before": [RUN], "text": "The same command is run a second time:",
        "commands": [RUN], "then": ["scree -q --restart scene.nml --set time.t_end=2e-4",
                                    "scree -q --overwrite scene.nml"],
                                    "see": ["../guide/running.md#existing-results"]},
    "F125": {
        "files": {"scene.nml": BAR}, "text": "The run is started again while it computes:",
        "commands": [("scree -q scene.nml --set time.t_end=10 & sleep 60; scree -q --overwrite scene.nml",
                      "scree -q scene.nml --set time.t_end=10 & child=$!; for try in $(seq 600); do "
                      "test -e out/scene/scene_p_000000.hdf && break; sleep 0.1; done; "
                      "scree -q --overwrite scene.nml > said 2>&1; code=$?; kill -USR1 $child; wait $child; "
                      "sed -e \"s/process $child on host '[^']*'/process 4711 on host 'node7'/\" "
                      "-e 's/started .* ago/started 00:01:00 ago, last sign of life 00:00:05 ago/' said; exit $code")],
        "then": [("scree -q --restart scene.nml",
                  "scree -q --restart scene.nml --set time.t_end=10 --set \"time.wall_limit='00:00:00'\"")],
        "see": ["../guide/running.md#two-runs-in-one-folder"]},
    "F112": {
        "files": {"scene.nml": BAR.replace("'1d' /", "'1d'  method = 'mpm' /")}, "before": [RUN],
        "text": "The first run had the default `transfer`, with which particles do not store a velocity gradient:",
        "commands": ["scree -q --restart scene.nml --set time.t_end=2e-4 --set method.transfer=apic"],
        "then": ["scree -q --restart scene.nml --set time.t_end=2e-4"], "see": [OTHER_DECK]},
    "F113": {
        "files": {"scene.nml": STONE, "stone.stl": "\n".join(FACETS.split("\n")[:11]) + "\n"},
        "text": "A file `stone.stl` that ends too early; these are its last lines:",
        "shows": "\n".join(FACETS.split("\n")[8:11]), "commands": [CHECK],
        "right": "\n".join(FACETS.split("\n")[-9:]), "right_files": {"scene.nml": STONE, "stone.stl": FACETS}},
    "F129": {
        "files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS[:-5] + "\n"},
        "text": "The raster `slope.asc` lacks a value; these are its last lines:",
        "shows": HEIGHTS[-24:-5] + "\n", "commands": [CHECK], "right": HEIGHTS[-24:],
        "right_files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS}},
    "D378": {
        "files": {"scene.nml": SLOPE.replace("'3d'", "'plane_strain'"), "slope.asc": HEIGHTS},
        "text": "The raster `slope.asc` has two rows:", "shows": "&run dimension = 'plane_strain' /\n",
        "commands": [CHECK], "right": SLOPE.split("\n")[4].replace(" /", "  section = 0.5 /") + "\n",
        "right_files": {"scene.nml": SLOPE.replace("'3d'", "'plane_strain'").replace("asc' /", "asc'  section = 0.5 /"),
                        "slope.asc": HEIGHTS}, "see": [TERRAIN_PAGE]},
    "D452": {
        "files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS.replace("xllcorner 0", "xllcorner 700000")},
        "text": "The raster `slope.asc` has map coordinates:", "shows": "xllcorner 700000\n",
        "commands": [CHECK], "right": SLOPE.split("\n")[4].replace(" /", "  translate = -700000 0 0 /") + "\n",
        "right_files": {"scene.nml": SLOPE.replace("asc' /", "asc'  translate = -700000 0 0 /"),
                        "slope.asc": HEIGHTS.replace("xllcorner 0", "xllcorner 700000")}, "see": [TERRAIN_PAGE]},
    "D453": {
        "files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS.replace(" 0.", " 1500.").replace("\n0.", "\n1500.")},
        "text": "The heights of `slope.asc` are those above the sea:",
        "shows": "1500.5 1500.4 1500.3\n", "commands": [CHECK],
        "right": SLOPE.split("\n")[4].replace(" /", "  translate = 0 0 -1500 /") + "\n",
        "right_files": {"scene.nml": SLOPE.replace("asc' /", "asc'  translate = 0 0 -1500 /"),
                        "slope.asc": HEIGHTS.replace(" 0.", " 1500.").replace("\n0.", "\n1500.")},
        "see": [TERRAIN_PAGE]},
    "D454": {
        "files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS.replace("0.4 0.3\n0.5", "-9999 0.3\n0.5")},
        "text": "A row of `slope.asc`:", "shows": "0.5 -9999 0.3\n", "commands": [CHECK],
        "right": "0.5 0.4 0.3\n", "right_files": {"scene.nml": SLOPE, "slope.asc": HEIGHTS}, "see": [TERRAIN_PAGE]},
    "F114": {
        "files": {"scene.nml": SCAN, "first.nml": FIRST}, "before": SNAPSHOT,
        "text": "The file has positions of particles, not voxels:", "shows": SCAN.split("\n")[4], "commands": [CHECK]},
    "F115": {
        "files": {"scene.nml": GRAINS, "grains.csv": THREE.replace("0.5,0.5,0.5", "0.5;0.5;0.5")},
        "text": "The table `grains.csv`:", "shows": THREE.replace("0.5,0.5,0.5", "0.5;0.5;0.5"),
        "commands": [CHECK], "right": THREE, "right_files": {"scene.nml": GRAINS, "grains.csv": THREE}},
    "F116": {
        "files": {"scene.nml": GRAINS, "grains.csv": THREE.replace("0.5,0.5,0.5", "500,0.5,0.5")},
        "text": "The table `grains.csv`; the grid of the deck ends at 1:",
        "shows": THREE.replace("0.5,0.5,0.5", "500,0.5,0.5"), "commands": [CHECK], "right": THREE,
        "right_files": {"scene.nml": GRAINS, "grains.csv": THREE}},
    "F117": {
        "files": {"scene.nml": GRAINS, "grains.csv": THREE + "0.2,0.2,0.2,1e-3\n"},
        "text": "The table `grains.csv`:", "shows": THREE + "0.2,0.2,0.2,1e-3\n",
        "commands": [CHECK], "right": THREE, "right_files": {"scene.nml": GRAINS, "grains.csv": THREE}},
    "D412": {
        "files": {"scene.nml": GRAINS, "grains.csv": THREE.replace("1e-3", "8e-3")},
        "text": "The table `grains.csv`; a cell of the deck has 0.125 m x 0.125 m x 0.125 m = 0.00195 m3:",
        "shows": THREE.replace("1e-3", "8e-3"), "commands": [CHECK],
        "right": THREE, "right_files": {"scene.nml": GRAINS, "grains.csv": THREE}},
    "D413": {
        "files": {"scene.nml": FURTHER, "first.nml": FIRST + "&output name = 'p'  kind = 'particles'  count = 1"
                  "  fields = 'default' 'stress' /\n"},
        "before": SNAPSHOT, "text": "The first run wrote:",
        "shows": "&output name = 'p'  kind = 'particles'  count = 1  fields = 'default' 'stress' /",
        "commands": [CHECK],
        "right": "&output name = 'p'  kind = 'particles'  count = 1  fields = 'state' /",
        "right_files": {
            "first.nml": FIRST + "&output name = 'p'  kind = 'particles'  count = 1  fields = 'state' /\n"}},
    "D417": {
        "files": {"scene.nml": TURNED, "first.nml": BOXES}, "before": SNAPSHOT,
        "text": "The particle boxes of `basis = 'gimp'` are aligned with the axes, and the points are rotated:",
        "shows": TURNED.split("\n")[5], "commands": [CHECK],
        "right": TURNED.split("\n")[5].replace(*QUARTER),
        "right_files": {"scene.nml": TURNED.replace(*QUARTER)}},
    "D418": {
        "files": {"scene.nml": FURTHER.replace("  initial_stress = 'file'", "") + "&method paper = .true. /\n",
                  "first.nml": STATE}, "before": LAST,
        "text": "The run that wrote the snapshot had no such line:", "shows": "&method paper = .true. /",
        "commands": [CHECK], "right": "&method paper = .false. /",
        "right_files": {"scene.nml": FURTHER.replace("  initial_stress = 'file'", "") + "&method paper = .false. /\n"}},
    "D376": {
        "files": {"scene.nml": OWN_LAW.replace("'Y = 90 MPa'", "'yield = 90 MPa'"), "law.c": LAW}, "before": [COMPILED],
        "text": "The library of the law declares one constant, Y, in Pa:",
        "commands": [CHECK], "right_files": {"scene.nml": OWN_LAW, "law.c": LAW},
        "right": "library_constants = 'Y = 90 MPa'\n",
        "see": ["../guide/own_law.md#what-the-deck-states"]},
    "D377": {
        "files": {"scene.nml": OWN_LAW, "law.c": WARM_LAW}, "before": [COMPILED],
        "text": "The library declares `needs temperature`:",
        "commands": [CHECK], "right_files": {"scene.nml": OWN_LAW, "law.c": LAW},
        "right": "&effects thermal = .true. /\n",
        "see": ["../guide/own_law.md#what-the-library-declares"]},
    "F118": {
        "files": {"scene.nml": PUSHED, "ram.csv": RAM.replace("1e-6, 0, 0, -1", "1e-6, 0, -1")},
        "text": "The table `ram.csv`; a velocity is missing in its third line:",
        "shows": RAM.replace("1e-6, 0, 0, -1", "1e-6, 0, -1"), "commands": [CHECK], "right": RAM,
        "right_files": {"scene.nml": PUSHED, "ram.csv": RAM}},
    "F119": {
        "files": {"scene.nml": STATES_DECK, "states.txt": COLD},
        "text": "The table `states.txt`; the second line has a higher temperature but less energy than the first:",
        "shows": COLD,
        "commands": [CHECK], "right": STATES, "right_files": {"scene.nml": STATES_DECK, "states.txt": STATES},
        "see": ["materials.md#equations-of-state-as-tables"]},
    "F127": {
        "files": {"scene.nml": OWN_LAW, "law.c": LAW.replace("void scree_law_update", "void update")},
        "before": [COMPILED], "text": "The library has a procedure `update` and none of the name that is expected:",
        "commands": [CHECK], "right_files": {"scene.nml": OWN_LAW, "law.c": LAW},
        "right": "void scree_law_update(scree_rows *rows)\n", "see": ["../guide/own_law.md"]},
    "F128": {
        "files": {"scene.nml": OWN_LAW, "law.c": STATIC_LAW}, "before": [COMPILED],
        "text": "The law counts its calls in a static variable, and adds the count to a stress:",
        "commands": [CHECK], "right_files": {"scene.nml": OWN_LAW, "law.c": LAW},
        "right": "double calls = rows->history[0][i];\n",
        "see": ["../guide/own_law.md#what-to-check"]},
    "F120": {
        "files": {"scene.nml": BAR}, "before": [RUN],
        "text": "The run is continued with outputs in other units:",
        "commands": ["scree -q --restart scene.nml --set time.t_end=2e-4 --set units.output_units=cgs"],
        "then": ["mv out/scene/scene_history.csv out/scene/first_history.csv",
                 "scree -q --restart scene.nml --set time.t_end=2e-4 --set units.output_units=cgs"],
        "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F121": {
        "files": {"scene.nml": SERIES}, "before": [RUN, "cp out/scene/scene_p_000001.hdf whole.hdf",
                                                   "head -c 999 whole.hdf > out/scene/scene_p_000001.hdf"],
        "text": "A snapshot was copied incompletely:", "commands": [AGAIN],
        "then": ["cp whole.hdf out/scene/scene_p_000001.hdf", AGAIN],
        "see": ["../guide/running.md#checkpoints-and-restart"]},
    "F122": {
        "files": {"scene.nml": FURTHER, "first.nml": FIRST},
        "before": [*SNAPSHOT, "mv first.hdf whole.hdf", "head -c 999 whole.hdf > first.hdf"],
        "text": "The points are read from a snapshot that was copied incompletely:",
        "shows": FURTHER.split("\n")[4], "commands": [CHECK]},
    "F126": {
        "files": {"scene.nml": BAR}, "before": [
            RUN, "cp out/scene/scene_history.csv whole.csv", "head -c 4000 whole.csv > out/scene/scene_history.csv"],
        "text": "A table has lost its last rows, and the run is continued:",
        "commands": ["scree -q --restart out/scene/scene_chk_0001.h5 scene.nml --set time.t_end=2e-4"],
        "then": ["cp whole.csv out/scene/scene_history.csv",
                 "scree -q --restart out/scene/scene_chk_0001.h5 scene.nml --set time.t_end=2e-4"],
        "see": ["../guide/running.md#checkpoints-and-restart"]},
    "C112": {"files": {"scene.nml": BAR}, "commands": ["scree --check scene.nml --set"],
             "then": ["scree --check scene.nml --set grid.dx=0.05"]},
    "C113": {"files": {"scene.nml": BAR}, "commands": ["scree --job slurm --ranks 0 scene.nml"],
             "then": ["scree --job slurm --ranks 4 scene.nml"]},
    "C114": {"commands": ["scree --new two_discs"], "then": ["scree --new two_discs my_discs"]},
    "C115": {"files": {"scene.nml": BAR}, "commands": ["scree --check"], "then": ["scree --check scene.nml"]},
    "C116": {"commands": ["scree --explain grid.dxx"], "then": ["scree --explain grid.dx"]},
}
