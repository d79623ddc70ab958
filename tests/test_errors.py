"""Errors carry what they are about; what they say is written of that by the door through which they leave."""

import pickle

import pytest

from bubblemesh.errors import (
    COARSEN,
    NODE_LIMIT,
    CaseError,
    GeometryError,
    Key,
    NodeLimitError,
    about,
    coarsened_by,
    in_call,
    located,
    prefixed,
)

TOO_MANY = f"{NODE_LIMIT}: too many: {COARSEN} or raise the limit"


def text_within(*doors, error):
    """Text of an error that leaves through doors, the innermost first."""
    for door in doors:
        with pytest.raises(type(error)), door:
            raise error
    return str(error)


def test_a_case_and_a_call_name_the_limit_on_nodes_each_in_its_way():
    assert text_within(located("a.yaml"), error=NodeLimitError(TOO_MANY)) == (
        "a.yaml: limits.max_nodes: too many: coarsen the spacing or raise the limit"
    )
    assert text_within(in_call("mesh()", "geometry", "max_nodes"), error=NodeLimitError(TOO_MANY, "the metric")) == (
        "mesh(): max_nodes: too many: coarsen the metric or raise the limit"
    )


def test_of_two_advices_on_fewer_nodes_the_inner_one_is_given():
    doors = coarsened_by("ask for less"), coarsened_by("ask for a larger error")
    assert text_within(*doors, error=NodeLimitError(TOO_MANY)).endswith(": ask for less or raise the limit")


def test_what_stands_before_a_text_is_no_part_of_it():
    error = NodeLimitError(TOO_MANY)
    doors = prefixed("{a}.svg"), coarsened_by("ask for less"), in_call("mesh()", "geometry", "max_nodes")
    assert text_within(*doors, error=error) == "mesh(): {a}.svg: max_nodes: too many: ask for less or raise the limit"
    assert error.where == ("mesh()", "{a}.svg")
    assert error.text == "max_nodes: too many: ask for less or raise the limit"


def test_an_error_of_another_process_is_named_by_the_door_here():
    error = pickle.loads(pickle.dumps(NodeLimitError(TOO_MANY, "the metric")))
    assert text_within(prefixed("part 1"), in_call("mesh()", "geometry", "max_nodes"), error=error) == (
        "mesh(): part 1: max_nodes: too many: coarsen the metric or raise the limit"
    )


@pytest.mark.parametrize(
    ("door", "text"),
    [
        (in_call("mesh()", "geometry", "max_nodes"), "mesh(): holes: rings cross"),
        (located("a.yaml", {("holes",): "a.yaml:3"}.get), "a.yaml:3: domain: rings cross"),
    ],
)
def test_errors_of_the_geometry_say_what_they_are_about(door, text):
    assert text_within(about(Key(["holes"])), door, error=GeometryError("rings cross")) == text


def test_other_errors_are_about_the_call_or_the_source():
    assert text_within(in_call("mesh()", "geometry", "max_nodes"), error=CaseError("no")) == "mesh(): no"
    assert text_within(located("a.yaml"), error=GeometryError("no")) == "a.yaml: domain: no"
