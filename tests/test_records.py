"""Records behave as frozen dataclasses do."""

import pickle
from copy import copy, deepcopy
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, is_dataclass, replace
from functools import cached_property
from typing import ClassVar

import pytest

from bubblemesh.records import record


def made(decorated):
    """The same class by one decorator or the other."""

    @decorated
    class Made:
        steps: ClassVar[int] = 0
        x: int
        names: list = field(default_factory=list)
        note: str = field(default="", compare=False, repr=False)
        seen: dict = field(default_factory=dict, hash=False)

        @cached_property
        def double(self):
            return 2 * self.x

    return Made


TWINS = pytest.mark.parametrize("kind", [made(record), made(dataclass(frozen=True))], ids=["record", "dataclass"])


@record
class Place:
    """A place."""

    x: float
    y: float = 0.0

    def __repr__(self):
        return "here"


@record
class High(Place):
    """A place with a height."""

    z: float = 1.0


@record
class Near:
    """A number that equals others near to it."""

    x: float

    def __eq__(self, other):
        return abs(self.x - other.x) < 1


@record(eq=False)
class Single:
    """What equals nothing but itself."""

    x: float


@record(kw_only=True)
class Figures:
    """Fields by their names alone, in any order of those with defaults."""

    least: float | None = None
    mean: float


@TWINS
def test_records_are_shown_and_compared_as_frozen_dataclasses_are(kind):
    one = kind(1, ["a"], note="this", seen={1: 2})
    assert repr(one) == "made.<locals>.Made(x=1, names=['a'], seen={1: 2})"
    assert one == kind(1, ["a"], note="that", seen={1: 2})
    assert one != kind(1, ["a"], seen={})
    assert one != (1, ["a"], {1: 2})
    assert hash(kind(1, (), seen={})) == hash(kind(1, (), seen={1: 2}, note="that")) == hash((1, ()))
    with pytest.raises(TypeError, match="unhashable"):
        hash(one)


@TWINS
def test_fields_of_a_record_are_set_once(kind):
    one = kind(1)
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'x'"):
        one.x = 2
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'steps'"):
        one.steps = 2
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'other'"):
        one.other = 2
    with pytest.raises(FrozenInstanceError, match="cannot delete field 'x'"):
        del one.x
    assert (one.x, one.double) == (1, 2)


def test_the_functions_of_dataclasses_know_records():
    one = High(1.0, z=3.0)
    assert is_dataclass(one)
    assert [field.name for field in fields(one)] == ["x", "y", "z"]
    assert asdict(replace(one, y=2.0)) == {"x": 1.0, "y": 2.0, "z": 3.0}
    match one:
        case High(x, y, z):
            assert (x, y, z) == (1.0, 0.0, 3.0)


def test_fields_may_be_given_by_their_names_alone():
    assert Figures(mean=2.0) == Figures(least=None, mean=2.0)
    with pytest.raises(TypeError, match="positional"):
        Figures(1.0, 2.0)


def test_records_of_different_classes_differ():
    assert Place(1.0) != High(1.0)
    assert {Place(1.0), Place(1.0), High(1.0)} == {Place(1.0), High(1.0)}


def test_methods_of_its_own_stay():
    assert repr(Place(1.0)) == "here"
    assert repr(High(1.0)) == "High(x=1.0, y=0.0, z=1.0)"


def test_a_record_with_an_equality_of_its_own_has_a_hash():
    assert Near(1.0) == Near(1.5)
    assert hash(Near(1.0)) == hash(Near(1.0))


def test_records_without_equality_are_compared_by_identity():
    one = Single(1.0)
    assert one == one
    assert one != Single(1.0)
    assert len({one, Single(1.0)}) == 2


@pytest.mark.parametrize("twin", [copy, deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_copies_are_equal(twin):
    assert twin(High(1.0, 2.0)) == High(1.0, 2.0)
