# SPDX-License-Identifier: BSD-3-Clause
# tiers: smoke, full
"""scree --self-test: detected errors, leftover files, requirements.

Would catch: a self-test that passes with wrong digests, digests that were not updated after a change of results, files
that are left over or written elsewhere, a failure without exit code or message code, and a use of the network.
"""

import os
import re
import shutil
import subprocess
import sys

import pytest

import case
import confine

FILE = case.ROOT / "src/program/self_test/digests.csv"
ROW = re.compile(r"^ *(\w+) +(\d+) +(\d+) +([0-9a-f]{16}) +(\w+) +same +same +same +same +same +[\d.]+$", re.M)
# hwloc, a library of Open MPI, looks for displays of this machine
CONNECTION = re.compile(r'connect\(\d+, \{sa_family=AF_INET6?, .*?"([\d.:a-f]+)"')


def self_test(program, folder, *words, before=(), code=0, **more):
    """Output and errors of a self-test in an empty folder, whose subfolder tmp is for its temporary files."""
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "tmp").mkdir(parents=True)
    (folder / "here").mkdir()
    environment = {**os.environ, **case.OPEN_MPI, "TMPDIR": str(folder / "tmp"), "OMP_NUM_THREADS": "1"}
    environment.update(more)
    answer = subprocess.run([*before, str(program), "--self-test", *words], cwd=folder / "here", env=environment,
                            text=True, timeout=200, check=False, capture_output=True)
    assert answer.returncode == code, answer.stdout + answer.stderr
    assert list((folder / "here").iterdir()) == []
    assert [path.name for path in (folder / "tmp").glob("scree*")] == []
    return answer.stdout, answer.stderr


def kind_of(output):
    """Kind of the build that a self-test prints."""
    return re.search(r"^self-test scree [^,]+, ([^,]+), ", output, re.M).group(1)


@pytest.fixture(scope="module")
def passed(file_options):
    """Output and errors of the program that is tested."""
    return self_test(file_options.scree, file_options.work / "whole")


class TestSelfTest:
    """The self-test of the program that is tested."""

    def test_passes(self, passed):
        """Would catch a scene that is not run, and one in which nothing moves."""
        said, wrong = passed
        rows = ROW.findall(said)
        decks = sorted(path.stem for path in FILE.parent.glob("*.nml"))
        assert [row[0] for row in rows] == decks, said
        assert len(decks) > 5
        assert all(int(particles) > 500 and int(steps) > 50 for _, particles, steps, *_ in rows)
        assert len({row[3] for row in rows}) == len(rows)
        assert re.search(r"^passed +\d+ checks in \d+ s$", said, re.M)
        assert wrong == ""

    def test_digests_are_renewed(self, options, passed):
        """The recorded digests are those of this build; those of GCC 12 on x86-64 are always recorded."""
        answer = subprocess.run([sys.executable, case.ROOT / "scripts/self_test_digests.py", "--check", "--scree",
                                 options.scree], text=True, capture_output=True, check=False,
                                env={**os.environ, **case.OPEN_MPI})
        known = FILE.read_text(encoding="utf-8")
        assert "\nx86_64 gfortran 12,discs," in known
        said, _ = passed
        if kind_of(said) + "," not in known:
            assert "no digests are recorded for this kind of build" in said
            pytest.skip(f"no digests of {kind_of(said)} are recorded")
        assert answer.returncode == 0, answer.stdout + answer.stderr
        assert all(row[4] == "same" for row in ROW.findall(said)), said

    @pytest.mark.tiers("full")
    def test_ranks_and_threads(self, options):
        """The digests are the same on two ranks, and where most runs have two threads."""
        said, _ = self_test(options.scree, options.work / "threads", OMP_NUM_THREADS="2")
        digests = [row[3] for row in ROW.findall(said)]
        case.need_ranks(options.scree)
        said, _ = self_test(options.scree, options.work / "ranks", before=["mpirun", "-n", "2"])
        assert ", 2 ranks," in said
        assert [row[3] for row in ROW.findall(said)] == digests
        assert len(digests) > 5

    def test_wrong_digest(self, options, passed):
        """A program in which one recorded digest is wrong fails, and reports the scene."""
        said, _ = passed
        rows = [line.split(",") for line in FILE.read_text(encoding="utf-8").splitlines()]
        digest = {tuple(row[:2]): row[2] for row in rows}.get((kind_of(said), "sand"))
        if digest is None:
            pytest.skip(f"no digests of {kind_of(said)} are recorded")
        program = options.work / "other/bin/scree"
        program.parent.mkdir(parents=True, exist_ok=True)
        # the compiler may have split the text into parts of eight characters
        text = options.scree.read_bytes()
        assert text.count(digest[:8].encode()) == 1
        program.write_bytes(text.replace(digest[:8].encode(), b"00000000"))
        program.chmod(0o755)
        said, wrong = self_test(program, options.work / "wrong", code=5)
        assert f"sand, digest and the recorded one: {digest} instead of 00000000{digest[8:]}" in wrong
        assert re.search(r"self-test: error: 1 of \d+ checks failed: \[R\d+\]", wrong), wrong
        assert said.count("DIFFERS") == 1
        assert "passed" not in said

    @pytest.mark.tiers("full")
    def test_quiet(self, options):
        """Would catch a table that --quiet does not suppress."""
        assert self_test(options.scree, options.work / "quiet", "-q") == ("", "")

    def test_no_room(self, options):
        """Files that cannot be written are reported as failures with their reason, without the path of the removed
        folder."""
        program = ["sh", "-c", 'ulimit -f 8; exec "$@"', "sh"]
        _, wrong = self_test(options.scree, options.work / "short", before=program, code=5, **confine.NO_SHARED_FILES)
        assert "discs runs" in wrong
        assert re.search(r"^ +cannot \w+ .*'discs/whole/.*\[F\d+\]$", wrong, re.M), wrong

    def test_takes_no_deck(self, options):
        """Would catch a deck on the command line that is ignored without a message."""
        _, wrong = self_test(options.scree, options.work / "deck", "scene.nml", code=2)
        assert "--self-test takes no deck" in wrong

    @pytest.mark.tiers("full")
    def test_no_network(self, options):
        """The program works without a network, and connects to no other machine."""
        # Open MPI needs the loopback device, even for one rank
        alone = ["unshare", "--map-root-user", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh"]
        if subprocess.run([*alone, "true"], check=False, capture_output=True).returncode:
            pytest.skip("no network namespace can be made here, or there is no ip")
        said, _ = self_test(options.scree, options.work / "alone", before=alone)
        assert "passed" in said
        if not shutil.which("strace"):
            pytest.skip("there is no strace")
        log = options.work / "calls.txt"
        self_test(options.scree, options.work / "traced", before=["strace", "-f", "-qq", "-e", "trace=connect,openat",
                                                                  "-o", log])
        text = log.read_text(encoding="utf-8", errors="replace")
        assert "scree_self_test_" in text
        assert [address for address in CONNECTION.findall(text)
                if not address.startswith("127.") and address != "::1"] == []
