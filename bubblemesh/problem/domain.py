"""The domain that a case describes: its rings, regions and lines as geometry."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bubblemesh.case import Case
from bubblemesh.case.domain import DomainKeys, FileDomain, InnerKeys
from bubblemesh.errors import GeometryError, Key, about, prefixed
from bubblemesh.geometry import rings
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import InnerPoint, OpenPath, Ring
from bubblemesh.messages import ring_name
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.files import own_files
from bubblemesh.problem.shapes import followed, pieces_of, rings_of, selection_of
from bubblemesh.readers.formats import read_area

DOMAIN = Key(["domain"])


def case_domain(case: Case) -> Domain:
    """The domain of a case's rings, with its regions and what is embedded; errors have the place and what to do."""
    with about(DOMAIN), own_files(case.domain, case.root):
        outer, *holes = domain_rings(case.domain)
        return Domain.of(outer, holes, _inner_parts(case.domain))


def domain_rings(keys: DomainKeys) -> list[Ring]:
    """The outer ring and the holes of a domain; errors of geometry, keys and files name the ring."""
    if isinstance(keys, FileDomain):
        return _rings_of_file(keys)
    found: list[Ring] = []
    paths = [("outer",), *(("holes", number) for number in range(len(keys.holes)))]
    for path, ring in zip(paths, (keys.outer, *keys.holes), strict=True):
        key = Key((*DOMAIN, *path))
        with prefixed(ring_name(len(found))), about(key):
            several = [replace(one, key=key) for one in rings_of(ring)]
            if not found and len(several) > 1:
                raise GeometryError(
                    f"{len(several)} rings are in the file: choose one by feature or layer, or give the file as the "
                    "whole domain"
                )
        found += several
    return found


def _rings_of_file(keys: FileDomain) -> list[Ring]:
    """Outer ring and holes of the area in a file."""
    outer, *holes = read_area(Path(keys.file), selection_of(keys))
    labelled = drawn([outer.labelled(keys.label), *(hole.labelled(keys.hole_label) for hole in holes)], keys)
    return [followed(ring, keys) for ring in labelled]


def _inner_parts(keys: InnerKeys) -> Parts:
    """Regions and what is embedded; errors tell which one it is."""
    return Parts(tuple(_regions(keys)), keys.region, tuple(_lines(keys)), tuple(_points(keys)), keys.periodic)


def _lines(keys: InnerKeys) -> Iterator[OpenPath]:
    made = 0
    for number, line in enumerate(keys.lines):
        key = Key((*DOMAIN, "lines", number))
        with prefixed(f"line {made + 1}"), about(key):
            for path in drawn([rings.open_path(*pieces_of(line), line.label or "")], line):
                made += 1
                yield replace(path, label=path.label or f"line-{made}", key=key)


def _points(keys: InnerKeys) -> Iterator[InnerPoint]:
    made = 0
    for number, point in enumerate(keys.points):
        key = Key((*DOMAIN, "points", number))
        with about(key):
            for copy in drawn([InnerPoint(point.at, point.label or "", key)], point):
                made += 1
                yield replace(copy, label=copy.label or f"point-{made}")


def _regions(keys: InnerKeys) -> Iterator[Region]:
    for number, model in enumerate(keys.regions):
        key = Key((*DOMAIN, "regions", number))
        with prefixed(f"region {model.name!r}"), about(key):
            found = [replace(ring, key=key) for ring in drawn(rings_of(model.ring), model)]
        rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
        yield from (Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in found)
