# SPDX-License-Identifier: BSD-3-Clause
"""Run a command and print the processor time that it and its children spent, as a line COST.

    python -S -E cost.py COMMAND [ARGUMENT ...]

The exit code is that of the command. Processor time depends less on the load of the machine than elapsed time;
scripts/run_tests.py --record writes it into test/costs.csv. Tests in Python print the line themselves (conftest.py).
"""

import os
import sys


def line(*usages):
    """The line that scripts/run_tests.py reads."""
    return f"COST     {sum(usage.ru_utime + usage.ru_stime for usage in usages):.2f}"


def main(command):
    """Run the command. Processes for which it waits are included."""
    child = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(child, 0)
    print(line(usage), flush=True)
    return os.WEXITSTATUS(status) if os.WIFEXITED(status) else 128 + os.WTERMSIG(status)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
