"""Repairs that the keys of a case ask for, and whether a repair that they do not ask for would help."""

from collections.abc import Sequence
from typing import Any

from bubblemesh.case.repair import GapKeys, RepairKeys
from bubblemesh.geometry.repair import Repair


def repair_of(keys: RepairKeys) -> Repair:
    """The repair that some keys ask for."""
    gap = keys.repair.gap if isinstance(keys.repair, GapKeys) else None
    return Repair(bool(keys.repair), gap, keys.smallest, keys.simplify)


def with_repair(keys: Any, path: Sequence[str | int]) -> Any | None:
    """The keys with ``repair: true`` where a path leads, if there is room for it and it is not asked for yet."""
    if not path:
        asks = isinstance(keys, RepairKeys) and not keys.repair
        return keys.model_copy(update={"repair": True}) if asks else None
    first, *rest = path
    try:
        inner = keys[first] if isinstance(first, int) else getattr(keys, first)
    except (AttributeError, IndexError, TypeError):
        return None
    changed = with_repair(inner, rest)
    if changed is None:
        return None
    if isinstance(first, int):
        return (*keys[:first], changed, *keys[first + 1 :])
    return keys.model_copy(update={first: changed})
