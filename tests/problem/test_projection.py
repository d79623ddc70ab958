"""The table of the keys of a domain that give coordinates, of which its projection is made."""

from typing import get_args, get_origin, get_type_hints

import pytest

from bubblemesh.case.domain import DomainKeys, RegionSeed, ShoreDomain
from bubblemesh.case.drawing import DrawnKeys
from bubblemesh.case.fields import InputFile, Number
from bubblemesh.case.geometry_files import SelectedFile
from bubblemesh.case.key_homes import models_in
from bubblemesh.case.lines_and_points import EmbeddedPoint
from bubblemesh.case.shapes import CircleRing, EllipseRing, PathLine, PolygonRing, RectangleRing
from bubblemesh.problem.projection import GIVEN


def holds_coordinates(kind):
    """Whether a type is the name of a file, or has lists of numbers in it, as points are."""
    inner = get_args(kind)
    listed = get_origin(kind) is tuple and Number in inner
    return listed or kind == InputFile or any(map(holds_coordinates, inner))


def forgotten():
    """Keys with coordinates of models of a domain that have no row in the table, nor are in one that has."""
    models, missing = [model for _, model in models_in(DomainKeys)], set()
    for model in models:  # more are added to it
        if any(kind in GIVEN for kind in model.__mro__):
            continue
        hints = get_type_hints(model, include_extras=True)
        for name in model.model_fields.keys() - DrawnKeys.model_fields.keys():  # those move what has been projected
            if holds_coordinates(hints[name]):
                missing.add(f"{model.__name__}.{name}")
            models += [inner for _, inner in models_in(hints[name]) if inner not in models]
    return missing


def test_no_key_with_coordinates_is_forgotten():
    assert forgotten() == set()


@pytest.mark.parametrize(
    ("model", "keys"),
    [
        (RectangleRing, {"RectangleRing.rectangle"}),
        (PolygonRing, {"PolygonRing.polygon"}),
        (CircleRing, {"CircleKeys.center"}),
        (EllipseRing, {"EllipseKeys.center"}),
        (PathLine, {"PathRing.path", "EmbeddedLine.path", "LinePiece.to", "ArcKeys.to"}),
        (EmbeddedPoint, {"EmbeddedPoint.at"}),
        (RegionSeed, {"RegionSeed.at"}),
        (SelectedFile, {"FileRing.file", "FileDomain.file"}),
        (ShoreDomain, {"ShoreDomain.box", "ShorelineKeys.file"}),
    ],
)
def test_what_has_no_row_is_told(model, keys, monkeypatch):
    monkeypatch.delitem(GIVEN, model)
    assert forgotten() >= keys
