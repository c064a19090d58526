"""The catalogue of hard cases, one file a family (docs/hard-cases.md).

Every case has a name and asserts a bound that follows from the mathematics; the reason stands where the bound does.
"""

import numpy as np
from hypothesis import HealthCheck, settings

EPS = float(np.finfo(np.float64).eps)
"""Twice the largest relative error of one operation in float64."""

STEADY = settings(derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow])
"""Properties are tried on the same examples every time, however slow the machine is."""
