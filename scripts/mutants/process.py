# SPDX-License-Identifier: BSD-3-Clause
"""Run commands that may not terminate, with limits on processor time, wall time and memory."""

import os
import resource
import signal
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Dict, List, Sequence

# wall time limit [s]; it is long because machines are shared, the processor time limit ends runs earlier
WALL = 900.0
MEMORY = 12 * 1024 ** 3         # address space of one process [bytes]
FILE = 2 * 1024 ** 3            # size of one file [bytes]
KEPT = 20000                    # part of the output that is stored [bytes]


@dataclass(frozen=True)
class Ended:
    """Result of a command: exit code, output, and whether a limit ended it."""
    code: int
    seconds: float
    output: str
    late: bool                  # a time limit ended the command


def descendants(process: int) -> List[int]:
    """Identifiers of all child processes of a process, direct and indirect."""
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
    """End a process and all its child processes; mpiexec puts each rank into a process group of its own."""
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
    """Run a command. Each of its processes gets at most `cpu` seconds of processor time."""
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
