"""Grids of numbers with places: NetCDF, GeoTIFF, ESRI's ASCII grids (.asc), and regular lists of x, y, z (.xyz).

Only the part around a domain is read; if it has too many pixels, only each second, third and so on in each direction.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bubblemesh.arrays import Floats, Integers
from bubblemesh.errors import BubblemeshError, CaseError, FileError
from bubblemesh.files import opened, read_bytes
from bubblemesh.messages import LONGEST_REASON, cause, shown
from bubblemesh.process.shared import warnings_are
from bubblemesh.readers.grids.netcdf import Variable, netcdf
from bubblemesh.readers.selection import one_of
from bubblemesh.readers.tables import read_columns

MOST_PIXELS = 4_000_000  # kept of a grid
AROUND = 2  # pixels beyond the box
ACROSS = ("x", "lon", "easting")  # beginnings of names of dimensions from west to east
TURN = 360.0  # degrees

Box = tuple[float, float, float, float]


class Grid(NamedTuple):
    """Values with the coordinates of their columns and rows; NaN for missing values."""

    name: str
    x: Floats  # (c,)
    y: Floats  # (r,)
    values: Floats  # (r, c)
    step: int = 1  # one of so many pixels in each direction was read


def read_grid(path: Path, name: str | None, box: Box | None) -> Grid:
    """The grid ``name`` of a file, or the only one, around a box (x0, y0, x1, y1), or all of it.

    FileError if the file cannot be read; CaseError if a name is needed, or is unknown or not that of a grid, or if
    nothing of the grid is in the box.
    """
    found = GRIDS[path.suffix.lower()](path, name, box)
    if found.values.size == 0 or found.values.shape != (len(found.y), len(found.x)):
        raise CaseError(f"{found.name} is no grid with rows and columns")
    return found


def system_of(path: Path) -> str | None:
    """The coordinate reference system of a grid as well-known text, if the file has it; FileError as in `read_grid`."""
    if path.suffix.lower() not in GEOTIFF:
        return None
    with _geotiff(path) as data:
        return data.crs.to_wkt() if data.crs else None


def is_grid(path: Path) -> bool:
    """Whether a file, by its ending, is one of grids with places."""
    return path.suffix.lower() in GRIDS


def filled_from_nearest(values: Floats) -> tuple[Floats, float]:
    """The values (r, c), with missing ones replaced by that of the nearest pixel, and the share of missing ones.

    CaseError if all are missing.
    """
    missing = ~np.isfinite(values)
    share = float(missing.mean())
    if share == 0:
        return values, 0.0
    if share == 1:
        raise CaseError("has no values around the domain: all of them are missing")
    from scipy.ndimage import distance_transform_edt

    rows, columns = distance_transform_edt(missing, return_distances=False, return_indices=True)
    return values[rows, columns], share


class _Window(NamedTuple):
    """Rows or columns to read from a grid, as runs, and the coordinates of all of them."""

    runs: list[slice]
    at: Floats


def _windows(x: Floats, y: Floats, box: Box | None, averaged: bool = False) -> tuple[_Window, _Window, int]:
    """Windows of the columns and rows around a box, and the step: one of so many pixels in each direction is kept.

    The windows have the kept ones only, unless means are ``averaged`` over all. CaseError if a window is empty.
    """
    x0, y0, x1, y1 = (-np.inf, -np.inf, np.inf, np.inf) if box is None else box
    for what, at in (("x", x), ("y", y)):
        steps = np.diff(at)
        if not ((steps > 0).all() or (steps < 0).all()):
            raise CaseError(f"its {what} coordinates do not go one way")
    x = _turned(x, x0, x1)
    high, wide = int(((y >= y0) & (y <= y1)).sum()), int(((x >= x0) & (x <= x1)).sum())
    step = max(math.ceil(math.sqrt(high * wide / MOST_PIXELS)), 1)
    every = 1 if averaged else step
    return _window(x, x0, x1, every, "x"), _window(y, y0, y1, every, "y"), step


def _window(at: Floats, low: float, high: float, step: int, what: str) -> _Window:
    """Window of the coordinates (n,) between two values, with some more on both sides; CaseError if it is empty."""
    order = np.argsort(at, kind="stable")
    first, last = np.searchsorted(at[order], [low, high]).tolist()
    if first == len(at) or last == 0:
        has, wants = f"{at.min():.6g} to {at.max():.6g}", f"{low:.6g} to {high:.6g}"
        raise CaseError(f"its {what} coordinates are {has}, those of the domain {wants}: they do not meet")
    chosen = order[max(first - AROUND * step, 0) : last + AROUND * step : step]
    return _Window(_runs(chosen), at[chosen])


def _turned(at: Floats, low: float, high: float) -> Floats:
    """Longitudes (n,) plus the turns that bring them next to the domain, if more of them are inside then."""
    if not np.isfinite([low, high]).all() or np.abs([at.min(), at.max(), low, high]).max() > TURN:
        return at
    turned = at + TURN * np.round(((low + high) / 2 - at) / TURN)
    inside, other = (np.count_nonzero((each >= low) & (each <= high)) for each in (at, turned))
    return turned if other > inside and len(np.unique(turned)) == len(at) else at


def _runs(chosen: Integers) -> list[slice]:
    """Slices that yield the numbers in their order, one for each stretch with equal steps."""
    steps = np.diff(chosen)
    usual = int(np.bincount(steps - steps.min()).argmax() + steps.min()) if len(steps) else 1
    parts = np.split(chosen, np.flatnonzero(steps != usual) + 1)
    return [_slice(int(part[0]), int(part[-1]), usual) for part in parts]


def _slice(first: int, last: int, step: int) -> slice:
    end = last + (1 if step > 0 else -1)
    return slice(first, None if end < 0 else end, step)


def _read_netcdf(path: Path, name: str | None, box: Box | None) -> Grid:
    """Grid of a NetCDF file, with the arguments and errors of `read_grid`."""
    with netcdf(path) as variables:
        known = [key for key, each in variables.items() if len(each.shape) >= 2 and each.kind in "iuf"]
        chosen = one_of(known, name, "grid")
        variable = variables[chosen]
        places = [_coordinates(variables, chosen, each) for each in variable.dimensions[-2:]]
        turned = variable.dimensions[-2].lower().startswith(ACROSS)
        (x, y) = places if turned else places[::-1]
        columns, rows, step = _windows(x, y, box)
        before = [slice(-1, None)] * (len(variable.shape) - 2)  # the last time, and the first levels

        def part(row: slice, column: slice) -> Floats:
            # Steps are applied after reading, since files cannot be read backwards.
            window = [column, row] if turned else [row, column]
            ahead = [_ahead(each, n) for each, n in zip(window, variable.shape[-2:], strict=True)]
            found = variable.numbers(*before, *(each for each, _ in ahead)).reshape(
                [len(range(*each.indices(n))) for (each, _), n in zip(ahead, variable.shape[-2:], strict=True)]
            )[tuple(slice(None, None, sign) for _, sign in ahead)]
            return found.T if turned else found

        values = np.vstack([np.hstack([part(row, column) for column in columns.runs]) for row in rows.runs])
    return Grid(chosen, columns.at, rows.at, values, step=step)


def _ahead(run: slice, size: int) -> tuple[slice, int]:
    """Ascending run of the same numbers, and the step, 1 or -1, that restores their order."""
    numbers = range(*run.indices(size))
    if numbers.step > 0:
        return run, 1
    return slice(numbers[-1], numbers[0] + 1, -numbers.step), -1


def _coordinates(variables: Mapping[str, Variable], name: str, dimension: str) -> Floats:
    found = variables.get(dimension)
    if found is None or len(found.shape) != 1 or found.kind not in "iuf":
        raise CaseError(
            f"{name} has no coordinates for its dimension {dimension!r}: write them as a variable of that name"
        )
    return found.numbers()


@contextmanager
def _geotiff(path: Path) -> Iterator[Any]:
    """The open file; FileError if it cannot be read, and for any error of the library within the block."""
    try:
        import rasterio
    except ModuleNotFoundError:
        raise FileError('rasterio is needed to read it: pip install "bubblemesh[geo]"') from None
    safe = {"GDAL_PAM_ENABLED": "NO", "GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR", "PROJ_NETWORK": "OFF"}
    try:
        with ExitStack() as stack:
            stack.enter_context(warnings_are("ignore"))
            stream = stack.enter_context(opened(path, limited=False))
            if stream.peek(4)[:4] not in (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+"):
                raise FileError("is no TIFF")
            stack.enter_context(rasterio.Env(**safe))
            yield stack.enter_context(rasterio.open(path, driver="GTiff"))
    except (BubblemeshError, MemoryError):
        raise
    except Exception as error:  # damaged files fail in any way
        raise FileError(f"is no GeoTIFF that can be read: {cause(error, LONGEST_REASON)}") from error


def _read_geotiff(path: Path, name: str | None, box: Box | None) -> Grid:
    """Grid of a GeoTIFF, with the arguments and errors of `read_grid`."""
    with _geotiff(path) as data:
        from rasterio.enums import Resampling
        from rasterio.windows import Window

        across = data.transform
        if across.b or across.d or across.is_identity:
            raise CaseError("has no place, or is turned: give it one, as by gdalwarp")
        x = across.c + across.a * (np.arange(data.width) + 0.5)
        y = across.f + across.e * (np.arange(data.height) + 0.5)
        band, called = _band(data, name, path.stem)
        columns, rows, step = _windows(x, y, box, averaged=True)
        if len(columns.runs) > 1:
            raise CaseError("the domain crosses its eastern edge: turn it there, as by gdalwarp -te")
        (left, width), (low, height) = (
            _extent(part.runs[0], n) for part, n in ((columns, data.width), (rows, data.height))
        )
        shape = max(height // step, 1), max(width // step, 1)
        window = Window(left, low, width, height)
        found = data.read(band, window=window, out_shape=shape, masked=True, resampling=Resampling.average)
        values = np.ma.filled(found.astype(float), np.nan) * data.scales[band - 1] + data.offsets[band - 1]
        # The mean of several pixels is placed in their middle.
        x = np.interp(_middles(width, shape[1]), np.arange(width), np.sort(columns.at))
        y = np.interp(_middles(height, shape[0]), np.arange(height), np.sort(rows.at))
        x, y = (each if positive else each[::-1] for each, positive in ((x, across.a > 0), (y, across.e > 0)))
    return Grid(called, x, y, values, step)


def _band(data: Any, name: str | None, stem: str) -> tuple[int, str]:
    """Number and name of a GeoTIFF's band: the only band, whatever the name, or the one that is asked for.

    Bands are known by their numbers (band_2), as expressions need them, and by their own names. Masks (alpha) are left
    out. CaseError if a name is needed or unknown, or the values are not real numbers.
    """
    numbered = {f"band_{number}": number for number in data.indexes}
    named = [
        one if one and data.descriptions.count(one) == 1 else key
        for one, key in zip(data.descriptions, numbered, strict=True)
    ]
    masks = [role.name == "alpha" for role in data.colorinterp]
    bands = {one: number for one, number, mask in zip(named, data.indexes, masks, strict=True) if not mask}
    if name in numbered:
        number, called = numbered[name], name
    elif len(bands) == 1:
        (number,), called = bands.values(), stem if name is None else name
    else:
        called = one_of([*bands], name, "grid")
        number = bands[called]
    kind = data.dtypes[number - 1]
    if kind.startswith("complex"):
        raise CaseError(f"{called} does not hold real numbers (found {kind})")
    return number, called


def _extent(run: slice, size: int) -> tuple[int, int]:
    """The first of a run of pixels, and their number."""
    numbers = range(*run.indices(size))
    return min(numbers), len(numbers)


def _middles(size: int, count: int) -> Floats:
    """Middles (count,) of equal parts of ``size`` pixels, in pixels."""
    return (np.arange(count) + 0.5) * size / count - 0.5


HEADER = ("ncols", "nrows", "xllcorner", "yllcorner", "xllcenter", "yllcenter", "cellsize", "dx", "dy", "nodata_value")
NO_DATA = -9999.0  # Esri's default, if the header gives no other value


def _read_ascii(path: Path, name: str | None, box: Box | None) -> Grid:
    """Grid of an ESRI ASCII file, with the arguments and errors of `read_grid`."""
    content = read_bytes(path)
    head: dict[str, float] = {}
    place = 0
    for _ in range(len(HEADER)):
        line, end, _ = content[place : place + 200].partition(b"\n")
        words = line.split()
        if len(words) != 2 or words[0].lower().decode("latin-1") not in HEADER:
            break
        head[words[0].lower().decode("latin-1")] = _number(words[1])
        place += len(line) + len(end)
    if not {"ncols", "nrows"} <= head.keys() or not ({"cellsize"} <= head.keys() or {"dx", "dy"} <= head.keys()):
        raise FileError("does not begin with ncols, nrows and cellsize, or dx and dy: it is no ASCII grid")
    _check_header(head)
    columns, rows = int(head["ncols"]), int(head["nrows"])
    dx, dy = (head[key] if key in head else head["cellsize"] for key in ("dx", "dy"))
    values = _numbers(content[place:])
    if len(values) != columns * rows:
        raise FileError(f"has {len(values):,} values where {rows} rows of {columns} are told")
    values = values.reshape(rows, columns)
    values[values == head.get("nodata_value", NO_DATA)] = np.nan
    x0 = head["xllcenter"] if "xllcenter" in head else head.get("xllcorner", 0.0) + dx / 2
    y0 = head["yllcenter"] if "yllcenter" in head else head.get("yllcorner", 0.0) + dy / 2
    x: Floats = x0 + dx * np.arange(columns, dtype=float)
    y: Floats = y0 + dy * np.arange(rows, dtype=float)[::-1]
    return _cut(Grid(path.stem if name is None else name, x, y, values), box)


def _check_header(head: Mapping[str, float]) -> None:
    for key, value in head.items():
        if key != "nodata_value" and not math.isfinite(value):
            raise FileError(f"{key}: must be a finite number (found {value:g})")
    for key in ("ncols", "nrows"):
        if head[key] < 1 or not head[key].is_integer():
            raise FileError(f"{key}: must be a whole number, at least 1 (found {head[key]:g})")
    for key in ("cellsize", "dx", "dy"):
        if head.get(key, 1) <= 0:
            raise FileError(f"{key}: must be positive (found {head[key]:g})")


def _number(word: bytes) -> float:
    try:
        return float(word)
    except ValueError:
        raise FileError(f"has {shown(word.decode('latin-1'), 40)!r} where a number is to be") from None


def _numbers(content: bytes) -> Floats:
    """All numbers (n,) of a text."""
    try:
        with warnings_are("error"):
            return np.fromstring(content, sep=" ")
    except (ValueError, DeprecationWarning):
        raise FileError("has words where numbers are to be") from None


def _read_xyz(path: Path, name: str | None, box: Box | None) -> Grid:
    points = read_columns(path, ("x", "y", "z"))
    x, column = np.unique(points[:, 0], return_inverse=True)
    y, row = np.unique(points[:, 1], return_inverse=True)
    if len(x) * len(y) > 4 * len(points):
        raise CaseError("is no grid: its points are not in rows and columns: make one of them, as by gdal_grid")
    values = np.full((len(y), len(x)), np.nan)
    values[row, column] = points[:, 2]
    return _cut(Grid(path.stem if name is None else name, x, y, values), box)


def _cut(grid: Grid, box: Box | None) -> Grid:
    """The part of a grid around a box."""
    columns, rows, step = _windows(grid.x, grid.y, box)
    chosen: NDArray[Any] = np.vstack(
        [np.hstack([grid.values[row, column] for column in columns.runs]) for row in rows.runs]
    )
    return grid._replace(x=columns.at, y=rows.at, values=chosen, step=step)


GEOTIFF = (".tif", ".tiff")
GRIDS: Mapping[str, Callable[[Path, str | None, Box | None], Grid]] = {
    ".nc": _read_netcdf,
    ".grd": _read_netcdf,  # of GMT
    **dict.fromkeys(GEOTIFF, _read_geotiff),
    ".asc": _read_ascii,
    ".xyz": _read_xyz,
}
