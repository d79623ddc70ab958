"""The task of a case: its method, limits and demands, as far as they are known without the spacing."""

from math import inf
from typing import TYPE_CHECKING

from bubblemesh.case import Case
from bubblemesh.case.domain import RegionFile
from bubblemesh.case.fields import several
from bubblemesh.errors import CaseError, at_key
from bubblemesh.geometry.domain import Domain
from bubblemesh.geometry.label_distances import require_labels
from bubblemesh.meshfiles.groups import ids_with_own, named_groups
from bubblemesh.messages import unknown
from bubblemesh.problem.problem import Task
from bubblemesh.problem.regions import largest_areas
from bubblemesh.problem.shapes import length_in_file

if TYPE_CHECKING:
    from bubblemesh.layers.ladder import Ladder
    from bubblemesh.packing.method import Method


def task_of(case: Case, domain: Domain) -> Task:
    """Task of a case: its method, limits and requirements."""
    return Task(
        name=str(case.name),
        method_name=case.method,
        configured=lambda: method_of(case),
        max_nodes=case.limits.max_nodes,
        time_limit=case.limits.seconds,
        settings=case.model_dump(mode="json", exclude={"packing", "schedule"}, exclude_none=True),
        order=case.output.order,
        parts=None if case.parts == "auto" else case.parts or 1,
        partition=case.output.partition,
        requirements=case.require.model_dump(exclude_none=True),
        least_angle=case.angle_min or 0.0,
        inner_node=case.overconstrained is not None,
        largest=inf if case.largest is None else case.largest,
        largest_in=largest_areas(case, domain),
        file_length=_file_length(case),
        open_labels=_open_labels(case, domain),
        ids=_ids(case, domain),
        ladders=_ladders(case, domain),
    )


def method_of(case: Case) -> "Method":
    """The method of a case, with the options that the case gives it, which `load_case` has checked."""
    # Imported here since the methods need SciPy, which an estimate does without.
    from bubblemesh.packing.configure import configured

    return configured(case.method, case.packing, case.schedule)


def _open_labels(case: Case, domain: Domain) -> tuple[str, ...]:
    """Labels of open water that a case names; a CaseError if the domain has not one of them."""
    labels = several(case.output.open)
    with at_key("output", "open"):
        require_labels(domain, labels)
    return labels


def _ids(case: Case, domain: Domain) -> dict[str, int]:
    """Ids of groups that a case gives; a CaseError if there is no such group, or two of a kind have the same one."""
    ids = case.output.ids or {}
    points = tuple(dict.fromkeys(point.label for point in domain.parts.points))
    known = named_groups(domain.side_labels, domain.parts.names, points)
    with at_key("output", "ids"):
        for name in ids:
            if name not in known:
                raise CaseError(unknown("label, region or point", name, known))
        ids_with_own(known, ids)
    return ids


def _ladders(case: Case, domain: Domain) -> "tuple[Ladder, ...]":
    """Boundary layers of a case, if it asks for any."""
    if case.layers is None:
        return ()
    from bubblemesh.problem.layers import ladders_of

    return ladders_of(case.layers, domain)


def _file_length(case: Case) -> float | None:
    """Length in the case of 1 in the first file with regions that could be simplified, if there is such a file."""
    files = [keys for keys in case.domain.regions if isinstance(keys, RegionFile) and keys.simplify is None]
    return next((length for keys in files if (length := length_in_file(keys)) is not None), None)
