"""A finite element solution on a triangle mesh, and the check that this is one of the domain."""

from pathlib import Path

import numpy as np
import shapely

from bubblemesh.arrays import Booleans, Floats, Integers
from bubblemesh.errors import CaseError, prefixed
from bubblemesh.geometry.domain import Domain
from bubblemesh.meshes.checks import array_of, finite, indices
from bubblemesh.meshes.edges import unique_edges
from bubblemesh.meshes.quality import signed_areas
from bubblemesh.messages import place, two_places
from bubblemesh.process.watchdog import enter
from bubblemesh.records import record

ASIDE = 0.1  # edge lengths that a node may be off the domain or its boundary
VALUE_ROUNDING = 16 * float(np.finfo(float).eps)  # of values, in terms of the largest one
FEW_DIGITS = range(4, 9)  # that files have of coordinates
EXACT = 1e-6  # of the last digit: rounding of the numbers that files have
FLATTENED = 20  # times what coordinates are rounded to: longer triangles are not made flat by that
MISMATCH = 0.15  # area beside a boundary edge in terms of its length's square: more than under an arc of 90 degrees


@record(eq=False)
class Solution:
    """A solution of first order; made by `Solution.of`.

    Attributes
    ----------
    points : (n, 2)
    triangles : (t, 3)
        Counter-clockwise.
    values : (n, k)
        Its k components at the points.
    name : str
    """

    points: Floats
    triangles: Integers
    values: Floats
    name: str = "u"

    def __post_init__(self) -> None:
        points, triangles, values = found = [np.shape(array) for array in (self.points, self.triangles, self.values)]
        if found != [(*points[:1], 2), (*triangles[:1], 3), (*points[:1], *values[-1:])]:
            counts = ", ".join(map(str, found))
            raise CaseError(
                "Solution: points, triangles and values must have the shapes (n, 2), (t, 3) and (n, k): make it by "
                f"Solution.of (found {counts})"
            )

    @property
    def unit(self) -> float:
        """Power of two near the largest value, in terms of which squares are neither huge nor tiny."""
        _, exponent = np.frexp(np.abs(self.values).max())
        return float(np.ldexp(1.0, int(exponent) - 1))

    @property
    def constant(self) -> bool:
        """Whether each component is the same at all points, but for rounding."""
        values = self.values / self.unit
        return bool((np.ptp(values, axis=0) <= VALUE_ROUNDING * np.abs(values).max(axis=0)).all())

    @classmethod
    def of(cls, points: Floats, triangles: Integers, values: Floats, name: str = "u") -> "Solution":
        """Solution with real or complex values (n,) or (n, k) at points (n, 2) of triangles (t, 3) of any orientation.

        Points in the same place become one where their values agree, as where each triangle has points of its own.

        Raises
        ------
        CaseError
            If shapes or kinds of numbers do not fit, a value is no number, a triangle has no area, or the values jump
            nearly everywhere; with its place.
        """
        # Imported here since few programs make a solution.
        from bubblemesh.meshfiles.merging import joined

        points = finite(points, "points", ("n", 2))
        n = len(points)
        triangles = indices(triangles, "triangles", n, "node", ("t", 3))
        if len(triangles) == 0 or len(np.unique(triangles)) < n:
            raise CaseError(f"triangles: must use all of the nodes 0 to {n - 1}")
        values = array_of(values, "values", "numbers", (n,), (n, "k"))
        if values.size == 0:
            raise CaseError("values: must be at least one number for each node (found none)")
        values = values.reshape(len(values), -1)
        values = np.hstack([values.real, values.imag]) if np.iscomplexobj(values) else values.astype(float)
        bad = np.flatnonzero(~np.isfinite(values).all(axis=1))
        if len(bad):
            raise CaseError(f"{name} is not a number at node {bad[0]} (counted from 0), at {place(points[bad[0]])}")
        points, triangles, values = joined(points, triangles, values, name, float(np.finfo(float).eps))
        areas = signed_areas(points, triangles)
        flat = np.flatnonzero(areas == 0)
        if len(flat):
            corners = points[triangles[flat[0]]]
            raise CaseError(f"the triangle around {place(corners.mean(axis=0))} has no area{_rounded(points, corners)}")
        return cls(points, np.where(areas[:, None] < 0, triangles[:, ::-1], triangles), values, name)


def _rounded(points: Floats, corners: Floats) -> str:
    """What made a triangle (3, 2) flat and what to do, if all coordinates (n, 2) are rounded and it is as small."""
    steps = {}
    with np.errstate(over="ignore"):  # coordinates that are too large for it
        single = points.astype(np.float32)
    if (single == points).all():
        steps["single precision"] = float(np.spacing(np.abs(single).max()))
    for digits in FEW_DIGITS:
        last = 10.0 ** (np.floor(np.log10(np.where(points == 0, 1, np.abs(points)))) - digits + 1)
        if np.allclose(points / last, np.rint(points / last), rtol=0, atol=EXACT):
            steps[f"{digits} digits"] = float(last.max())
            break
    how, step = max(steps.items(), key=lambda row: row[1], default=("", 0.0))
    if np.ptp(corners, axis=0).max() > FLATTENED * step:
        return ""
    return (
        f": coordinates in the file are rounded to {step:.2g} ({how}), about as much as its edges are long; save them "
        "in double precision, or `move` the domain to the origin before it is meshed and solved"
    )


def read_solution(path: Path, field: str | None, chosen_by: str = "field") -> tuple[Solution, list[str]]:
    """Solution in a file, by the name of its data if there is more, with notes on what was chosen.

    Users give the name by ``chosen_by``. Errors, which have the file, are those of `read_nodal_field` and of
    `Solution.of`.
    """
    # Imported here since few programs read a solution.
    from bubblemesh.meshfiles.fields import read_nodal_field

    enter("estimate")
    read = read_nodal_field(path, field, chosen_by)
    with prefixed(path):
        found = Solution.of(read.points, read.triangles, read.values, read.name)
    return found, [f"{path}: {note}" for note in read.notes]


def require_coverage(domain: Domain, points: Floats, triangles: Integers) -> None:
    """Check that triangles (t, 3) cover the domain and nothing else; a CaseError names the place where they do not."""
    pairs, count = unique_edges(triangles)
    if count.max() > 2:
        k = int(count.argmax())
        first, second = two_places(*points[pairs[k]])
        raise CaseError(
            f"the mesh of the solution is no plane mesh: {count[k]} triangles meet at the edge from {first} to {second}"
        )
    lengths = np.hypot(*(points[pairs[:, 1]] - points[pairs[:, 0]]).T)
    shortest = np.full(len(points), np.inf)
    np.minimum.at(shortest, pairs, lengths[:, None])
    rim = np.unique(pairs[count == 1])
    distance = domain.signed_distance(points)
    _require_inside(points, distance, ASIDE * shortest)
    _require_rim(domain, points[rim], distance[rim], ASIDE * shortest[rim])
    covered = float(np.abs(signed_areas(points, triangles)).sum())
    whole = domain.polygon.area
    if abs(covered - whole) > MISMATCH * (lengths[count == 1] ** 2).sum():
        raise CaseError(
            f"the mesh of the solution has an area of {covered:.6g}, the domain one of {whole:.6g}: it has to be a "
            "mesh of the same domain"
        )


def _require_inside(points: Floats, distance: Floats, allowed: Floats) -> None:
    outside = np.flatnonzero(distance < -allowed)
    if len(outside):
        k = outside[distance[outside].argmin()]
        more = f", and {len(outside) - 1} more nodes are outside" if len(outside) > 1 else ""
        raise CaseError(
            f"the mesh of the solution leaves the domain: its node at {place(points[k])} is {-distance[k]:.3g} "
            f"outside{more}: it has to be a mesh of the same domain"
        )


def _require_rim(domain: Domain, points: Floats, distance: Floats, allowed: Floats) -> None:
    """Check that the boundary nodes of the mesh are on that of the domain, or on a line inside it."""
    inner = np.flatnonzero(distance > allowed)
    inner = inner[~_on_lines(domain, points[inner], allowed[inner])]
    if len(inner):
        k = inner[distance[inner].argmax()]
        raise CaseError(
            f"the mesh of the solution does not cover the domain: it ends at {place(points[k])}, {distance[k]:.3g} "
            "inside: it has to be a mesh of the same domain"
        )


def _on_lines(domain: Domain, points: Floats, allowed: Floats) -> Booleans:
    """Mask (m,) of the points (m, 2) that are as near as allowed (m,) to an embedded line or an interface."""
    boundary = domain.boundary
    piece, s, step = boundary.stations()
    mine = boundary.inner[piece]
    ends = [boundary.points(piece[mine], at) for at in (s[mine], s[mine] + step[mine])]
    near = np.zeros(len(points), bool)
    tree = shapely.STRtree(shapely.linestrings(np.stack(ends, axis=1)))
    near[tree.query(shapely.points(points), predicate="dwithin", distance=allowed)[0]] = True
    return near
