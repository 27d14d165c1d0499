# SPDX-License-Identifier: BSD-3-Clause
"""python -m scree_bench, the same as scree-bench."""
from .command import run

run()
