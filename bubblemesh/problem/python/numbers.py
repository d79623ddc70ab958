"""Numbers among the arguments of Python programs."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from bubblemesh.arrays import unmasked


def plain_value(value: Any) -> Any:
    """The value with Python's numbers and lists in place of NumPy's, also within mappings and lists."""
    if isinstance(value, Mapping):
        return {key: plain_value(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain_value(each) for each in value]
    return unmasked(value).tolist() if isinstance(value, np.ndarray | np.generic) else value
