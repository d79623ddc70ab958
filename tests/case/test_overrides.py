"""Values set over a case."""

import json

import pytest

from bubblemesh.case.overrides import applied, parsed_override
from bubblemesh.errors import CaseError

DATA = {"a": {"b": [1, {"c": 2}]}, "d": 3}


class TestOverrides:
    @pytest.mark.parametrize(
        ("option", "expected"),
        [
            ("d=0.5", {"a": {"b": [1, {"c": 2}]}, "d": 0.5}),
            ("a.b.1.c=on", {"a": {"b": [1, {"c": "on"}]}, "d": 3}),
            ("a.b.0=[1, 2]", {"a": {"b": [[1, 2], {"c": 2}]}, "d": 3}),
            ("a.new.key='3'", {"a": {"b": [1, {"c": 2}], "new": {"key": "3"}}, "d": 3}),
            ("d=x == y", {"a": {"b": [1, {"c": 2}]}, "d": "x == y"}),
            ("d=", {"a": {"b": [1, {"c": 2}]}, "d": None}),
        ],
    )
    def test_value_is_set_in_a_copy(self, option, expected):
        before = json.dumps(DATA)
        assert applied(DATA, parsed_override(option)) == expected
        assert json.dumps(DATA) == before

    @pytest.mark.parametrize(
        ("option", "message"),
        [
            ("a.b", r"--set a.b: no '=' found: write --set key.key=value"),
            ("a..b=1", r"--set a..b=1: an empty key"),
            ("=1", r"an empty key"),
            ("a.b.2=1", r"--set a.b.2: a.b has no entry 2 \(entries: 0 to 1\)"),
            ("a.b.-1=1", r"--set a.b.-1: a.b is a list"),
            ("a.b.c=1", r"--set a.b.c: a.b is a list: give the number of an entry in place of 'c'"),
            ("a.b.²=1", r"is a list"),
            ("d.e=1", r"--set d.e: d is the plain value 3"),
            ("d=[1", r"^--set d: not valid YAML: [^:]*: check brackets, colons and quotes$"),
            ("d=!!python/none x", r"--set d: the tag !!python/none"),
        ],
    )
    def test_error_names_the_option(self, option, message):
        with pytest.raises(CaseError, match=message):
            applied(DATA, parsed_override(option, of_command=True))

    @pytest.mark.parametrize(
        ("setting", "message"),
        [
            ("a.b", r"^overrides: a.b: no '=' found: write 'key.key=value'"),
            ("a.b.2=1", r"^overrides: a.b has no entry 2 "),
            ("d=[1", "^overrides: d: not valid YAML"),
        ],
    )
    def test_error_names_the_argument(self, setting, message):
        with pytest.raises(CaseError, match=message):
            applied(DATA, parsed_override(setting))
