# SPDX-License-Identifier: BSD-3-Clause
"""Kill a run, or let its system calls fail, at a chosen call that changes files.

    faults = Faults(options)                   # compiles interpose.c
    count = faults.count(run)                  # calls of a whole run
    faults.run(run, 17)                        # is killed before call 17
    faults.run(run, 17, action="28")           # no space from call 17 on
"""

import os
import subprocess
import tempfile
from pathlib import Path

import case

SOURCE = Path(__file__).with_name("interpose.c")
# A step is cheap, so that writing files is most of the run: all kinds of tables, snapshots, and checkpoints between.
DECK = """
&run  dimension='plane_strain' /
&grid  lo=0,0,0  hi=12,1,12  dx=1 /
&time  t_end=0.08  {limit} /
&effects  gravity=.true.  gravity_vector=0,0,-9.81 /
&material  name='rubber'  density=1000  young=1.0e6  poisson=0.3 /
&region  name='box'  shape='box'  lo=3,0,0  hi=9,1,6 /
&body  name='block'  region='box'  material='rubber'  velocity=3,0,-9 /
&boundary  face='all'  type='slip' /
&output  name='h'  kind='history'  every=2 /
&output  name='all'  kind='history'  dt=0.017 /
&output  name='g'  kind='gauge'  point=6,0.5,2  every=3 /
&output  name='f'  kind='forces'  every=4 /
&output  name='s'  kind='profile'  every=7  {profile} /
&output  name='p'  kind='particles'  dt=0.03 /
&checkpoint  {checkpoint}  keep=2 /
"""


def deck(limit="", profile="", checkpoint="dt=0.011"):
    """The deck of these tests."""
    return DECK.format(limit=limit, profile=profile, checkpoint=checkpoint)


class Faults:
    """The library that is loaded before the program."""

    def __init__(self, options):
        # the loader takes a blank in LD_PRELOAD for the end of a name, and the working folder may have one
        self.folder = tempfile.TemporaryDirectory(prefix="scree_faults_")
        self.library = Path(self.folder.name) / "interpose.so"
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", self.library, SOURCE, "-ldl", "-lpthread"], check=True)

    def run(self, run, call, *words, action="kill", rank=None, reserve=True, timeout=60):
        """Exit code of a run with a fault at a call, 0: none; negative: a signal; None: it hangs."""
        environment = {**run.environment, "FAULT_FOLDER": str(run.folder), "FAULT_CALL": str(call),
                       "FAULT_ACTION": action, "FAULT_COUNT": str(run.folder) + ".count"}
        if rank is not None:
            environment["FAULT_RANK"] = str(rank)
        if not reserve:
            environment["FAULT_NO_RESERVE"] = "1"
        # Open MPI keeps files in a folder that all its runs share, and removes it with the last one that it knows of
        environment["TMPDIR"] = str(self.library.parent / "mpi")
        Path(environment["TMPDIR"]).mkdir(exist_ok=True)
        command = run.command(*words)
        place = command.index(str(run.scree))
        command[place:place] = ["env", f"LD_PRELOAD={self.library}"]
        if action in ("kill", "tear") and "--restart" not in words:
            command.remove("--overwrite")
        with subprocess.Popen(command, env=environment, cwd=run.folder, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, start_new_session=True) as child:
            try:
                run.output = child.communicate(timeout=timeout)[0]
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, 9)
                run.output = child.communicate()[0]
                return None
        return child.returncode

    def count(self, run, *words):
        """Number of calls of a run without a fault."""
        code = self.run(run, 0, *words)
        assert code == 0, run.output
        return int(Path(str(run.folder) + ".count").read_text(encoding="utf-8"))


def tables(run):
    """Tables, snapshots and digest of a finished run by their names."""
    found = {path.name: path.read_bytes() for path in run.folder.iterdir()
             if path.suffix in (".csv", ".hdf", ".series", ".vtkhdf")}
    found["digest"] = run.summary["digest"]
    return found


def different(found, whole):
    """Names of the files that differ, with the numbers of lines of tables."""
    names = [name for name in sorted({*found, *whole}) if found.get(name) != whole.get(name)]
    def lines(files, name):
        return files[name].count(b"\n") if name in files and name.endswith("csv") else ""

    return [f"{name} {lines(found, name)}/{lines(whole, name)}" for name in names]


def has_checkpoint(run):
    """True if there is a complete checkpoint."""
    return any(run.folder.glob("*_chk_*.h5"))


def fresh(options, name, text, **how):
    """A case whose files have the name of those of all others."""
    run = case.Case(options, name, text, **how)
    run.name, run.deck = "fault", run.deck.rename(run.folder / "fault.nml")
    return run
