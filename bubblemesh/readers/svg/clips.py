"""Clips of an SVG drawing: the areas within the shapes of a clipPath."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from bubblemesh.geometry.arrangement.overlay import overlaid
from bubblemesh.geometry.arrangement.winding import FillRule
from bubblemesh.geometry.nesting import nested
from bubblemesh.geometry.paths import Area
from bubblemesh.geometry.rings import LineTo
from bubblemesh.readers.features import Clip, CompoundCurve
from bubblemesh.readers.svg.fill import FLAT_SUBPATH, area_of, filled


class Stencil(NamedTuple):
    """A shape of a clipPath: its curves, its fill rule, and its own clips."""

    curves: Sequence[CompoundCurve]
    rule: FillRule
    clips: tuple[Clip, ...]


def clip_of(stencils: Sequence[Stencil]) -> Clip:
    """The part of the plane that any of the stencils encloses.

    GeometryError if their curves are next to each other, but not the same.
    """
    operands = [areas for stencil in stencils if (areas := _areas(stencil))]
    if not operands:
        return Clip(())
    return Clip(tuple(operands[0] if len(operands) == 1 else overlaid("union", operands)))


def _areas(stencil: Stencil) -> list[Area]:
    """Areas that one stencil encloses."""
    loops = [loop for curve in stencil.curves if area_of(loop := _closed(curve)) > FLAT_SUBPATH]
    if not loops:
        return []
    found = filled(loops, stencil.rule)
    made = [*found.rings, *(loop.ring for loop in found.loops)]
    areas = nested([Area(ring) for ring in made])
    for clip in stencil.clips:
        areas = overlaid("intersection", [areas, clip.areas]) if areas and clip.areas else []
    return areas


def _closed(curve: CompoundCurve) -> CompoundCurve:
    """The curve, closed by a straight line if it is open."""
    return curve if curve.start == curve.end else replace(curve, pieces=(*curve.pieces, LineTo(curve.start)))
