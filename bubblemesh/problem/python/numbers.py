"""Numbers among the arguments of Python programs."""

from typing import Any

import numpy as np


def is_whole(value: Any, least: int) -> bool:
    """Whether a value is a whole number, of Python or NumPy, that is not below ``least``."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= least)


def is_real(value: Any) -> bool:
    """Whether a value is a number, of Python or NumPy, and no truth value."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
