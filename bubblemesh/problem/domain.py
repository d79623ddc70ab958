"""The domain that a case describes: its rings, regions and lines as geometry."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bubblemesh.case import Case
from bubblemesh.case.domain import DomainKeys, FileDomain, InnerKeys
from bubblemesh.errors import GeometryError, Key, about, prefixed
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import Ring
from bubblemesh.messages import ring_name
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.embedded import lines_of, points_of
from bubblemesh.problem.files import own_files
from bubblemesh.problem.shapes import followed, rings_of, selection_of
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
    points, notes = points_of(keys)
    return Parts(tuple(_regions(keys)), keys.region, tuple(lines_of(keys)), tuple(points), keys.periodic, notes)


def _regions(keys: InnerKeys) -> Iterator[Region]:
    for number, model in enumerate(keys.regions):
        key = Key((*DOMAIN, "regions", number))
        with prefixed(f"region {model.name!r}"), about(key):
            found = [replace(ring, key=key) for ring in drawn(rings_of(model.ring), model)]
        rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
        yield from (Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in found)
