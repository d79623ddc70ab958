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
