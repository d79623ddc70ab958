"""The domain that a case describes: its rings, regions and lines as geometry."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from bubblemesh import readers
from bubblemesh.case import Case
from bubblemesh.case.domain import (
    DomainKeys,
    FileDomain,
    InnerKeys,
    RegionDomain,
    RegionFile,
    RegionKeys,
    RegionSeed,
    RingDomain,
    ShoreDomain,
)
from bubblemesh.case.lines_and_points import JoinedPointKeys, PointFile
from bubblemesh.case.repair import RepairKeys
from bubblemesh.case.shapes import RingKeys
from bubblemesh.errors import (
    BubblemeshError,
    CaseError,
    GeometryError,
    Key,
    NeighbourError,
    about,
    coarsened_by,
    prefixed,
)
from bubblemesh.geometry.arrangement.covering import covered
from bubblemesh.geometry.arrangement.overlay import overlaid
from bubblemesh.geometry.arrangement.regions import InnerParts, Region, Seed
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.following import Following, followed_together
from bubblemesh.geometry.line_ends import joined_points
from bubblemesh.geometry.map_projection import UNPROJECTED, MapProjection
from bubblemesh.geometry.nesting import with_holes, without_outside_holes
from bubblemesh.geometry.paths import Area, Ring
from bubblemesh.messages import counted, ring_name, tell_places_by, tell_places_of
from bubblemesh.problem.crs import require_one_unit_in_box, sizes_in_metres
from bubblemesh.problem.drawing import Name, drawn
from bubblemesh.problem.files import own_files
from bubblemesh.problem.lines_and_points import lines_of, points_of
from bubblemesh.problem.projection import projection_of
from bubblemesh.problem.repair import repair_of, with_repair
from bubblemesh.problem.shapes import (
    followed,
    hole_areas_of,
    outer_areas_of,
    region_areas_of,
    require_needed,
    selection_of,
)
from bubblemesh.readers.contents import contents_kept
from bubblemesh.readers.systems import one_system

if TYPE_CHECKING:
    from bubblemesh.problem.shoreline.box import Sea
    from bubblemesh.spacing.spacing import Spacing

DOMAIN = Key(["domain"])
REST = -1  # number of what regions leave of the domain, among the numbers of their entries


def case_domain(case: Case) -> Domain:
    """The domain of a case's areas, with its regions and what is embedded; errors have the place and what to do."""
    tell_places_of(None)
    tell_places_by(None)
    with about(DOMAIN), own_files(case.domain, case.root), contents_kept(), one_system():
        projection = projection_of(case.domain, case.crs)
        plane = projection.plane
        tell_places_by(None if plane is None else plane.given_place)
        try:
            sea = isinstance(case.domain, ShoreDomain)
            domain = _with_shared_names(_sea(case, projection) if sea else _domain(case.domain, projection))
            return domain if plane is None else replace(domain, plane=plane)
        except GeometryError as error:
            if error.mendable:
                error.args = (f"{error.text}{_advice(case.domain, projection, error)}",)
            raise


def _domain(keys: DomainKeys, projection: MapProjection) -> Domain:
    if isinstance(keys, RegionDomain):
        return Domain.with_matched_sides(*_covering(keys, projection))
    areas = domain_areas(keys, projection)
    return Domain.with_matched_sides(areas, _inner_parts(keys, areas, projection))


def _sea(case: Case, projection: MapProjection) -> Domain:
    """The domain of the sea in a box, with the detail that its spacing can show."""
    # Imported here since few domains are seas.
    from bubblemesh.problem.shoreline.box import sea_in_box
    from bubblemesh.problem.shoreline.rings import SHORE, areas_of_sea
    from bubblemesh.problem.shoreline.shoreline import fitted_sea
    from bubblemesh.problem.spacing import case_spacing
    from bubblemesh.spacing.survey import require_not_many_times

    keys = case.domain
    assert isinstance(keys, ShoreDomain)
    if case.crs is None:
        require_one_unit_in_box(keys, case.spacing_terms)
    sea = sea_in_box(keys, projection)
    parts = _inner_parts(keys, [], projection)  # no line is joined to the shore, whose detail is not known yet

    def domain_of(sea: "Sea") -> Domain:
        domain = Domain.of_areas(
            [area.about(Key((*DOMAIN, "shoreline"))) for area in areas_of_sea(sea, keys.shoreline.file)], parts
        )
        shore = tuple(label for label in SHORE if label in domain.labels)
        return replace(domain, plane=projection.plane, groups={"shore": shore})

    @cache
    def spacing() -> "Spacing":  # which is asked for only where the shore that is kept depends on it
        whole = domain_of(sea)
        request = case_spacing(case, whole)
        found = request.at(None)
        if request.nodes is None:
            require_not_many_times(whole, found, case.limits.max_nodes)
        elif keys.shoreline.narrowest is not None:
            scaled = "narrowest goes by the spacing before spacing.nodes scales it: give about its true sizes"
            with coarsened_by(scaled):
                require_not_many_times(whole, found, case.limits.max_nodes)
        return found

    with sizes_in_metres(case, keys.box):
        return domain_of(fitted_sea(sea, keys, lambda points: spacing().extended(points)))


def _advice(keys: DomainKeys, projection: MapProjection, error: GeometryError) -> str:
    """Advice on what mends rings that an error is about, if a repair does, and on what is to be done then."""
    then = ""
    for path in dict.fromkeys((error.about[1:], (*error.about[1:], "ring"), ())):
        repaired = with_repair(keys, path)
        if repaired is None:
            continue
        advice = f"; repair: true in {Key((*DOMAIN, *path))} mends it"
        try:
            _domain(repaired, projection)
        except GeometryError as other:
            if not then and isinstance(other, NeighbourError) and not isinstance(error, NeighbourError):
                then = f"{advice}, and then: {other.text}"
        except BubblemeshError:
            pass
        else:
            return advice
    return then


def domain_areas(keys: DomainKeys, projection: MapProjection = UNPROJECTED) -> list[Area]:
    """The areas of a domain, of a sea with all of its detail; errors of geometry, keys and files name the ring."""
    match keys:
        case RingDomain():
            return _areas_of_rings(keys, projection)
        case RegionDomain():
            return _covering(keys, projection)[0]
        case FileDomain():
            return _areas_of_file(keys, projection)
        case ShoreDomain():
            from bubblemesh.problem.shoreline.box import sea_in_box
            from bubblemesh.problem.shoreline.rings import areas_of_sea

            return areas_of_sea(sea_in_box(keys, projection), keys.shoreline.file)


def _areas_of_rings(keys: RingDomain, projection: MapProjection) -> list[Area]:
    """The areas within outer rings and outside of holes, repaired if the keys say so."""
    repair = repair_of(keys)
    areas = list(_outer_areas(keys, projection))
    holes, left_out = without_outside_holes(areas, list(_holes(keys, projection)))
    if left_out:
        areas[0] = areas[0].noted(f"{counted(left_out, 'hole')} left out, outside of the domain")
    rings = [hole.outer for hole in holes]
    islands = [Area(ring) for hole in holes for ring in hole.holes]  # what lies in a hole of a hole is meshed again
    if not repair.mend:
        return repair([*with_holes(areas, rings), *islands])
    return [*repair(areas, rings), *(repair(islands) if islands else [])]


def _outer_areas(keys: RingDomain, projection: MapProjection) -> Iterator[Area]:
    several = isinstance(keys.outer, tuple)
    for number, own in enumerate(keys.outer if isinstance(keys.outer, tuple) else [keys.outer]):
        ring = _inheriting(own, keys)
        key = Key((*DOMAIN, "outer", number) if several else (*DOMAIN, "outer"))
        with prefixed(f"outer ring {number + 1}" if several else ring_name(0)), about(key):
            found = outer_areas_of(ring, projection)
            require_needed(found)
        yield from (area.about(key) for area in found)


def _holes(keys: RingDomain, projection: MapProjection) -> Iterator[Area]:
    made = 0
    for number, own in enumerate(keys.holes):
        ring = _inheriting(own, keys)
        key = Key((*DOMAIN, "holes", number))
        with prefixed(ring_name(made + 1)), about(key):
            found = [area.about(key) for area in hole_areas_of(ring, projection)]
        made += len(found)
        yield from found


def _inheriting(ring: RingKeys, keys: RingDomain) -> RingKeys:
    """The keys of a ring, which is mended by itself too if the domain is: lines of a file may not even close."""
    mends = keys.repair and isinstance(ring, RepairKeys) and not ring.repair
    return ring.model_copy(update={"repair": keys.repair}) if mends else ring


def _areas_of_file(keys: FileDomain, projection: MapProjection) -> list[Area]:
    """Areas in a file that is the whole domain."""
    labelled = [
        Area(area.outer.labelled(keys.label), tuple(hole.labelled(keys.hole_label) for hole in area.holes))
        for area in readers.read_areas(Path(keys.file), selection_of(keys), projection)
    ]
    areas = [area.mapped(lambda ring: followed(ring, keys)) for area in drawn(labelled, keys)]
    require_needed(areas)
    return areas


def _inner_parts(keys: InnerKeys, areas: Sequence[Area], projection: MapProjection) -> InnerParts:
    """Regions in areas, and what is embedded; errors say which one it is."""
    return _with_embedded(_in_layers(_with_regions(keys, projection), keys, areas), keys, areas, projection)


def _with_regions(keys: InnerKeys, projection: MapProjection) -> InnerParts:
    """Regions of a domain, and points in further ones."""
    found = list(_regions(keys, projection))
    regions = tuple(one for one in found if isinstance(one, Region))
    seeds = tuple(one for one in found if isinstance(one, Seed))
    tolerance = keys.periodic_tolerance or 0.0
    named = "region" in keys.model_fields_set
    return InnerParts(regions, keys.region, named, periodic=keys.periodic, periodic_tolerance=tolerance, seeds=seeds)


def _in_layers(parts: InnerParts, keys: InnerKeys, areas: Sequence[Area]) -> InnerParts:
    """The parts, later regions in areas covering earlier ones if the keys say so."""
    if keys.overlaps == "refused":
        return parts
    return replace(parts, regions=tuple(covered(parts.regions, [area.outer for area in areas])))


def _with_embedded(parts: InnerParts, keys: InnerKeys, areas: Sequence[Area], projection: MapProjection) -> InnerParts:
    """Regions in areas, with lines and points."""
    points, notes = points_of(keys, projection)
    rings = [ring for area in areas for ring in area.rings] + parts.rings
    lines = lines_of(keys, rings, projection)
    points, more = joined_points(points, lines, rings)
    return replace(parts, lines=tuple(lines), points=tuple(points), remarks=(*notes, *more))


def _regions(keys: InnerKeys, projection: MapProjection) -> Iterator[Region | Seed]:
    """Regions of the keys, and points in others; CaseError if one of a file has the name of another entry."""
    seen = {keys.region: REST}
    for number, model in enumerate(keys.regions):
        key = _region_key(number)
        found: list[Area] | list[Seed]
        label, named = None, True
        match model:
            case RegionFile():
                with about(key):
                    found = _regions_of_file(model, projection, ordered=keys.overlaps == "later")
                    for one in found:
                        if (other := seen.setdefault(str(one.name), number)) != number:
                            raise _named_twice(one, model, is_rest=other == REST)
                label, named = model.label, model.label is not None
            case RegionSeed():
                with prefixed(f"region {model.name!r}"), about(key):
                    found = drawn((Seed(projection.point(at), model.name) for at in model.points), model)
            case RegionKeys():
                with prefixed(f"region {model.name!r}"), about(key):
                    areas = [replace(area, name=model.name) for area in region_areas_of(model.ring, projection)]
                    found = drawn(areas, model, _renamed)
                label = getattr(model.ring, "label", None)
        seen |= dict.fromkeys((str(one.name) for one in found), number)
        for one in found:
            if isinstance(one, Seed):
                yield replace(one, key=key, entry=number)
            else:
                yield replace(_region(one, str(one.name), number, label), named=named)


def _region_key(entry: int) -> Key:
    return Key((*DOMAIN, "regions", entry))


def _named_twice(area: Area | Seed, keys: RegionFile, is_rest: bool) -> CaseError:
    """The error of an area or a point of a file whose name another region has, or the rest of the domain."""
    where = (None if isinstance(area, Seed) else area.outer.origin) or keys.file
    if is_rest:
        return CaseError(
            f"{where}: {area.name!r} is the name of what regions leave of the domain, too: rename it, or that by "
            "region: NAME in the domain"
        )
    return CaseError(f"{where}: {area.name!r} is the name of another region too: rename one of them")


def _regions_of_file(keys: RegionFile, projection: MapProjection, ordered: bool) -> list[Area] | list[Seed]:
    """Areas of a file that share borders, with their names, or points in regions; if ``ordered``, later ones cover."""
    if keys.part is not None:
        raise CaseError("part is not for regions that share borders: leave it out")
    found, points = list[Area](), list[Seed]()
    limits = keys.largest is None
    for one in readers.read_regions(Path(keys.file), selection_of(keys), keys.name, projection, limits, ordered):
        if isinstance(one, Area):
            found.append(one.mapped(lambda ring: ring.labelled(keys.label)))
        else:
            points.append(Seed(one.at, one.name, notes=one.notes))
    if points:
        _require_no_keys_of_areas(keys)
        return drawn(points, keys)
    if keys.corners is not None:
        found = followed_together(found, Following(keys.corners, keys.smooth, keys.tolerance))
    return drawn(found, keys, _renamed)


def _require_no_keys_of_areas(keys: RegionFile) -> None:
    """Check that a file with points alone has no keys for areas; else it is a CaseError."""
    points = {*PointFile.model_fields, *RegionSeed.model_fields} - {*JoinedPointKeys.model_fields}
    given = [key for key in type(keys).model_fields if key in keys.model_fields_set and key not in points]
    if given:
        raise CaseError(f"{given[0]} is for areas, and {Path(keys.file).name} has points alone: leave it out")


def _renamed(area: Area, name: Name) -> Area:
    """The area of a region with another name, and the labels that it has."""
    return replace(area, name=name(area.name))


def _covering(keys: RegionDomain, projection: MapProjection) -> tuple[list[Area], InnerParts]:
    """Areas that the regions of files cover together, and these regions, with what is embedded."""
    parts = _with_regions(keys, projection)
    if parts.seeds and not parts.regions:
        with about(parts.seeds[0].key):
            raise CaseError("points name regions in a domain that outer or file gives: add that")
    areas = _covered(keys, parts)
    return areas, _with_embedded(_in_layers(parts, keys, areas), keys, areas, projection)


def _covered(keys: RegionDomain, parts: InnerParts) -> list[Area]:
    """Areas that the regions of files cover together."""
    files = [number for number, model in enumerate(keys.regions) if isinstance(model, RegionFile)]
    areas = [region.area for region in parts.regions if region.entry in files]
    if all(map(readers.is_straight, areas)):
        return readers.united(areas)
    return overlaid("union", [[area.mapped(_plain)] for area in areas])


def _plain(ring: Ring) -> Ring:
    """The ring without labels and notes, which its region has."""
    return replace(ring, sides=tuple(side._replace(label=None) for side in ring.sides), notes=(), changes=())


def _region(area: Area, name: str, entry: int, label: str | None) -> Region:
    """A region, with the number of the case's entry that gives it, and rings with its key.

    A ring that a file calls as the case calls the region has the label of a rim, unless the case gives that ``label``.
    """
    key = _region_key(entry)

    def own(ring: Ring) -> Ring:
        by_file = ring.origin is not None and label != name
        return replace(ring.without_label(name) if by_file else ring, key=key)

    return Region(area.mapped(own), name, label=f"{name}-rim", entry=entry)


def _with_shared_names(domain: Domain) -> Domain:
    """The domain with a note on regions that have the name of a label, and another one in mesh files."""
    notes = [
        f"the region {name!r} is called '{name}_region' in mesh files, since a label has its name"
        for name in domain.parts.names
        if name in domain.side_labels
    ]
    return replace(domain, notes=(*domain.notes, *notes)) if notes else domain
