"""The report of a run as JSON text."""

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import PurePath
from typing import Any

import numpy as np


def json_text(report: Mapping[str, Any]) -> str:
    """Return the report as JSON text, keys in the order given, numbers at full precision."""
    return json.dumps(json_ready(report), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def json_ready(value: Any) -> Any:
    """Turn NumPy values, records, paths and tuples into what JSON knows; NaN and infinity become None.

    Raises
    ------
    TypeError
        For a value that JSON has no form for.
    """
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, (np.generic, np.ndarray)):
        # A 0-dimensional array and a scalar of a subclass of float both become a Python number here.
        return json_ready(value.tolist())
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, PurePath):
        return str(value)
    if isinstance(value, Mapping):
        return {str(key): json_ready(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [json_ready(item) for item in value]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: json_ready(getattr(value, field.name)) for field in dataclasses.fields(value)}
    raise TypeError(f"a report cannot hold {value!r}")
