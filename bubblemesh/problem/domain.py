"""The domain that a case describes."""

from bubblemesh.case import Case
from bubblemesh.case.rings import rings_of
from bubblemesh.errors import GeometryError
from bubblemesh.geometry.arrangement.regions import Parts, Region
from bubblemesh.geometry.domain import Domain


def domain_of(case: Case) -> Domain:
    """The rings of the case, with its regions and what is embedded.

    Raises
    ------
    GeometryError, CaseError, FileError
        With the place and what to do.
    """
    return Domain.of(*case.domain.rings(), _parts(case))


def _parts(case: Case) -> Parts:
    """Regions and what is embedded; errors tell which one it is.

    Raises
    ------
    GeometryError, CaseError, FileError
    """
    regions = []
    for model in case.domain.regions:
        try:
            rim = f"{model.name}-rim"  # also where a file calls the ring as the case calls the region
            regions += [Region(ring.renamed(model.name, rim), model.name, label=rim) for ring in rings_of(model.ring)]
        except GeometryError as error:
            raise GeometryError(f"region {model.name!r}: {error}") from None
    strands = []
    for number, line in enumerate(case.domain.lines, start=1):
        try:
            strands.append(line.strand(default=f"line-{number}"))
        except GeometryError as error:
            raise GeometryError(f"line {number}: {error}") from None
    points = [(point.at, point.label or f"point-{number}") for number, point in enumerate(case.domain.points, start=1)]
    return Parts(tuple(regions), case.domain.region, tuple(strands), tuple(points), case.domain.periodic)
