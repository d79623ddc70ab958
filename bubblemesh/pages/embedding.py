"""Arrays inside of a page: bytes of one rank after the other, compressed, in letters of base64."""

import base64
import json
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.meshfiles.report_json import json_ready
from bubblemesh.pages.markup import Markup, tag

FINEST = 2**32 - 1


def array_block(name: str, columns: NDArray[Any]) -> Markup:
    """Embed an array of unsigned integers (n,) or (n, k), column by column.

    Bytes of the same rank resemble each other, so that they are compressed to far less when they stand together.
    """
    flat = np.ascontiguousarray(columns.T).reshape(-1)
    planes = flat.astype(flat.dtype.newbyteorder("<")).view(np.uint8).reshape(len(flat), -1).T
    text = base64.b64encode(zlib.compress(planes.tobytes(), 6)).decode()
    return tag("script", Markup(text), type="text/plain", id=name, data_width=flat.dtype.itemsize)


def json_block(name: str, data: Any) -> Markup:
    """Embed data as JSON; no text in it can end the element."""
    text = json.dumps(json_ready(data), ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return tag("script", Markup(text.replace("<", "\\u003c")), type="application/json", id=name)


def fixed_point(values: Floats, low: float, high: float, kind: type = np.uint32) -> NDArray[Any]:
    """Values as unsigned integers of a type, 0 for ``low`` and the largest of the type for ``high``."""
    largest = np.iinfo(kind).max
    return np.round(np.clip((values - low) / (high - low), 0, 1) * largest).astype(kind)


def relative(triangles: Integers) -> NDArray[np.uint32]:
    """Nodes of triangles (t, 3) as small numbers: steps of the first node, and how far the others are from it.

    Signs are folded into the lowest bit: 0, -1, 1, -2, ... become 0, 1, 2, 3, ...
    """
    first = triangles[:, 0]
    steps = np.column_stack([np.diff(first, prepend=0), triangles[:, 1] - first, triangles[:, 2] - first])
    steps = steps.astype(np.int64)
    return np.where(steps < 0, -2 * steps - 1, 2 * steps).astype(np.uint32)
