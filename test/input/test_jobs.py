# SPDX-License-Identifier: BSD-3-Clause
"""Scripts of `--job`, run with stand-ins for the commands of schedulers, which this machine need not have.

Would catch a script that the shell cannot read, loses an option or a quote, does not put the job into the queue when
the run asks for it, does so for any other reason, or begins anew where it should go on.
"""

import os
import shutil
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
SRUN = '#!/bin/bash\necho "srun $*" >> calls\nexec mpiexec -n "$SLURM_NTASKS" "$@"\n'
CALL = '#!/bin/bash\necho "{0} $*" >> calls\n'
SOON, LATE = 30, 100000     # seconds: less and more than the program keeps in reserve


class TestJobs:
    """Each test has a folder of its own."""

    @pytest.fixture(autouse=True)
    def made(self, options):
        self.folder = options.work / "a 'quoted' one"
        (self.folder / "bin").mkdir(parents=True)
        for name, text in [("srun", SRUN), ("scontrol", CALL.format("scontrol")),
                           ("qsub", CALL.format("qsub"))]:
            (self.folder / "bin" / name).write_text(text, encoding="utf-8")
            (self.folder / "bin" / name).chmod(0o755)
        (self.folder / "my deck.nml").write_text(DECK, encoding="utf-8")

    def script(self, options, *words, expect=0):
        """The script for some words of the command line, or what is said of them."""
        answer = subprocess.run([options.scree, *words, "my deck.nml"], cwd=self.folder, text=True,
                                capture_output=True)
        assert answer.returncode == expect, answer.stderr
        if expect:
            return answer.stderr
        path = self.folder / "job.sh"
        path.write_text(answer.stdout, encoding="utf-8")
        assert subprocess.run(["bash", "-n", path]).returncode == 0, answer.stdout
        return answer.stdout

    def execute(self, seconds, ranks):
        """Exit code of the script in a job that ends so many seconds from now, and the calls of stand-ins."""
        (self.folder / "calls").write_text("", encoding="utf-8")
        answer = subprocess.run(
            ["bash", "job.sh"], cwd=self.folder, text=True, capture_output=True, timeout=250,
            env={**os.environ, **case.OPEN_MPI, "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}",
                 "SLURM_JOB_ID": "4711", "SLURM_NTASKS": str(ranks), "SLURM_CPUS_PER_TASK": "1",
                 "SLURM_JOB_END_TIME": str(int(time.time() + seconds)), "PBS_O_WORKDIR": str(self.folder)})
        self.said = answer.stdout + answer.stderr
        return answer.returncode, (self.folder / "calls").read_text(encoding="utf-8").splitlines()

    def summary(self, outdir):
        return case.json.loads((self.folder / outdir / "block.summary.json").read_text(encoding="utf-8"))

    def test_slurm_comes_back(self, options):
        """A job whose time is over is put into the queue again, goes on, ends, and is not put there then."""
        text = self.script(options, "--job", "slurm", "--ranks", "2", "--threads", "1", "--outdir", "re sults",
                           "--set", "run.title='it is \"so\"'")
        assert "#SBATCH --ntasks=2\n" in text
        assert "#SBATCH --signal=USR1@300\n" in text
        code, calls = self.execute(SOON, 2)
        assert code == 75, self.said
        assert calls[1:] == ["scontrol requeue 4711"]
        assert "--restart" not in calls[0]
        before = self.summary("re sults")
        assert 0 < before["steps"] < 20, before["steps"]
        code, calls = self.execute(LATE, 2)
        assert (code, len(calls)) == (0, 1), self.said
        assert calls[0].endswith("--restart"), calls
        straight = subprocess.run(
            [options.scree, "--quiet", "my deck.nml", "--set", "time.wall_limit=none"], cwd=self.folder)
        assert straight.returncode == 0
        assert self.summary("re sults")["digest"] == self.summary("out/block")["digest"]

    def test_slurm_stays_away(self, options):
        """A run that fails for another reason is not put into the queue again."""
        self.script(options, "--job", "slurm", "--set", "time.speed_max=0.5")
        code, calls = self.execute(LATE, 1)
        assert (code, len(calls)) == (4, 1), self.said

    def test_pbs_comes_back(self, options):
        """The same for PBS: the clock of the run ends it, and the script submits itself."""
        if not shutil.which("mpirun"):
            pytest.skip("there is no mpirun")
        text = self.script(options, "--job", "pbs", "--ranks", "2", "--threads", "3", "--time", "1:00:00")
        assert "#PBS -l select=2:ncpus=3:mpiprocs=1:ompthreads=3\n" in text
        assert "#PBS -l walltime=1:00:00\n" in text
        text = self.script(options, "--job", "pbs", "--ranks", "2", "--threads", "1", "--time", "1:00:00")
        assert "--set time.wall_limit=00:55:00 " in text
        path = self.folder / "job.sh"
        path.write_text(text.replace("00:55:00", "00:00:00"), encoding="utf-8")
        code, calls = self.execute(LATE, 2)
        assert (code, calls) == (75, ["qsub job.sh"]), self.said
        path.write_text(text, encoding="utf-8")
        code, calls = self.execute(LATE, 2)
        assert (code, calls) == (0, []), self.said
        assert "restart from" in (self.folder / "out/block/block.log").read_text(encoding="utf-8")

    def test_suggestions(self, options):
        """Would catch a suggestion that does not follow the particles, and times that are taken for others."""
        text = self.script(options, "--job", "slurm", "--time", "0:05:00")
        assert "#SBATCH --ntasks=1\n" in text
        assert "#SBATCH --signal=USR1@60\n" in text
        fine = self.script(options, "--job", "slurm", "--set", "grid.dx=5e-4")
        particles = int(fine.split("# ")[2].split()[0])
        assert particles > 1.5e6
        assert f"#SBATCH --ntasks={-(-particles // 10**6)}\n" in fine

    def test_refusals(self, options, sheet):
        """Would catch a number or word that is taken for another, and a job that no signal reaches."""
        for words, message in [
                (["--job", "lsf"], "--job knows slurm and pbs, not 'lsf'"),
                (["--job", "slurm", "--ranks", "0"], "--ranks = '0' must be an integer above 0"),
                (["--job", "slurm", "--threads", "two"], "--threads = 'two' must be an integer above 0"),
                (["--job", "slurm", "--time", "4h"], "--time = '4h' must be hours, minutes and seconds"),
                (["--job", "slurm", "--time", "0:61:00"], "--time = '0:61:00' must be hours"),
                (["--job", "slurm", "--check"], "--job excludes --check, --point and --restart"),
                (["--ranks", "4"], "--ranks needs --job"),
                (["--threads", "4"], "--threads needs --job"),
                (["--time", "1:00:00"], "--time needs --job"),
                (["--job", "slurm", "--set", "checkpoint.on_signal='TERM'"],
                 "the scheduler announces the end of the job with signal USR1; add 'USR1' to on_signal"),
                (["--job", "slurm", "--set", "grid.dxx=1"], "unknown key 'dxx'")]:
            with sheet.part(words):
                assert message in self.script(options, *words, expect=2)
