"""The domain that a case describes: its rings, regions and lines as geometry."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from bubblemesh.case import Case
from bubblemesh.case.domain import DomainKeys, FileDomain, InnerKeys, RingDomain
from bubblemesh.errors import Key, about, prefixed
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.nesting import with_holes
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.messages import ring_name, tell_places_of
from bubblemesh.problem.drawing import drawn
from bubblemesh.problem.embedded import lines_of, points_of
from bubblemesh.problem.files import own_files
from bubblemesh.problem.shapes import areas_of, followed, outer_areas_of, rings_of, selection_of
from bubblemesh.readers.formats import read_areas

DOMAIN = Key(["domain"])


def case_domain(case: Case) -> Domain:
    """The domain of a case's areas, with its regions and what is embedded; errors have the place and what to do."""
    tell_places_of(None)
    with about(DOMAIN), own_files(case.domain, case.root):
        return Domain.of_areas(domain_areas(case.domain), _inner_parts(case.domain))


def domain_areas(keys: DomainKeys) -> list[Area]:
    """The areas of a domain; errors of geometry, keys and files name the ring."""
    if isinstance(keys, FileDomain):
        return _areas_of_file(keys)
    return with_holes(list(_outer_areas(keys)), list(_holes(keys)))


def _outer_areas(keys: RingDomain) -> Iterator[Area]:
    several = isinstance(keys.outer, tuple)
    for number, ring in enumerate(keys.outer if isinstance(keys.outer, tuple) else [keys.outer]):
        key = Key((*DOMAIN, "outer", number) if several else (*DOMAIN, "outer"))
        with prefixed(f"outer ring {number + 1}" if several else ring_name(0)), about(key):
            found = outer_areas_of(ring)
        yield from (area.about(key) for area in found)


def _holes(keys: RingDomain) -> Iterator[Ring]:
    made = 0
    for number, ring in enumerate(keys.holes):
        key = Key((*DOMAIN, "holes", number))
        with prefixed(ring_name(made + 1)), about(key):
            found = [replace(one, key=key) for one in rings_of(ring)]
        made += len(found)
        yield from found


def _areas_of_file(keys: FileDomain) -> list[Area]:
    """Areas in a file that is the whole domain."""
    labelled = [
        Area(area.outer.labelled(keys.label), tuple(hole.labelled(keys.hole_label) for hole in area.holes))
        for area in read_areas(Path(keys.file), selection_of(keys))
    ]
    return [area.mapped(lambda ring: followed(ring, keys)) for area in drawn(labelled, keys)]


def _inner_parts(keys: InnerKeys) -> Parts:
    """Regions and what is embedded; errors tell which one it is."""
    points, notes = points_of(keys)
    return Parts(tuple(_regions(keys)), keys.region, tuple(lines_of(keys)), tuple(points), keys.periodic, notes)


def _regions(keys: InnerKeys) -> Iterator[Region]:
    for number, model in enumerate(keys.regions):
        key = Key((*DOMAIN, "regions", number))
        with prefixed(f"region {model.name!r}"), about(key):
            found = drawn(areas_of(model.ring), model)
        yield from (_region(area, model.name, key) for area in found)


def _region(area: Area, name: str, key: Key) -> Region:
    """A region, with the key of the case that gives it."""
    rim = f"{name}-rim"  # also where a file calls the ring as the case calls the region
    return Region(area.mapped(lambda ring: replace(ring.renamed(name, rim), key=key)), name, label=rim)
