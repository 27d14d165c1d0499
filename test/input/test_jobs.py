# SPDX-License-Identifier: BSD-3-Clause
"""Job scripts of `--job`, run with substitutes for the commands of schedulers, which need not be installed.

Would catch a script that the shell cannot read, that loses an option or a quote, does not resubmit the job when the run
requests it, resubmits it for any other reason, loses an exit code, starts from the beginning where it should
restart, or removes results; a signal that ends the script instead of the run; and a memory request that does not depend
on the number of particles.
"""

import os
import re
import shutil
import signal
import subprocess
import time

import pytest

import case

DECK = """&run dimension = 'plane_strain'  case = 'block' /
&grid lo = 0 0 0  hi = 1 0.1 1  dx = 0.1 /
&time t_end = 2e-4  dt_fixed = 1e-5  wall_limit = 'slurm' /
&material name = 'metal'  density = 2700  young = 70e9  poisson = 0.3 /
&region name = 'ball'  shape = 'sphere'  centre = 0.5 0 0.5  radius = 0.2 /
&body name = 'one'  region = 'ball'  material = 'metal'  velocity = 1 0 0 /
"""
FINE = ("--set", "grid.dx=5e-4", "--unset", "time.dt_fixed")
SCHEDULERS = ("slurm", "pbs")
SRUN = """#!/bin/bash
if [ "$1" = --mpi=list ]; then echo 'MPI plugin types are: pmix none' >&2; exit; fi
echo "srun $*" >> calls
echo $$ > launcher
exec mpiexec -n "$SLURM_NTASKS" "$@"
"""
CALL = '#!/bin/bash\necho "{0} $*" >> calls\n'
# Substitute for the launcher of the ranks: returns the next of a list of exit codes.
CODES = """#!/bin/bash
if [ "$1" = --mpi=list ]; then echo pmix; exit; fi
read -r code < codes
sed -i 1d codes
exit "${{code}}"
"""
SOON, LATE = 30, 100000     # seconds: less and more than the reserve of the program


class TestJobs:
    """Each test has a separate folder."""

    @pytest.fixture(autouse=True)
    def made(self, options):
        self.folder = options.work / "a 'quoted' [one] $HOME `x` ö"
        (self.folder / "bin").mkdir(parents=True)
        for name, text in [("srun", SRUN), ("scontrol", CALL.format("scontrol")), ("qsub", CALL.format("qsub"))]:
            self.stand_in(name, text)
        (self.folder / "my deck.nml").write_text(DECK, encoding="utf-8")

    def stand_in(self, name, text):
        """A substitute for a command of a scheduler or of MPI."""
        path = self.folder / "bin" / name
        path.write_text(text, encoding="utf-8")
        path.chmod(0o755)

    @property
    def environment(self):
        """The environment with the substitutes before all other commands."""
        return {**os.environ, **case.OPEN_MPI, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}",
                "PBS_O_WORKDIR": str(self.folder), "SLURM_JOB_ID": "4711"}

    def script(self, options, *words, expect=0):
        """The script for some options of the command line, or the error message about them."""
        answer = subprocess.run([options.scree, *words, "my deck.nml"], cwd=self.folder, text=True,
                                capture_output=True)
        assert answer.returncode == expect, answer.stderr
        if expect:
            return answer.stderr
        path = self.folder / "job.sh"
        path.write_text(answer.stdout, encoding="utf-8")
        assert subprocess.run(["bash", "-n", path]).returncode == 0, answer.stdout
        return answer.stdout

    def execute(self, seconds, ranks, **more):
        """Exit code of the script in a job that ends in a given number of seconds, and the calls of the substitutes."""
        (self.folder / "calls").write_text("", encoding="utf-8")
        answer = subprocess.run(
            ["bash", "job.sh"], cwd=self.folder, text=True, capture_output=True, timeout=250,
            env={**self.environment, **more, "SLURM_NTASKS": str(ranks), "SLURM_CPUS_PER_TASK": "1",
                 "SLURM_JOB_END_TIME": str(int(time.time() + seconds))})
        self.said = answer.stdout + answer.stderr
        return answer.returncode, (self.folder / "calls").read_text(encoding="utf-8").splitlines()

    def summary(self, outdir):
        return case.json.loads((self.folder / outdir / "block.summary.json").read_text(encoding="utf-8"))

    def test_slurm_comes_back(self, options):
        """A job whose time is over is resubmitted, restarts, ends, and is not resubmitted again."""
        text = self.script(options, "--job", "slurm", "--ranks", "2", "--threads", "1", "--outdir", "re sults[1]",
                           "--set", "run.title='it is \"so\"; $(touch bad) `touch bad`'")
        assert "#SBATCH --ntasks=2\n" in text
        assert "#SBATCH --signal=USR1@300\n" in text
        code, calls = self.execute(SOON, 2)
        assert code == 75, self.said
        assert calls[1:] == ["scontrol requeue 4711"]
        log = (self.folder / "re sults[1]/block.log").read_text(encoding="utf-8")
        assert "--restart starts it at step 0" in log
        before = self.summary("re sults[1]")
        assert 0 < before["steps"] < 20, before["steps"]
        code, calls = self.execute(LATE, 2)
        assert (code, len(calls)) == (0, 1), self.said
        assert calls[0].endswith("--restart"), calls
        log = (self.folder / "re sults[1]/block.log").read_text(encoding="utf-8")
        assert "restart from re sults[1]/block_chk_" in log
        assert not (self.folder / "bad").exists()
        straight = subprocess.run(
            [options.scree, "--quiet", "my deck.nml", "--set", "time.wall_limit=none"], cwd=self.folder)
        assert straight.returncode == 0
        assert self.summary("re sults[1]")["digest"] == self.summary("out/block")["digest"]

    def test_results_without_checkpoint(self, options):
        """Would catch a script that removes results: the files of a run whose checkpoints were removed remain."""
        self.script(options, "--job", "slurm", "--ranks", "1", "--threads", "1")
        assert self.execute(SOON, 1)[0] == 75, self.said
        folder = self.folder / "out/block"
        for path in [*folder.glob("*.h5"), folder / "block.summary.json"]:
            path.unlink()
        before = {path.name: path.read_bytes() for path in folder.iterdir()}
        code, calls = self.execute(LATE, 1)
        assert (code, len(calls)) == (3, 1), self.said
        assert "--overwrite removes the results" in self.said
        assert {path.name: path.read_bytes() for path in folder.iterdir()} == before

    def test_slurm_stays_away(self, options):
        """A run that fails for another reason is not resubmitted."""
        self.script(options, "--job", "slurm", "--set", "time.speed_max=0.5")
        code, calls = self.execute(LATE, 1)
        assert (code, len(calls)) == (4, 1), self.said

    def test_pbs_comes_back(self, options):
        """The same for PBS: the run ends by its wall limit, and the script resubmits itself."""
        if not shutil.which("mpirun"):
            pytest.skip("there is no mpirun")
        text = self.script(options, "--job", "pbs", "--ranks", "2", "--threads", "3", "--time", "1:00:00")
        assert "#PBS -l select=2:ncpus=3:mpiprocs=1:ompthreads=3:mem=" in text
        assert "#PBS -l walltime=01:00:00\n" in text
        text = self.script(options, "--job", "pbs", "--ranks", "2", "--threads", "1", "--time", "1:00:00")
        assert "--set time.wall_limit=00:55:00 " in text
        path = self.folder / "job.sh"
        path.write_text(text.replace("00:55:00", "00:00:00"), encoding="utf-8")
        code, calls = self.execute(LATE, 2)
        assert (code, calls) == (75, ["qsub job.sh"]), self.said
        code, calls = self.execute(LATE, 2, PBS_JOBID="12.server")
        assert (code, calls) == (4, []), "a chain of jobs that do one step each"
        assert "wall_limit reached during the first step after a restart" in self.said
        path.write_text(text, encoding="utf-8")
        code, calls = self.execute(LATE, 2)
        assert (code, calls) == (0, []), self.said
        assert "restart from" in (self.folder / "out/block/block.log").read_text(encoding="utf-8")

    @pytest.mark.parametrize("scheduler", SCHEDULERS)
    def test_exit_codes(self, options, scheduler):
        """Exit code 75 resubmits the job, 0 and other codes do not, and the script ends with the code of the run."""
        if scheduler == "pbs":
            case.need_ranks(options.scree)    # without MPI there is no launcher before the program
        self.script(options, "--job", scheduler, "--ranks", "2", "--threads", "1")
        for name in ("srun", "mpirun"):
            self.stand_in(name, CODES.format(name))
        again = {"slurm": ["scontrol requeue 4711"], "pbs": ["qsub job.sh"]}[scheduler]
        for code in (75, 0, 3, 4, 1):
            (self.folder / "codes").write_text(f"{code}\n", encoding="utf-8")
            found, calls = self.execute(LATE, 2)
            assert (found, calls) == (code, again if code == 75 else []), self.said

    @pytest.mark.parametrize("scheduler", SCHEDULERS)
    def test_shellcheck(self, options, scheduler):
        """Would catch constructs that the shell accepts with another meaning: unquoted words, variables that are never
        set."""
        if not shutil.which("shellcheck"):
            pytest.skip("there is no shellcheck")
        self.script(options, "--job", scheduler, "--outdir", "re sults", "--set", "run.title='it is \"so\"'")
        answer = subprocess.run(["shellcheck", "job.sh"], cwd=self.folder, text=True, capture_output=True)
        assert answer.returncode == 0, answer.stdout

    def test_signal(self, options):
        """The warning signal, which Slurm sends to the ranks, makes the run write its checkpoint and the job
        restart; the second part ends with the same bits as an uninterrupted run."""
        case.need_ranks(options.scree)
        if not shutil.which("mpirun"):
            pytest.skip("there is no mpirun")
        with (self.folder / "my deck.nml").open("a", encoding="utf-8") as deck:
            deck.write("&output name = 'h'  kind = 'history'  every = 1 /\n")
        text = self.script(options, "--job", "slurm", "--ranks", "2", "--threads", "1", "--time", "1:00:00",
                           "--unset", "time.wall_limit", "--set", "time.t_end=1")
        path = self.folder / "job.sh"
        child = subprocess.Popen(["bash", "job.sh"], cwd=self.folder, start_new_session=True,
                                 env={**self.environment, "SLURM_NTASKS": "2", "SLURM_CPUS_PER_TASK": "1"},
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        history = self.folder / "out/block/block_history.csv"
        end = time.monotonic() + 200
        while child.poll() is None and time.monotonic() < end and not (
                history.is_file() and history.stat().st_size > 2000):
            time.sleep(0.02)
        os.kill(int((self.folder / "launcher").read_text(encoding="utf-8")), signal.SIGUSR1)
        said, _ = child.communicate(timeout=200)
        assert child.returncode == 75, said
        first = self.summary("out/block")["steps"]
        last = f"time.t_end=1 --set time.max_steps={first + 20}"
        path.write_text(text.replace("time.t_end=1", last), encoding="utf-8")
        code, calls = self.execute(LATE, 2)
        assert code == 0, self.said
        assert "restart from" in (self.folder / "out/block/block.log").read_text(encoding="utf-8")
        straight = subprocess.run([options.scree, "-q", "my deck.nml", "--outdir", "whole", "--set", "time.t_end=1",
                                   "--unset", "time.wall_limit", "--set", f"time.max_steps={first + 20}"],
                                  cwd=self.folder)
        assert straight.returncode == 0
        assert self.summary("whole")["digest"] == self.summary("out/block")["digest"]

    def test_memory(self, options):
        """Would catch a memory request that does not depend on particles and ranks, or that is repeated for each
        thread."""
        def megabytes(*words):
            return int(re.search(r":mem=(\d+)mb", self.script(options, "--job", "pbs", "--threads", "4", *words))[1])
        small, fine = megabytes("--ranks", "1"), megabytes("--ranks", "1", *FINE)
        assert 256 <= small < 300
        assert fine > small + 4*1.5*100
        assert megabytes("--ranks", "4", *FINE) - 256 < (fine - 256)/4 + 8
        text = self.script(options, "--job", "slurm", "--ranks", "1", "--threads", "4", *FINE)
        assert abs(4*int(re.search(r"mem-per-cpu=(\d+)M", text)[1]) - fine) <= 4

    def test_suggestions(self, options):
        """Would catch a suggested number of ranks that does not depend on the particles, and times that are read
        wrongly."""
        text = self.script(options, "--job", "slurm", "--time", "0:05:00")
        assert "#SBATCH --ntasks=1\n" in text
        assert "#SBATCH --signal=USR1@60\n" in text
        fine = self.script(options, "--job", "slurm", *FINE)
        particles = int(re.search(r"^# (\d+) particles in", fine, re.M)[1])
        assert particles > 1.5e6
        assert f"#SBATCH --ntasks={-(-particles // 10**6)}\n" in fine

    def test_nodes_and_days(self, options):
        """Would catch ranks that are not spread over the nodes as requested, memory of one rank for a whole node, and a
        time in a form that the scheduler does not read. Lines for the partition and the account do nothing."""
        words = ("--nodes", "2", "--ranks", "6", "--threads", "4", "--time", "2-00:00:00")
        slurm, pbs = (self.script(options, "--job", name, *words) for name in SCHEDULERS)
        for text, lines in (
                (slurm, ("#SBATCH --nodes=2", "#SBATCH --ntasks=6", "#SBATCH --ntasks-per-node=3",
                         "#SBATCH --time=2-00:00:00", "##SBATCH --partition=NAME", "##SBATCH --account=NAME")),
                (pbs, ("#PBS -l place=scatter", "#PBS -l walltime=48:00:00", "##PBS -q NAME", "##PBS -A NAME"))):
            assert set(lines) <= set(text.splitlines()), text
            assert "{{" not in text
        chunk = re.search(r"^#PBS -l select=2:ncpus=12:mpiprocs=3:ompthreads=4:mem=(\d+)mb$", pbs, re.M)
        core = re.search(r"^#SBATCH --mem-per-cpu=(\d+)M$", slurm, re.M)
        assert abs(int(chunk[1]) - 12*int(core[1])) <= 12
        rounded = self.script(options, "--job", "slurm", "--nodes", "3")
        assert "#SBATCH --ntasks=3\n" in rounded and "#SBATCH --ntasks-per-node=1\n" in rounded
        alone = "".join(self.script(options, "--job", name) for name in SCHEDULERS)
        assert not re.search(r"nodes|per-node|scatter", alone)

    def test_refusals(self, options, sheet):
        """Would catch a number or word that is accepted with another meaning, and a job that no signal reaches."""
        for words, message in [
                (["--job", "sge"], "--job knows slurm and pbs, not 'sge'"),
                (["--job", "slurm", "--ranks", "0"], "--ranks = '0' must be an integer above 0"),
                (["--job", "slurm", "--threads", "two"], "--threads = 'two' must be an integer above 0"),
                (["--job", "slurm", "--time", "4h"], "--time = '4h' must be hours, minutes and seconds"),
                (["--job", "slurm", "--time", "0:61:00"], "--time = '0:61:00' must be hours"),
                (["--job", "slurm", "--check"], "--job excludes --check, --point, --restart and --overwrite"),
                (["--job", "slurm", "--overwrite"], "--job excludes --check, --point, --restart and --overwrite"),
                (["--job", "slurm", "--nodes", "2", "--ranks", "3"], "--ranks must be a multiple of --nodes"),
                (["--nodes", "2"], "--nodes needs --job"),
                (["--ranks", "4"], "--ranks needs --job"),
                (["--threads", "4"], "--threads needs --job"),
                (["--time", "1:00:00"], "--time needs --job"),
                (["--job", "slurm", "--set", "checkpoint.on_signal='TERM'"],
                 "the scheduler announces the end of the job with signal USR1; add 'USR1' to on_signal"),
                (["--job", "slurm", "--set", "grid.dxx=1"], "unknown key 'dxx'")]:
            with sheet.part(words):
                assert message in self.script(options, *words, expect=2)
