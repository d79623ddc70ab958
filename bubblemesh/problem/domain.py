"""The domain that a case describes."""

from collections.abc import Iterator
from dataclasses import replace

from bubblemesh.case import Case
from bubblemesh.case.domain import DomainKeys, FileDomain, InnerKeys
from bubblemesh.errors import GeometryError, Key, about, prefixed
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.paths import InnerPoint, Ring
from bubblemesh.messages import ring_name
from bubblemesh.problem.rings import open_path, rings_of, rings_of_file

DOMAIN = Key(["domain"])


def case_domain(case: Case) -> Domain:
    """The domain of a case's rings, with its regions and what is embedded.

    Raises
    ------
    GeometryError, CaseError, FileError
        With the place and what to do.
    """
    with about(DOMAIN):
        outer, *holes = domain_rings(case.domain)
        return Domain.of(outer, holes, _inner_parts(case.domain))


def domain_rings(keys: DomainKeys) -> list[Ring]:
    """The outer ring and the holes of a domain.

    Raises
    ------
    GeometryError, CaseError, FileError
        With the ring.
    """
    if isinstance(keys, FileDomain):
        return rings_of_file(keys)
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


def _inner_parts(keys: InnerKeys) -> Parts:
    """Regions and what is embedded; errors tell which one it is.

    Raises
    ------
    GeometryError, CaseError, FileError
    """
    lines = []
    for number, line in enumerate(keys.lines, start=1):
        key = Key((*DOMAIN, "lines", number - 1))
        with prefixed(f"line {number}"), about(key):
            lines.append(replace(open_path(line, default=f"line-{number}"), key=key))
    points = (
        InnerPoint(point.at, point.label or f"point-{number}", Key((*DOMAIN, "points", number - 1)))
        for number, point in enumerate(keys.points, start=1)
    )
    return Parts(tuple(_regions(keys)), keys.region, tuple(lines), tuple(points), keys.periodic)


def _regions(keys: InnerKeys) -> Iterator[Region]:
    for number, model in enumerate(keys.regions):
        key = Key((*DOMAIN, "regions", number))
        with prefixed(f"region {model.name!r}"), about(key):
            found = [replace(ring, key=key) for ring in rings_of(model.ring)]
        rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
        yield from (Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in found)
