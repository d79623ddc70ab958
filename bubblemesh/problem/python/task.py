"""Tasks of Python programs: the method with its options, limits and demands, as arguments of `bubblemesh.mesh`."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from bubblemesh.arrays import is_real, is_whole
from bubblemesh.case.layers import layer_entries
from bubblemesh.case.metric import AnyMetric, metric_entries
from bubblemesh.case.models import IN_METRIC, MULTILEVEL, Limits
from bubblemesh.errors import CaseError
from bubblemesh.geometry.domain import Domain
from bubblemesh.packing.configure import OptionError, configured
from bubblemesh.packing.method import Method
from bubblemesh.problem.problem import Task
from bubblemesh.problem.python.numbers import plain_value
from bubblemesh.records import record

if TYPE_CHECKING:
    from bubblemesh.layers.ladder import Ladder

MAX_NODES = Limits().max_nodes


@record(kw_only=True)
class MeshOptions:
    """Options of a mesh beside its domain and spacing; fields are arguments of `bubblemesh.mesh`."""

    method: str | None = None  # without one, that of a case that names none
    packing: Mapping[str, Any] | None = None
    schedule: Mapping[str, Any] | None = None
    seed: int | None = None
    effort: str | None = None
    max_nodes: int = MAX_NODES
    nodes: int | None = None
    angle_min: float = 0.0
    largest: float | None = None
    layers: Sequence[Mapping[str, Any]] = ()
    metric: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None

    @property
    def method_name(self) -> str:
        """Name of the method: with a metric it is the one that packs it, unless another one is given."""
        usual = MULTILEVEL if self.metric is None else IN_METRIC
        return usual if self.method is None else self.method

    def metrics(self) -> tuple[AnyMetric, ...]:
        """Metrics as a case file has them, if there are any; CaseError if a key of one is wrong."""
        return () if self.metric is None else metric_entries(plain_value(self.metric))

    def ladders(self, domain: Domain) -> "tuple[Ladder, ...]":
        """Boundary layers in the domain; CaseError if a key or a label of one is wrong."""
        if isinstance(self.layers, Mapping):
            raise CaseError("layers: must be a list of mappings, one for each layer (found one mapping)")
        entries = plain_value(self.layers)
        if entries == []:
            return ()
        # Imported here since few meshes have layers.
        from bubblemesh.problem.layers import ladders_of

        return ladders_of(layer_entries(entries), domain)

    def task(self) -> Task:
        """The task, named ``mesh``; CaseError, which begins with the argument, if a value of one is impossible."""
        self._check()
        method = self._method()
        return Task(
            name="mesh",
            method_name=self.method_name,
            configured=lambda: method,
            max_nodes=int(self.max_nodes),
            time_limit=None,
            settings={"method": self.method_name, "limits": {"max_nodes": int(self.max_nodes)}},
            least_angle=float(self.angle_min),
            largest=np.inf if self.largest is None else float(self.largest),
            corners="corners=30",
        )

    def _check(self) -> None:
        """Check the kinds and ranges of the arguments; CaseError with the first that is wrong."""
        if self.method is not None and not isinstance(self.method, str):
            raise CaseError(f"method: must be the name of one (found {self.method!r})")
        if self.nodes is not None and not is_whole(self.nodes, 3):
            raise CaseError(f"nodes: must be a whole number of at least 3 (found {self.nodes!r})")
        if not is_whole(self.max_nodes, 1):
            raise CaseError(f"max_nodes: must be a whole number greater than 0 (found {self.max_nodes!r})")
        if not is_real(self.angle_min) or not 0 <= self.angle_min <= 30:
            raise CaseError(f"angle_min: must be from 0 to 30 degrees (found {self.angle_min!r})")
        if self.largest is not None and not (is_real(self.largest) and 0 < self.largest < np.inf):
            raise CaseError(f"largest: must be an area greater than 0 (found {self.largest!r})")
        for name, given, usual in (("packing", self.packing, "seed"), ("schedule", self.schedule, "rounds")):
            if given is not None and not isinstance(given, Mapping):
                raise CaseError(f"{name}: must be a mapping such as {{{usual!r}: 3}} (found {type(given).__name__})")
            for key in given or ():
                if not isinstance(key, str):
                    raise CaseError(f"{name}: must have names as its keys (found {key!r})")

    def _method(self) -> Method:
        """The method with its options; ``seed`` and ``effort`` are short for those of ``packing``."""
        short = {
            key: plain_value(each) for key, each in (("seed", self.seed), ("effort", self.effort)) if each is not None
        }
        packing, schedule = plain_value(self.packing or {}), plain_value(self.schedule or {})
        for key in short.keys() & packing.keys():
            raise CaseError(f"{key}: is given twice, also as packing[{key!r}]: drop one of them")
        try:
            return configured(self.method_name, packing | short, schedule)
        except OptionError as error:
            place = error.key if error.key in short else ".".join(filter(None, (error.section, error.key)))
            raise CaseError(f"{place}: {error.message}") from None
