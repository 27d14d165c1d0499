# SPDX-License-Identifier: BSD-3-Clause
"""Types of arrays in annotations; docstrings give shapes and units."""
from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]     # of numbers of any type
Bools = NDArray[np.bool_]
