# SPDX-License-Identifier: BSD-3-Clause
"""python -m scree_post, the same as scree-post."""
from .command import run

run()
