"""Spacings that break meshers, through the whole program: an error with its place."""

import re

import numpy as np
import pytest
from bad_cases import SQUARE, UNIT, case, circle, meshed, polygon
from commands import refused
from invariants import check_mesh

UNUSABLE = {
    "0*x": r"spacing: is 0 at \([01]\S*, [01]\S*\): it has to be positive and finite",
    "-1 - x": r"spacing: is -[12]\S* at \([01]\S*, [01]\S*\)",
    "x - 0.5": r"spacing: is -0\.\d+ at \([01]\S*, [01]\S*\)",
    "0/(x - x)": r"spacing: is nan at \([01]\S*, [01]\S*\)",
    "1/0": r"spacing: is inf at \([01]\S*, [01]\S*\)",
    "1e308 + 0*x": r"spacing: is 1e\+308 at \([01]\S*, [01]\S*\): it has to be positive and finite \(at most 1e\+70\)",
    "(-1 - x)**0.5": r"spacing: is nan at \([01]\S*, [01]\S*\)",
    "9**9**9**9": r"spacing: is inf at \([01]\S*, [01]\S*\)",
    "abs(x - 0.3) + 0*y": r"spacing: (is 0|falls to \S+) at \(0\.3\d*, 0\.\d+\)",
}


@pytest.mark.parametrize(("spacing", "text"), UNUSABLE.items())
def test_a_spacing_that_is_none_somewhere(here, spacing, text):
    assert re.search(text, refused(here, SQUARE.format(f'"{spacing}"'), 2))


EXPRESSIONS = {
    "-1": "must be greater than 0 (found -1)",
    "0": "must be greater than 0 (found 0)",
    ".nan": "must be a finite number (found nan)",
    ".inf": "must be a finite number (found inf)",
    "true": "must be a number, an expression in x and y, or a mapping",
    "1j": "column 1: only real numbers are allowed in an expression",
    "x.real": "column 1: a dot between names is not allowed",
    "__import__('os')": "column 1: unknown function '__import__'",
    "open('a', 'w')": "column 1: unknown function 'open'",
    "'''a'''": "column 1: only real numbers are allowed in an expression",
    "'[x]'": "column 1: a list is not allowed in an expression",
    "'lambda: 1'": "a lambda is not allowed",
    "max(*[1])": "max takes 2 or more arguments",
    "sqrt(x": "not an expression",
    "x" + "+x" * 500_000: "the expression has 1,000,001 characters: at most 10,000 are allowed",
    "(" * 4000 + "x" + ")" * 4000: "not an expression",
    "-" * 5000 + "x": "the expression is nested too deeply",
    "min(x," * 300 + "1" + ")" * 300: "not an expression",
}


@pytest.mark.parametrize(("spacing", "text"), EXPRESSIONS.items(), ids=[key[:20] for key in EXPRESSIONS])
def test_an_expression_that_is_not_allowed_is_refused_at_once(here, spacing, text):
    message = refused(here, SQUARE.format(spacing), 2)
    assert message.startswith("error: case.yaml:2: spacing: ")
    assert text in message
    assert len(message) < 500


@pytest.mark.parametrize(
    ("spacing", "limit", "needed"),
    [("0.01", 100, 11_900), ("1e-4 + x", 1000, None), ("1e-9", 2_000_000, 1.15e18)],
)
def test_a_spacing_that_needs_too_many_nodes_is_refused_before_packing(here, spacing, limit, needed):
    message = refused(here, SQUARE.format(spacing) + f"limits: {{max_nodes: {limit}}}\n", 6)
    found = re.search(rf"limits.max_nodes: .* about (\S+) nodes, more than the limit of {limit}: coarsen", message)
    assert float(found.group(1)) > limit
    if needed is not None:
        assert float(found.group(1)) == pytest.approx(needed, rel=0.05)


def test_a_spacing_that_needs_more_nodes_than_can_be_counted_is_refused(here):
    message = refused(here, SQUARE.format("1e-300"), 6)
    assert "limits.max_nodes: the spacing needs more nodes than can be counted, more than the limit" in message


def test_the_limit_counts_the_nodes_that_short_edges_ask_for(here):
    angles = np.linspace(0, 2 * np.pi, 400, endpoint=False)
    ring = {"polygon": np.column_stack([np.cos(angles), np.sin(angles)]).tolist()}
    assert "max_nodes" in refused(here, case({"outer": ring}, 0.5, limits={"max_nodes": 300}), 6)


@pytest.mark.long
@pytest.mark.parametrize("ring", [UNIT, circle(0, 0, 1), polygon((0, 0), (1, 0), (0, 1))])
def test_a_spacing_larger_than_the_domain(here, ring):
    report, mesh = meshed(here, case({"outer": ring}, 100))
    check_mesh(mesh)
    assert report["nodes"] <= 8
    assert report["warnings"]
