"""Choice of features from a file with geometry, and of its unit of length."""

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from bubblemesh.errors import CaseError
from bubblemesh.messages import meant, shown
from bubblemesh.records import record

if TYPE_CHECKING:  # a case is checked without the libraries that geometry needs
    from bubblemesh.geometry.repair import Repair
    from bubblemesh.readers.features import Feature, FeatureCollection

Unit = Literal["m", "km", "cm", "mm", "um", "nm", "in", "ft", "mil"]
PartChoice = int | Literal["largest", "all"]
Open = Literal["skip"]
Purpose = Literal["rings", "lines", "points"]
METRES: dict[Unit, float] = {
    "m": 1.0,
    "km": 1e3,
    "cm": 1e-2,
    "mm": 1e-3,
    "um": 1e-6,
    "nm": 1e-9,
    "in": 0.0254,
    "ft": 0.3048,
    "mil": 2.54e-5,
}
MOST_VALUES_LISTED = 20  # of a property that one message lists
LONGEST_LIST = 200  # letters of names in a message


@record
class Selection:
    """Choice of what a case takes from a file."""

    layers: tuple[str, ...] = ()  # only features on these layers; empty for all
    feature: int | Mapping[str, Any] | None = None  # number of a feature, from 0, or properties that features must have
    scale: float = 1.0  # factor of the file's lengths
    unit: Unit | None = None  # of the file's lengths, in place of ``scale``; the case is in metres then
    part: PartChoice | None = None  # number of one of its areas, from 0, the largest first, or all of them
    join: float | None = None  # ends of curves nearer than this meet, in the file's unit
    open: Open | None = None  # what to do with curves that form no ring; by default they are an error
    repair: "Repair | None" = None  # what to change of its areas

    def factor(self, content: "FeatureCollection") -> float:
        """Factor of the file's lengths; with a unit, the factor to metres."""
        if self.unit is None:
            return self.scale
        return METRES[self.unit] if content.physical is None else content.physical.metres

    def of(self, features: "Sequence[Feature]") -> "list[Feature]":
        """The selected features; CaseError, with a list of the choices, if there are none."""
        found = self._on_layers(features)
        if isinstance(self.feature, int):
            if self.feature >= len(found):
                advice = f"a number from 0 to {len(found) - 1}" if found else "another layer, this one has none"
                raise CaseError(f"it has no feature {self.feature}: give {advice}")
            return [found[self.feature]]
        for key, value in (self.feature or {}).items():
            found = _with_property(found, key, value)
        return found

    def converted(
        self, bare: "Sequence[Feature]", convert: "Callable[[int, Feature], Feature]"
    ) -> "tuple[Feature, ...]":
        """The features, with selected ones replaced by what ``convert`` returns for their number and bare feature.

        So selecting one of very many features takes little time. The same errors as `of`.
        """
        taken = set(map(id, self.of(bare)))
        return tuple(convert(number, one) if id(one) in taken else one for number, one in enumerate(bare))

    def _on_layers(self, features: "Sequence[Feature]") -> "list[Feature]":
        known = sorted({str(one.layer) for one in features if one.layer is not None})
        for layer in self.layers:
            if layer not in known:
                advice = meant(layer, known) if known else "it has no layers, leave layer out"
                raise CaseError(f"it has no layer {layer!r}: {advice}")
        return [one for one in features if not self.layers or one.layer in self.layers]


def _with_property(features: "Sequence[Feature]", key: str, value: Any) -> "list[Feature]":
    known = sorted({name for one in features for name in one.properties})
    if key not in known:
        advice = meant(key, known) if known else "there are no properties, give a number"
        raise CaseError(f"no feature has the property {key!r}: {advice}")
    values = [one.properties.get(key) for one in features]
    found = [one for one, has in zip(features, values, strict=True) if has == value or str(has) == str(value)]
    if not found:
        there = list(dict.fromkeys(map(str, values)))
        raise CaseError(f"no feature has {key}: {value}: {meant(str(value), there[:MOST_VALUES_LISTED])}")
    return found


def one_of(known: Sequence[str], name: str | None, noun: str, key: str = "name") -> str:
    """The name of a layer, grid or the like in a file: the given one, or that of the only one.

    CaseError with a list of the names, if there are several and ``key`` chooses none of them, or if it is unknown.
    """
    if name is None and len(known) != 1:
        names = shown(", ".join(known) or "none", LONGEST_LIST)
        raise CaseError(f"has {len(known)} {noun}s ({names}): choose one by {key}")
    if name is not None and name not in known:
        raise CaseError(f"has no {noun} {name!r}: {meant(name, known) if known else 'it has none'}")
    return known[0] if name is None else name
