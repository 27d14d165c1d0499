# SPDX-License-Identifier: BSD-3-Clause
"""Run commands that may hang, with limits on processor time, wall time and memory."""

import os
import resource
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Sequence

WALL = 900.0                    # seconds; processor time is the limit that counts, because machines are shared
MEMORY = 12 * 1024 ** 3         # bytes of addresses of one process
FILE = 2 * 1024 ** 3            # bytes of one file
KEPT = 20000                    # bytes of the output that are kept


@dataclass(frozen=True)
class Ended:
    """How a command ended."""
    code: int
    seconds: float
    output: str
    late: bool                  # it was stopped by a limit of time


def descendants(process: int) -> List[int]:
    """Numbers of the processes that a process started, directly or not."""
    parents: Dict[int, int] = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                text = (entry / "stat").read_text(encoding="utf-8", errors="replace")
            except OSError:
                continue
            parents[int(entry.name)] = int(text[text.rindex(")") + 2:].split()[1])
    found = [process]
    for one in found:
        found += [child for child, parent in parents.items() if parent == one]
    return found[1:]


def stop(process: "subprocess.Popen[bytes]") -> None:
    """End a process and all that it started; mpiexec gives each rank a process group of its own."""
    family = [process.pid, *descendants(process.pid)]
    process.terminate()
    try:
        process.wait(5.0)
    except subprocess.TimeoutExpired:
        pass
    for one in family:
        try:
            os.kill(one, signal.SIGKILL)
        except ProcessLookupError:
            pass
    process.wait()


def run(command: Sequence[str], folder: Path, environment: Dict[str, str], cpu: float) -> Ended:
    """Run a command; each of its processes gets at most `cpu` seconds of processor time."""
    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(cpu) + 1, int(cpu) + 3))
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_FSIZE, (FILE, FILE))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    begin = time.time()
    late = False
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(list(command), cwd=folder, env={**os.environ, **environment}, stdout=output,
                                   stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, start_new_session=True,
                                   preexec_fn=limit)
        try:
            process.wait(WALL)
        except subprocess.TimeoutExpired:
            late = True
            stop(process)
        except BaseException:
            stop(process)
            raise
        output.seek(max(0, output.seek(0, os.SEEK_END) - KEPT))
        text = output.read().decode("utf-8", "replace")
    late = late or process.returncode == -signal.SIGXCPU or "signal 24" in text or "CPU time limit" in text
    return Ended(process.returncode, time.time() - begin, text, late)
