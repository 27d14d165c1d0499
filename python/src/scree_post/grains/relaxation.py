# SPDX-License-Identifier: BSD-3-Clause
"""Closed solution of the relaxation law (Y.15) and (Y.16) of doc/theory/strength.md in simple shear.

With a = (s_xx - s_yy)/2, b = s_xy and z = a + i b the law is z' = -(1/tau + i rate) z + i G rate, so z tends
exponentially to i G rate/(1/tau + i rate): b = G W/(1 + W^2) and N1/(2 b) = W with W = tau rate. At rest with gamma_c
alone z is constant.
"""
from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scree.arrays import Array


def shear_modulus(stress: float, contact_strain: float) -> float:
    """G [Pa] with which the steady shear stress is the given one."""
    return stress * (1.0 + contact_strain ** 2) / contact_strain


def follow(start: complex, rate: float, times: Array, shear: float, contact_strain: float,
           slow_time: float = np.inf) -> Array:
    """z at times since the start of a stage of constant shear rate [Pa]."""
    times = np.asarray(times, dtype=float)
    decay = 1.0 / slow_time + abs(rate) / contact_strain
    if decay == 0.0:
        return np.full(times.shape, start, dtype=complex)
    power = decay + 1j * rate
    end = 1j * shear * rate / power
    return end + (start - end) * np.exp(-power * times)
