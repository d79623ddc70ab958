"""Numbers among the arguments of Python programs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import unmasked


def plain(value: Any) -> Any:
    """The value with Python's numbers and lists in place of NumPy's, also within mappings and lists."""
    if isinstance(value, Mapping):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain(each) for each in value]
    return unmasked(value).tolist() if isinstance(value, np.ndarray | np.generic) else value


def is_whole(value: Any, least: int) -> bool:
    """Whether a value is a whole number, of Python or NumPy, that is not below ``least``."""
    return isinstance(value, int | np.integer) and not isinstance(value, bool) and bool(value >= least)


def is_real(value: Any) -> bool:
    """Whether a value is a number, of Python or NumPy, and no truth value."""
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
