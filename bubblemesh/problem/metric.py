"""Metrics of a case, bound to its domain, and the spacing in them."""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.case.data_terms import several
from bubblemesh.case.metric import AnyMetric, DirectedMetric, FieldMetric, TensorMetric, WallMetric
from bubblemesh.case.models import IN_METRIC
from bubblemesh.errors import CaseError, Key, at_key, prefixed
from bubblemesh.files import local_copy
from bubblemesh.geometry.distance.distances import distance_to_labels, require_labels
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.geography import Plane
from bubblemesh.geometry.periodic import counterparts
from bubblemesh.meshes.quality import doubled_areas
from bubblemesh.meshes.tensors import Axes, area_sizes, axes, intersections, require_positive_definite, size_ratios
from bubblemesh.meshfiles.metric import read_metric
from bubblemesh.messages import place, two_places
from bubblemesh.problem.crs import bound_in, given_bounds, given_system, require_given
from bubblemesh.problem.data_terms import rasters_in
from bubblemesh.problem.files import own_files
from bubblemesh.readers.grids import Box
from bubblemesh.readers.netcdf import netcdf
from bubblemesh.records import record
from bubblemesh.spacing.cover import Cover
from bubblemesh.spacing.expression import Expression, Rasters
from bubblemesh.spacing.metric.field import TensorField
from bubblemesh.spacing.metric.gradation import graded
from bubblemesh.spacing.metric.metric import Ellipses, MetricSpacing
from bubblemesh.spacing.spacing import Spacing
from bubblemesh.spacing.survey import ESTIMATE, Survey, ideal_nodes, surveyed
from bubblemesh.spacing.terms.raster import Raster

Value = float | Expression
Number = Callable[[Floats, Floats], Floats]  # (n,) at x (n,) and y (n,)

CLOSE = 1e-4  # of the domain's size: nearer to a wall the direction is that of its tangent
STATIONS, DIFFERENT = 17, 1.5  # places looked at on periodic sides, and times that a size may differ there
TOLD = 1.001  # of the largest aspect: what is more of it is told
ENTRIES = "m11", "m12", "m22"  # names of the rasters in a file
LARGER = 1.05  # times: the most that sizes grow to save the nodes that shorter ellipses take
GRADINGS, SAME = 5, 1.2  # one after the other, at most, and times that sizes may differ in the end
NEGLIGIBLE = 0.01  # of the domain: what polygons in place of curves leave out
INFINITE = 1e100  # size that asks for nothing


class MetricRequest(NamedTuple):
    """A metric of a case: its ellipses, and the largest aspect that they may have, with the key of the case."""

    ellipses: Ellipses  # no numbers where the metric is not positive
    aspect: float
    key: Key
    gradation: float = np.inf  # growth over a length of 1
    notes: tuple[str, ...] = ()  # what was chosen of its file

    def scaled(self, scale: float) -> "MetricRequest":
        """The metric with all sizes multiplied."""
        return self._replace(ellipses=Scaled(self.ellipses, scale))


class InMetric(NamedTuple):
    """Metrics of a problem, the spacing in them that is asked for, what is known of it, and warnings."""

    metrics: tuple[MetricRequest, ...]
    asked: MetricSpacing
    survey: Survey
    warnings: tuple[str, ...]

    def packing(self, domain: Domain, spacing: Spacing, max_nodes: int) -> MetricSpacing:
        """The spacing in the metrics for a packing of a domain, below one that is as fine as its boundary needs.

        Where straight edges cannot follow it ellipses are shorter, and none is longer than the domain.
        """
        fitted = MetricSpacing.of(Intersection(self.metrics, spacing, domain.size), self.asked.aspect)
        bent = _graded(domain, fitted, self.metrics, max_nodes)
        return _with_fewer_nodes(bent.straightened(), bent, domain, max_nodes)


def _with_fewer_nodes(straight: MetricSpacing, bent: MetricSpacing, domain: Domain, max_nodes: int) -> MetricSpacing:
    """A straightened metric with larger sizes: about half of the nodes that it takes beyond the bent one are saved.

    Sizes grow by 5 % at most: a metric that is impossible in most of the domain takes more nodes.
    """
    cover = Cover.of(domain)
    nodes, fewer = (ideal_nodes(domain, spacing, max_nodes, ESTIMATE, cover) for spacing in (straight, bent))
    scale = min((nodes / fewer) ** 0.25, LARGER)
    return straight if scale <= 1 else MetricSpacing.of(Scaled(straight.ellipses, scale), straight.aspect, bent)


def metric_requests(
    models: Sequence[AnyMetric], domain: Domain, root: Path | None, rasters: Rasters
) -> tuple[MetricRequest, ...]:
    """The metrics of a case in a domain; CaseError, with the key, for labels or rasters that it has not.

    Files are read below the ``root`` of an untrusted case only.
    """
    found = list[MetricRequest]()
    for number, model in enumerate(models):
        with own_files(model, root):
            found.append(_request(model, domain, Key(["metric", *([number] if len(models) > 1 else [])]), rasters))
    return tuple(found)


def _request(model: AnyMetric, domain: Domain, key: Key, rasters: Rasters) -> MetricRequest:
    def number(name: str) -> Number:
        value = getattr(model, name)
        with at_key(*key, name):
            expression = value if isinstance(value, Expression) else Expression.parse(repr(float(value)))
            return bound_in(domain.unprojection, expression, partial(distance_to_labels, domain), rasters)[0]

    plane = domain.plane
    along = None if getattr(model, "along", None) is None else number("along")
    notes: tuple[str, ...] = ()
    ellipses: Ellipses
    match model:
        case DirectedMetric():
            ellipses = Directed(number("angle"), number("across"), along)
        case TensorMetric():
            ellipses = Entries(number("m11"), number("m12"), number("m22"))
        case WallMetric():
            labels = several(model.label)
            with at_key(*key, "label"):
                require_labels(domain, labels)
            ellipses = AlongWalls(domain, tuple(labels), model.across, model.growth, along)
        case FieldMetric():
            with at_key(*key):
                ellipses, notes = _read(model, domain)
                ellipses = ellipses if plane is None else AtGivenPlaces(ellipses, plane)
    if plane is not None:
        ellipses = OnTheGround(ellipses, plane, turned=not isinstance(model, WallMetric))
    return MetricRequest(ellipses, model.aspect, key, model.gradation or np.inf, notes)


def _read(model: FieldMetric, domain: Domain) -> tuple[Ellipses, tuple[str, ...]]:
    """The metric in a file, and notes on what was chosen of it; CaseError or FileError if it holds none."""
    if _has_rasters(Path(model.file)):
        return _read_rasters(model, domain)
    if model.bounds is not None:
        raise CaseError(f"bounds: {model.file} is no file of arrays, whose pixels they are for: leave bounds out")
    read = read_metric(Path(model.file), model.name, chosen_by="name")
    with prefixed(model.file):
        _require_meeting("mesh", (*read.points.min(axis=0).tolist(), *read.points.max(axis=0).tolist()), domain)
    field = TensorField.of(read.points, read.triangles, read.values)
    notes = tuple(f"{model.file}: {note}" for note in (*read.notes, *_left_out("mesh", field, domain)))
    return field, notes


def _has_rasters(path: Path) -> bool:
    """Whether a file is one of NumPy's arrays, or a NetCDF file with a grid m11, which others may be of meshes."""
    if path.suffix.lower() != ".nc":
        return path.suffix.lower() == ".npz"
    with prefixed(path), netcdf(local_copy(path)) as variables:
        return ENTRIES[0] in variables and len(variables[ENTRIES[0]].shape) >= 2


def _read_rasters(model: FieldMetric, domain: Domain) -> tuple[Ellipses, tuple[str, ...]]:
    """The metric in three rasters of a file, with notes; errors as of `_read`."""
    if model.name is not None:
        raise CaseError(f"name: the rasters of {model.file} are m11, m12 and m22: leave name out")
    box, system = given_bounds(domain), given_system(domain)
    found, notes = rasters_in(model.file, model.bounds, ENTRIES, box, system)
    first = found[0]
    with prefixed(model.file):
        _require_meeting("grid", first.bounds, domain)
        if any(not (np.array_equal(one.x, first.x) and np.array_equal(one.y, first.y)) for one in found):
            raise CaseError("m11, m12 and m22 have pixels at other places: write them on one grid")
        tensors, columns = np.column_stack([one.values.ravel() for one in found]), len(first.x)
        require_positive_definite(area_sizes(tensors), lambda k: (first.x[k % columns], first.y[k // columns]))
    return Entries(*found), (*notes, *(f"{model.file}: {note}" for note in _left_out("grid", first, domain)))


def _left_out(what: str, data: TensorField | Raster, domain: Domain) -> Iterator[str]:
    """Note on the part of a domain that data does not reach."""
    corners = Cover.of(domain).corners
    middles, areas = corners.mean(axis=1), np.abs(doubled_areas(corners))
    outside = ~data.holds(middles if domain.plane is None else domain.plane.given(middles))
    share = areas[outside].sum() / areas.sum()
    if share > NEGLIGIBLE:
        yield f"its {what} leaves out about {share:.0%} of the domain: there the tensors at its nearest places count"


def _require_meeting(what: str, bounds: Box, domain: Domain) -> None:
    """CaseError if the box (x0, y0, x1, y1) of data lies beside a domain, or cannot be one of its coordinates."""
    require_given(bounds, domain)
    (left, low, right, high), (x0, y0, x1, y1) = bounds, given_bounds(domain)
    if left > x1 or right < x0 or low > y1 or high < y0:
        raise CaseError(
            f"its {what}, from {place((left, low))} to {place((right, high))}, lies beside the domain, which is from "
            f"{place((x0, y0))} to {place((x1, y1))}"
        )


@record
class Directed:
    """Ellipses of sizes across and along a direction, given by its angle."""

    angle: Number
    across: Number
    along: Number | None

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        angle, across = self.angle(x, y), self.across(x, y)
        along = np.full(len(x), INFINITE) if self.along is None else self.along(x, y)
        across = np.where((across > 0) & (along > 0) & np.isfinite(angle), across, np.nan)
        with np.errstate(invalid="ignore"):
            c, s = np.cos(angle), np.sin(angle)
        wide = across > along
        direction = np.column_stack([np.where(wide, -s, c), np.where(wide, c, s)])
        return Axes(np.minimum(across, along), np.maximum(across, along), direction)


@record
class Entries:
    """Ellipses of tensors, given by their entries."""

    m11: Number
    m12: Number
    m22: Number

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        m11, m12, m22 = self.m11(x, y), self.m12(x, y), self.m22(x, y)
        with np.errstate(invalid="ignore", over="ignore"):
            positive = (m11 > 0) & (m22 > 0) & (m11 * m22 > m12 * m12)
        return axes(np.where(positive[:, None], np.column_stack([m11, m12, m22]), np.nan))


@record
class AlongWalls:
    """Ellipses that lie along the nearest of some walls, whose size across grows away from there; circles at points."""

    domain: Domain
    labels: tuple[str, ...]
    across: float
    growth: float
    along: Number | None

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        points = np.column_stack([x, y])
        foot, tangent = self.domain.feet(points, *self.labels)
        ax, ay = x - foot[:, 0], y - foot[:, 1]
        distance = np.hypot(ax, ay)
        at_wall = distance <= CLOSE * self.domain.size
        of_point = ~tangent.any(axis=1)  # which has no direction: around it they are circles
        # Around corners and ends they turn; what is all but on a wall has too short a way to it to tell the direction.
        around = np.column_stack([-ay, ax]) / np.where(at_wall, 1.0, distance)[:, None]
        # Outside, where straight edges are looked at that end there, a wall goes on as it was.
        near = np.full(len(x), CLOSE * self.domain.size)
        straight_on = at_wall | self.domain.surely_outside(points, near)
        direction = np.where(straight_on[:, None], tangent, around)
        direction[of_point] = 1.0, 0.0
        along = np.full(len(x), INFINITE) if self.along is None else self.along(x, y)
        across = np.where(along > 0, np.minimum(self.across + self.growth * distance, along), np.nan)
        return Axes(across, np.where(of_point, across, along), direction)


@record
class Scaled:
    """Ellipses with all sizes multiplied."""

    ellipses: Ellipses
    scale: float

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        return self.ellipses(x, y).times(self.scale)


@record
class AtGivenPlaces:
    """Ellipses at coordinates as they were given, as those at places in the plane."""

    ellipses: Ellipses
    plane: Plane

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,) in the plane."""
        return self.ellipses(*self.plane.given(np.column_stack([x, y])).T)


@record
class OnTheGround:
    """Ellipses in the plane for some in metres on the ground.

    Those that are ``turned`` have directions from the first axis of the given coordinates on: from the east for
    longitudes.
    """

    ellipses: Ellipses
    plane: Plane
    turned: bool

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,) in the plane."""
        found = self.ellipses(x, y).times(self.plane.scale(x, y))
        if not self.turned:
            return found
        c, s = self.plane.first_axis(np.column_stack([x, y])).T
        tx, ty = found.direction.T
        return found._replace(direction=np.column_stack([c * tx - s * ty, s * tx + c * ty]))


def in_metric(
    domain: Domain, metrics: Sequence[MetricRequest], spacing: Spacing, max_nodes: int, cover: Cover
) -> InMetric:
    """The spacing in metrics and below the given one.

    CaseError where a metric is not positive, with the place; LimitError if there would be more than ``max_nodes``
    nodes.
    """
    points = np.vstack([domain.polygonal_copy.points, cover.points, cover.corners.mean(axis=1)])
    told = tuple(_too_long(metrics, spacing, points))
    asked = below(metrics, spacing)
    survey = surveyed(domain, asked, max_nodes, cover)
    aspect = _aspect(asked, np.vstack([points, survey.extremes.minimum_at]))
    asked = replace(asked, aspect=aspect)
    graded_one = _graded(domain, asked, metrics, max_nodes)
    if graded_one is not asked:
        asked, survey = graded_one, surveyed(domain, graded_one, max_nodes, cover)
    return InMetric(tuple(metrics), asked, survey, (*told, *_differing_sides(domain, asked)))


def _differing_sides(domain: Domain, spacing: MetricSpacing) -> Iterator[str]:
    """Warning of a metric that differs between periodic sides."""
    boundary, pairs = domain.boundary, domain.periodic
    if len(pairs) == 0:
        return
    piece, share = np.repeat(pairs[:, 0], STATIONS), np.tile(np.linspace(0, 1, STATIONS), len(pairs))
    s = share * boundary.lengths[piece]
    mine, other, at = counterparts(boundary, pairs, piece, s)
    here, there = boundary.points(piece[mine], s[mine]), boundary.points(other, at)
    times = size_ratios(spacing.checked(here), spacing.checked(there))
    k = int(times.argmax())
    if times[k] > DIFFERENT:
        first, second = two_places(here[k], there[k])
        yield (
            f"metric: its sizes in one direction differ {times[k]:.3g} times between periodic sides, at {first} and "
            f"{second}: nodes there follow the smaller ones, and sizes jump beside the other side: make the metric the "
            "same on both"
        )


def below(metrics: Sequence[MetricRequest], spacing: Spacing) -> MetricSpacing:
    """The spacing in metrics, which is nowhere above the given one."""
    return MetricSpacing.of(Intersection(tuple(metrics), spacing))


@record
class Intersection:
    """The intersection of metrics, their aspects limited, with circles of a spacing, and of a largest size."""

    metrics: tuple[MetricRequest, ...]
    spacing: Spacing
    largest: float = np.inf

    def __call__(self, x: Floats, y: Floats) -> Axes:
        """Axes of the ellipses at x (n,) and y (n,)."""
        d = np.minimum(self.spacing.extended(np.column_stack([x, y])), self.largest)
        if not self.metrics:
            return Axes(d, d, np.column_stack([np.ones(len(d)), np.zeros(len(d))]))
        first, *others = (metric.ellipses(x, y).within(d).wider(metric.aspect) for metric in self.metrics)
        for other in others:
            first = axes(intersections(first.tensors, other.tensors))
        return first


def _graded(domain: Domain, spacing: MetricSpacing, metrics: Sequence[MetricRequest], max_nodes: int) -> MetricSpacing:
    """The spacing in metrics that grow between nodes no faster than their gradation, if they have one.

    The nodes are those of a mesh in the metric, as dense as that varies. Where it jumps these are too few: then come
    those of a mesh in what was graded by them, until that changes no more.
    """
    growth = min((metric.gradation for metric in metrics), default=np.inf)
    if growth == np.inf:
        return spacing
    # Imported here since few metrics are graded.
    from bubblemesh.packing.annealing import NoAnnealing
    from bubblemesh.packing.methods import METHODS
    from bubblemesh.packing.rounds import rounds

    method = replace(METHODS[IN_METRIC], annealing=NoAnnealing())
    result = spacing
    for _ in range(GRADINGS):
        levels, start = method.started(domain, result, 0, max_nodes)
        (last,) = deque(rounds(start, domain, levels, method), maxlen=1)
        x, triangles = last.net.bubbles.x, last.net.triangles
        before, tensors = result(x), graded(x, triangles, spacing.at(x), growth)
        result = MetricSpacing.of(TensorField.of(x, triangles, tensors), spacing.aspect)
        if (before <= SAME * area_sizes(tensors)).all():
            break
    return result


def _aspect(spacing: MetricSpacing, points: Floats) -> float:
    """Largest aspect at points (n, 2)."""
    return float(spacing.axes(points).aspects.max())


def _too_long(metrics: Sequence[MetricRequest], spacing: Spacing, points: Floats) -> Iterator[str]:
    """Warnings of metrics whose ellipses are longer than their aspect allows at points (n, 2)."""
    for metric in metrics:
        aspects = metric.ellipses(*points.T).within(spacing.extended(points)).aspects
        k = int(np.where(np.isfinite(aspects), aspects, 0.0).argmax())
        if aspects[k] > TOLD * metric.aspect:
            yield (
                f"{metric.key}: the ellipses are up to {aspects[k]:.4g} times as long as wide, at {place(points[k])}: "
                f"they are made wider than that, {metric.aspect:g} times at most; aspect raises it"
            )
