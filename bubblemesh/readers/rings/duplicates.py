"""Curves that are twice in a file, as often in drawings: one of them is dropped."""

from collections.abc import Iterable, Sequence

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.geometry.paths import Arc, Ellipse, Ring, Side, as_point
from bubblemesh.geometry.rings import ArcTo, BezierTo, LineTo, Piece, SplineTo, end_of
from bubblemesh.readers.features import CompoundCurve
from bubblemesh.readers.slips import Slips

SAME = 1e-9  # of the drawing's size: points that differ by rounding


def without_copies(curves: Sequence[CompoundCurve]) -> tuple[list[CompoundCurve], Slips]:
    """The curves without copies of earlier ones, in either direction, and the number of copies."""
    if len(curves) < 2:
        return list(curves), Slips()
    stops = np.array([point for curve in curves for point in (curve.start, *map(end_of, curve.pieces))], float)
    tolerance = SAME * float(np.ptp(stops, axis=0).max())
    known: dict[tuple[int, ...], list[CompoundCurve]] = {}
    kept, slips = list[CompoundCurve](), Slips()
    for curve in curves:
        near = known.setdefault(_key(curve, tolerance), [])
        same = next((other for other in near if _same(curve, other, tolerance)), None)
        if same is None:
            near.append(curve)
            kept.append(curve)
        else:
            slips += Slips(copies=1, first=curve.start, labels=_lost(curve.pieces, same.pieces))
    return kept, slips


def without_same_circles(rings: Sequence[Ring]) -> tuple[list[Ring], Slips]:
    """The rings without copies of earlier whole circles and ellipses, and the number of copies."""
    forms = {k: form for k, ring in enumerate(rings) if (form := _form(ring)) is not None}
    if len(forms) < 2:
        return list(rings), Slips()
    numbers = np.array(list(forms.values()))
    reach = np.abs(numbers[:, 2:]).sum(axis=1)[:, None]
    tolerance = SAME * float(np.ptp(np.vstack([numbers[:, :2] - reach, numbers[:, :2] + reach]), axis=0).max())
    known: dict[tuple[float, ...], list[int]] = {}
    copies, slips = set[int](), Slips()
    for k, form in forms.items():
        near = known.setdefault(tuple(np.rint(form / (1000 * tolerance)).tolist()), [])
        same = next((other for other in near if np.allclose(form, forms[other], rtol=0, atol=tolerance)), None)
        if same is None:
            near.append(k)
        else:
            copies.add(k)
            lost = _lost(rings[k].sides, rings[same].sides)
            slips += Slips(copies=1, first=as_point(rings[k].outline[0]), labels=lost)
    return [ring for k, ring in enumerate(rings) if k not in copies], slips


def _lost(dropped: Iterable[Piece | Side], kept: Iterable[Piece | Side]) -> tuple[str, ...]:
    """Labels of what is dropped that nothing of what is kept has."""
    there = {one.label for one in kept}
    return tuple(dict.fromkeys(one.label for one in dropped if one.label is not None and one.label not in there))


def _form(ring: Ring) -> Floats | None:
    """Numbers (5,), all lengths, that are equal for equal circles and ellipses; None for other rings.

    They are the centre and the symmetric matrix R diag(a, b) R^T of the semi-axes, which maps the unit circle to the
    ellipse and does not depend on the axis that is given first.
    """
    match ring.sides[0].curve:
        case Arc(center, radius) if not ring.vertices:
            (a, b), angle = (radius, radius), 0.0
        case Ellipse(center, (a, b), angle):
            pass
        case _:
            return None
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([*center, a * cos**2 + b * sin**2, (a - b) * sin * cos, a * sin**2 + b * cos**2])


def _key(curve: CompoundCurve, tolerance: float) -> tuple[int, ...]:
    """Key that copies have in common: the number of pieces, and both ends to a few digits."""
    grid = 1000 * tolerance or 1.0
    ends = sorted((round(x / grid), round(y / grid)) for x, y in (curve.start, curve.end))
    return len(curve.pieces), *ends[0], *ends[1]


def _same(one: CompoundCurve, other: CompoundCurve, tolerance: float) -> bool:
    """Whether two curves with as many pieces run along each other."""
    (a, middles_of_one), (b, middles_of_other) = _shape(one), _shape(other)
    return any(
        np.allclose(a, stops, rtol=0, atol=tolerance)
        and all(_near(p, q, tolerance) for p, q in zip(middles_of_one, middles, strict=True))
        for stops, middles in ((b, middles_of_other), (b[::-1], middles_of_other[::-1]))
    )


def _near(one: Floats, other: Floats, tolerance: float) -> bool:
    return len(one) == len(other) and any(np.allclose(one, way, rtol=0, atol=tolerance) for way in (other, other[::-1]))


def _shape(curve: CompoundCurve) -> tuple[Floats, list[Floats]]:
    """Ends (k + 1, 2) of the pieces of a curve, and points of each piece that show its course between the ends."""
    stops = np.array([curve.start, *map(end_of, curve.pieces)], float)
    return stops, [_middle(start, piece) for start, piece in zip(stops[:-1], curve.pieces, strict=True)]


def _middle(start: Floats, piece: Piece) -> Floats:
    """Points of a piece that show its course between its ends."""
    match piece:
        case LineTo():
            return np.zeros((0, 2))
        case BezierTo():
            return np.array([piece.first, piece.second], float)
        case SplineTo():
            return np.array([*piece.through[:-1]], float).reshape(-1, 2)
        case ArcTo():
            # The middle of an arc determines its centre and the side on which it lies.
            center, half = np.array(piece.center), (np.array(piece.to) - start) / 2
            radius = np.hypot(*(start - center))
            x, y = half if piece.left else -half
            length = np.hypot(x, y)
            aside = np.array([y, -x]) / length if length > 0 else np.array([1.0, 0.0])
            return (center + radius * aside)[None]
