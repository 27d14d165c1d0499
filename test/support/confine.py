# SPDX-License-Identifier: BSD-3-Clause
"""Run the program under restrictions: without permission, on a small disk, with a limit on the size of files.

    import confine
    with confine.user(options) as somebody:       # an ordinary user, also where the tests run as root
        if somebody.why:
            sheet.skipped("no permission", somebody.why)
        else:
            box = case.Case(somebody.options, "locked", DECK)
            somebody.give(box.folder)
            box.run(expect=3, **somebody.identity)
    box.run(expect=3, **confine.short_files(4096))
    way = confine.way_to_small_disks(folder)
    if way:
        code = confine.on_small_disk(way, folder, "4m", [program, ...])
"""

import contextlib
import os
import resource
import shutil
import subprocess
import tempfile
from pathlib import Path
from types import SimpleNamespace

# Open MPI, and UCX of MPICH, start with shared files of megabytes, which a limit on file sizes forbids; one rank does
# not need them.
NO_SHARED_FILES = {"PMIX_MCA_gds": "hash", "OMPI_MCA_btl": "self", "UCX_TLS": "self"}
NOBODY = 65534      # the user without rights of Linux, who owns no files
# Both methods hide the disk from all other processes and remove it with the last process on it.
WAYS = (("unshare", "--map-root-user", "--mount"), ("unshare", "--mount"))
MOUNT = 'mount -t tmpfs -o size="$1" tmpfs "$2" && shift 2 && exec "$@"'


class User:
    """A user other than root: the current user, or NOBODY if that is root."""

    def __init__(self, options):
        self.identity, self.why, self.options = {}, "", options
        self.folder = None
        if os.geteuid() == 0:
            self.identity = {"user": NOBODY, "group": NOBODY, "extra_groups": []}
        # an ordinary user cannot enter every folder in which root works
        for parent in dict.fromkeys((tempfile.gettempdir(), "/tmp", "/var/tmp")):
            self.leave()
            self.folder = Path(tempfile.mkdtemp(prefix="scree_user_", dir=parent))
            self.give(self.folder)
            program = self.folder / "scree"
            shutil.copy(options.scree, program)
            program.chmod(0o755)
            try:
                answer = subprocess.run([program, "--version"], cwd=self.folder, capture_output=True, text=True,
                                        check=False, **self.identity)
                self.why = f"the program cannot start as another user: {answer.stderr}" if answer.returncode else ""
            except OSError as error:
                self.why = f"no program can start as another user: {error}"
            if not self.why:
                self.options = SimpleNamespace(scree=program, work=self.folder)
                return

    def give(self, path):
        """Make the user the owner of a folder and all its content."""
        if self.identity:
            for place in (path, *path.rglob("*")):
                os.chown(place, NOBODY, NOBODY)

    def leave(self):
        """Remove the files of the user."""
        if self.folder:
            for place in (self.folder, *self.folder.rglob("*")):
                if place.is_dir():
                    place.chmod(0o755)
            shutil.rmtree(self.folder)


@contextlib.contextmanager
def user(options):
    """An ordinary user with a separate folder, which is removed at the end; `why` gives the reason if this is not
    possible."""
    somebody = User(options)
    try:
        yield somebody
    finally:
        somebody.leave()


def short_files(size):
    """Arguments for a run on one rank in which no file can exceed a given size."""
    def limit():
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
    return {"preexec_fn": limit, "env": NO_SHARED_FILES}


def way_to_small_disks(folder):
    """The method to mount a small file system in a folder that this user and machine allow; None if there is none."""
    folder.mkdir(parents=True, exist_ok=True)
    for way in WAYS:
        with contextlib.suppress(OSError):
            if subprocess.run([*way, "sh", "-c", MOUNT, "sh", "64k", folder, "true"], capture_output=True,
                              check=False).returncode == 0:
                return way
    return None


def on_small_disk(way, folder, size, words):
    """Exit code of a command that runs with a new, empty file system of a given size in a folder."""
    command = [*way, "sh", "-c", MOUNT, "sh", size, folder, *words]
    # Open MPI names a folder after the user number, which is 0 there: the folder would be that of root
    with tempfile.TemporaryDirectory(prefix="scree_disk_") as place:
        return subprocess.run([str(word) for word in command], check=False,
                              env={**os.environ, "TMPDIR": place}).returncode
