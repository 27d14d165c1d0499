# SPDX-License-Identifier: BSD-3-Clause
"""Where scripts of this folder that are no tests find the modules of the tests; they import it first.

For tests test/pytest.ini says the same.
"""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
TEST = HERE.parent

sys.path[:0] = [str(place) for place in (TEST / "support", HERE / "crack", HERE / "shocks", HERE / "taylor",
                                         TEST.parent / "python/src")]
