"""Boundary layers of a case, bound to the labels of its domain, and what the spacing is beside them."""

import math
import sys
from collections.abc import Iterator, Sequence

import numpy as np

from bubblemesh.arrays import Floats
from bubblemesh.case.fields import several
from bubblemesh.case.layers import LayerKeys
from bubblemesh.errors import CaseError, Key, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.layers.ladder import MOST_LAYERS, Ladder, count_of, first_of, growth_of
from bubblemesh.layers.pinches import ROUND, SHORT
from bubblemesh.layers.pipeline import HighLayerError, layered
from bubblemesh.layers.rest import Rest
from bubblemesh.layers.small_features import plain_edges
from bubblemesh.layers.walls import fillet_radii
from bubblemesh.messages import meant
from bubblemesh.problem.problem import Task
from bubblemesh.spacing.rules.grading import Ground, LimitedSpacing
from bubblemesh.spacing.rules.rules import limited_for_packing_across_sides
from bubblemesh.spacing.rules.sources import Sources, short_pieces
from bubblemesh.spacing.spacing import Spacing

LOWEST = 1e-10  # of the domain's size: lower layers are rounding
STEPS = 1000  # from one number to the next, that a layer is high at least
MOST_RISING = 10_000  # layers until they are as high as the domain


def ladders_of(entries: Sequence[LayerKeys], domain: Domain) -> tuple[Ladder, ...]:
    """Layers that a case asks for in a domain.

    CaseError for labels or regions that the domain has not, for labels with two kinds of layers, and for a periodic
    side whose counterpart has none.
    """
    return tuple(_ladders(entries, domain))


def _ladders(entries: Sequence[LayerKeys], domain: Domain) -> Iterator[Ladder]:
    """Layers of each entry, once its labels and its region are checked."""
    boundary = domain.boundary
    sides = [boundary.labels[k] for k in sorted(set(boundary.label.tolist()))]
    taken = dict[tuple[str, str | None], int]()
    named = {label for keys in entries for label in several(keys.on)}
    for number, keys in enumerate(entries):
        with at_key("layers", number, "region"):
            if keys.region is not None and keys.region not in domain.parts.names:
                raise CaseError(f"there is no region {keys.region!r}: {meant(keys.region, domain.parts.names)}")
        with at_key("layers", number, "on"):
            labels = several(keys.on)
            for label in labels:
                if labels.count(label) > 1:
                    raise CaseError(f"{label!r} is named twice: name it once")
                if label not in sides:
                    raise CaseError(f"there is no side or line {label!r}: {meant(label, sides)}")
                for (known, region), other in taken.items():
                    if known == label and (region is None or keys.region is None or region == keys.region):
                        raise CaseError(f"{label!r} has layers already, by layers.{other}: name it once")
            for pair in domain.parts.periodic:
                if len({*pair} & named) == 1 and {*pair} & {*labels}:
                    raise CaseError(f"the sides {pair[0]!r} and {pair[1]!r} match: name both, or none")
            taken |= {(label, keys.region): number for label in labels}
        yield _ladder(keys, Key(["layers", number]), domain)


def hidden_below(domain: Domain, ladders: Sequence[Ladder]) -> Floats:
    """Length (p,) up to which edges of each piece of the boundary are hidden below layers, and make nothing finer.

    Fillets are hidden as a whole if their radius is about the height of the first layer, or below, and edges of
    straight walls if layers become as high.
    """
    boundary, hidden = domain.boundary, plain_edges(domain.boundary, ladders)
    radii = fillet_radii(boundary)
    for ladder in ladders:
        mine = np.isin(boundary.label, [boundary.labels.index(label) for label in ladder.labels])
        hidden[mine] = np.maximum(hidden[mine], SHORT * ladder.first)
        fillets = mine & (radii < ROUND * ladder.first)
        hidden[fillets] = np.maximum(hidden[fillets], boundary.lengths[fillets])
    return hidden


def with_layers(
    domain: Domain,
    task: Task,
    spacing: Spacing,
    packing: Spacing,
    after_periodic: LimitedSpacing,
    ground: Ground | None,
) -> tuple[Rest, Spacing, Floats]:
    """The rest of a domain beside the layers of a task, the spacing there, and the short edges (k, 2, 2) behind it.

    Layers are no higher than the ``spacing`` that is requested, than which that of the ``packing`` may be finer. In a
    metric both depend on the direction: the spacing beside layers is limited from the one that does not, which is the
    one ``after_periodic``. If that was limited already without layers, this goes on from that ``ground``: their edges
    are more sources in the same domain.

    HighLayerError if a first layer is higher than the spacing across all of its walls, LimitError if there would be
    more nodes than the task allows.
    """

    def limited(sources: Sources) -> Spacing:
        return limited_for_packing_across_sides(domain, after_periodic, sources, ground=ground).spacing

    rest = layered(domain, spacing, packing, task.ladders, task.max_nodes)
    low = rest.strips.low_fans
    if len(low) and not packing.in_metric:
        rest = layered(domain, spacing, limited(low), task.ladders, task.max_nodes)
    sources = short_pieces(rest.domain, packing)
    beside = limited(sources)
    return rest.held_at_steps(beside), beside, sources.points.reshape(-1, 2, 2)


def left_out(error: HighLayerError, domain: Domain, ladders: Sequence[Ladder]) -> tuple[tuple[Ladder, ...], str]:
    """Layers without those that are too high for what a solution asks for, and the warning of it.

    The counterpart of a periodic side has none then either.
    """
    high = error.ladder
    labels = {label for pair in domain.parts.periodic if {*pair} & {*high.labels} for label in pair}
    warnings = (
        f"{high.key}: the solution asks for sizes across these walls of at most {error.spacing:.4g}, less than the "
        f"first layer, {high.first:.4g}: these layers are left out; a lower first one would keep them"
    )
    return tuple(ladder for ladder in ladders if ladder is not high and not {*ladder.labels} & labels), warnings


def _ladder(keys: LayerKeys, key: Key, domain: Domain) -> Ladder:
    """Layers of a first height, a growth and a count, whichever of these the case gives; no higher than the domain.

    CaseError if there are too many of them, or the first one is too low for a domain of that size, or so far from the
    origin.
    """
    growth = keys.growth
    first = keys.first
    count = keys.count
    size = domain.size
    farthest = max(map(abs, domain.bounds))
    if count is not None and keys.thickness is not None:
        first = first_of(count, keys.thickness, growth)
    assert first is not None
    if first < LOWEST * size:
        with at_key(*key):
            raise CaseError(
                f"the first layer, {first:.4g} high, is too low for numbers beside the domain's size {size:.4g}"
            )
    if first < STEPS * sys.float_info.epsilon * farthest:
        with at_key(*key):
            raise CaseError(
                f"the first layer, {first:.4g} high, is too low for numbers beside coordinates up to {farthest:.4g}: "
                "move the domain to the origin, by move beside each ring, region, line and point"
            )
    if keys.until is not None:
        count = max(math.ceil(math.log(size / first) / math.log(growth)), 0) + 1
    elif count is None:
        assert keys.thickness is not None
        count = count_of(first, keys.thickness, growth)
    if count > (MOST_LAYERS if keys.until is None else MOST_RISING):
        with at_key(*key):
            raise CaseError(f"this makes {count} layers, which is too many: raise growth or first")
    if keys.count is None and keys.thickness is not None and count > 1:
        growth = growth_of(first, count, keys.thickness)
    return Ladder(
        labels=several(keys.on),
        first=first,
        growth=growth,
        count=count,
        by_thickness=keys.thickness is not None,
        isotropic=keys.until is not None,
        fans=keys.corners == "fans",
        follow=keys.ends == "follow",
        quads=keys.cells == "quads",
        region=keys.region,
        key=key,
    )
