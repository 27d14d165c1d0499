# SPDX-License-Identifier: BSD-3-Clause
"""Speed of Scree on this machine, relative to the speed at which the machine copies memory: the command scree-bench.

Only the standard library is needed.
"""
__version__ = "0.1.0"
