import dataclasses
from typing import get_type_hints

import pytest
from paths import ROOT

from bubblemesh.packing.configure import OptionError, all_options, configured, options, unused_keys
from bubblemesh.packing.methods import COLUMNS, METHODS
from bubblemesh.packing.motion import ClassicalRungeKutta
from bubblemesh.packing.termination import SelfAdaptive
from bubblemesh.packing.viscosity import Constant
from docs.make_methods import PAGE, made

NAMES = sorted(METHODS)


@pytest.mark.parametrize("name", NAMES)
def test_nothing_given_leaves_the_row_of_the_table(name):
    assert configured(name, {}, {}) == METHODS[name]


@pytest.mark.parametrize("name", NAMES)
def test_options_set_again_give_the_same_method(name):
    given = options(METHODS[name])
    assert configured(name, given["packing"], given["schedule"]) == METHODS[name]


def test_each_key_belongs_to_one_scheme():
    method = configured("accelerated", {"w1": 1.2, "seed": 7, "dt": 0.1}, {"c_out": 0.3, "c_odd": 2.0, "rounds": 4})
    assert method.placement.w1 == 1.2
    assert method.perturbation.seed == 7
    assert method.motion.dt == 0.1
    assert method.viscosity.c_out == 0.3
    assert method.odd.c_odd == 2.0
    assert method.termination.rounds == 4
    found = options(method)
    assert found["packing"]["w1"] == 1.2
    assert found["schedule"]["rounds"] == 4


def test_table_itself_stays():
    before = options(METHODS["accelerated"])
    configured("accelerated", {"w2": 0.7}, {})
    assert options(METHODS["accelerated"]) == before


def test_whole_numbers_do_for_real_ones():
    assert configured("accelerated", {"w2": 1}, {"c0": 2}).placement.w2 == 1


@pytest.mark.parametrize(
    ("packing", "schedule", "section", "key", "message"),
    [
        ({"sead": 1}, {}, "packing", "sead", "did you mean 'seed'?"),
        ({}, {"round": 3}, "schedule", "round", "did you mean 'rounds'?"),
        ({"rounds": 3}, {}, "packing", "rounds", "does not use this key: it belongs under schedule"),
        ({"w2": 0}, {}, "packing", "w2", "greater than 0 (found 0)"),
        ({"w2": -0.5}, {}, "packing", "w2", "greater than 0 (found -0.5)"),
        ({"w2": "0.6"}, {}, "packing", "w2", "valid number (found '0.6')"),
        ({"w2": float("nan")}, {}, "packing", "w2", "finite number (found nan)"),
        ({"seed": -1}, {}, "packing", "seed", "greater than or equal to 0 (found -1)"),
        ({"seed": 1.5}, {}, "packing", "seed", "valid integer (found 1.5)"),
        ({"seed": True}, {}, "packing", "seed", "valid integer (found True)"),
        ({"force": "strong"}, {}, "packing", "force", "'scaled' or 'plain' (found 'strong')"),
        ({}, {"rounds": 0}, "schedule", "rounds", "greater than 0 (found 0)"),
        ({}, {"rounds": 10**9}, "schedule", "rounds", "less than or equal to 10000 (found 1000000000)"),
        ({}, {"c0": None}, "schedule", "c0", "valid number (found None)"),
    ],
)
def test_wrong_option_is_named_with_what_was_found(packing, schedule, section, key, message):
    with pytest.raises(OptionError) as caught:
        configured("accelerated", packing, schedule)
    assert (caught.value.section, caught.value.key) == (section, key)
    assert message in caught.value.message


def test_all_counts_have_a_bound():
    """So that no count makes a run endless, or is too large for a real number."""
    whole = {option.key: option.schema for option in all_options() if option.schema.get("type") == "integer"}
    assert whole.pop("seed") == {"minimum": 0, "type": "integer"}
    assert {"passes", "rounds", "mend_attempts"} < whole.keys()
    assert all(schema["maximum"] <= 10**9 for schema in whole.values())


def test_unknown_method_is_named():
    with pytest.raises(OptionError, match="unknown method 'acelerated': did you mean 'accelerated'") as caught:
        configured("acelerated", {}, {})
    assert (caught.value.section, caught.value.key) == ("method", None)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("column", "scheme"), [(column, name) for column, one in COLUMNS.items() if one.key for name in one.circles]
)
def test_each_scheme_replaces_that_of_any_method_and_leaves_the_others(name, column, scheme):
    section, key, schemes = COLUMNS[column].section, COLUMNS[column].key, COLUMNS[column].schemes(METHODS[name])
    given = {"packing": {}, "schedule": {}} | {section: {key: scheme}}
    if scheme not in schemes:
        with pytest.raises(OptionError, match=rf"{section}\.{key}: in a metric only {'|'.join(schemes)} is possible"):
            configured(name, **given)
        return
    method, kind = configured(name, **given), schemes[scheme]
    assert type(getattr(method, column)) is kind
    others = {field.name for field in dataclasses.fields(method)} - {column}
    assert all(getattr(method, other) == getattr(METHODS[name], other) for other in others)
    assert options(method)[section][key] == scheme


def test_a_scheme_that_takes_the_place_of_another_keeps_the_parameters_of_both():
    method = configured("bpm", {}, {"rounds": 4, "termination": "self-adaptive", "tolerance": 0.01})
    assert method.termination == SelfAdaptive(rounds=4, iterations=250, tolerance=0.01)
    assert configured("fnpbs", {"dt": 0.1, "motion": "runge-kutta"}, {}).motion == ClassicalRungeKutta(dt=0.1)


def test_a_parameter_belongs_to_the_scheme_in_use():
    assert configured("fnpbs", {}, {"viscosity": "constant", "c": 2}).viscosity == Constant(2.0)
    with pytest.raises(OptionError, match="does not use this key") as caught:
        configured("fnpbs", {}, {"viscosity": "constant", "c_in": 0.1})
    assert caught.value.key == "c_in"
    with pytest.raises(OptionError, match="does not use this key"):
        configured("fnpbs", {}, {"c_odd": 2})


@pytest.mark.parametrize("key", ["k0", "force", "refresh", "shape_step", "coarsest_nodes", "delete_above"])
def test_a_parameter_of_schemes_that_circles_alone_have_is_refused_in_a_metric(key):
    with pytest.raises(OptionError, match=f"packing.{key}: it has no effect in a metric: leave it out"):
        configured("ellipses", {key: 1}, {})


def test_other_keys_that_ellipses_do_not_use_are_told_as_those_of_other_methods():
    with pytest.raises(OptionError, match=r"packing.w1: the method 'ellipses' does not use this key: .* bpm, fnpbs"):
        configured("ellipses", {"w1": 1.0}, {})
    with pytest.raises(OptionError, match=r"packing.shape_stp: .* did you mean 'shape_steps'"):
        configured("ellipses", {"shape_stp": 1.0}, {})


@pytest.mark.parametrize("found", ["constnt", 3, None, ["constant"]])
def test_an_unknown_scheme_is_named_with_the_known_ones(found):
    for method in ("fnpbs", "ellipses"):
        with pytest.raises(OptionError, match=r"no such scheme.*constant") as caught:
            configured(method, {}, {"viscosity": found})
        assert (caught.value.section, caught.value.key) == ("schedule", "viscosity")


def test_the_page_on_methods_shows_every_key_with_its_values():
    page = (ROOT / "docs/methods.md").read_text()
    for name in NAMES:
        for section, keys in options(METHODS[name]).items():
            for key, value in keys.items():
                (row,) = (line for line in page.splitlines() if line.startswith(f"| `{section}.{key}` |"))
                columns = ["key", "bpm", "fnpbs", "accelerated", "multilevel", "ellipses"]
                cells = dict(zip(columns, map(str.strip, row.split("|")[1:]), strict=False))
                assert cells[name] == str(value), key


def test_the_table_on_the_page_is_as_made_from_the_schemes():
    text = PAGE.read_text()
    assert made(text) == text


def test_every_key_of_every_method_is_described_once():
    described = {(option.section, option.key): option for option in all_options()}
    assert len(described) == len(all_options())
    assert all(option.meaning and option.schema for option in described.values())
    for name in NAMES:
        assert {(section, key) for section, keys in options(METHODS[name]).items() for key in keys} <= set(described)


def test_schemes_describe_a_parameter_that_they_share_alike():
    for column in COLUMNS.values():
        shared = {}
        for kind in (*column.circles.values(), *column.ellipses.values()):
            for field in dataclasses.fields(kind):
                hint = get_type_hints(kind, include_extras=True)[field.name]
                assert shared.setdefault(field.name, hint) == hint, field.name


def test_the_table_has_a_column_for_each_task_of_a_method():
    for method in METHODS.values():
        of_method = {name: column.schemes(method) for name, column in COLUMNS.items() if column.schemes(method)}
        assert {field.name for field in dataclasses.fields(method)} == of_method.keys()
        assert all(type(getattr(method, name)) in schemes.values() for name, schemes in of_method.items())


def test_schemes_of_ellipses_have_no_names_nor_parameters_that_those_of_circles_lack():
    """The keys that a case may have are made of those of circles."""
    for column in COLUMNS.values():
        assert column.ellipses.keys() <= column.circles.keys()
        of_circles, of_ellipses = (
            {field.name for kind in schemes.values() for field in dataclasses.fields(kind)}
            for schemes in (column.circles, column.ellipses)
        )
        assert of_ellipses <= of_circles


def test_keys_that_a_method_does_not_use_are_found():
    packing, schedule = {"leaf": 0.3, "w2": 0.7, "shaking": "none"}, {"c": 2, "c_in": 0.1, "viscosity": "saw-tooth"}
    assert unused_keys("fnpbs", packing, schedule) == [("packing", "leaf"), ("schedule", "c")]
    assert unused_keys("multilevel", packing, schedule) == [("packing", "w2"), ("schedule", "c")]
    with pytest.raises(OptionError, match="unknown method"):
        unused_keys("fast", {}, {})


def test_effort_is_that_of_annealing_and_mending_alike():
    for effort, attempts in (("fast", 12), ("normal", 12), ("best", 48)):
        method = configured("multilevel", {"effort": effort}, {})
        assert (method.annealing.effort, method.mending.effort, method.mending.attempts) == (effort, effort, attempts)
    assert configured("multilevel", {"effort": "best", "mend_attempts": 3}, {}).mending.attempts == 12
