"""YAML as plain data, with lines."""

import pytest
from case_data import SQUARE

from bubblemesh.case import yaml as reading
from bubblemesh.case.number_lists import MARK
from bubblemesh.case.yaml import read_case_text, read_document, read_value, value_ahead
from bubblemesh.errors import CaseError, FileError


def data_of(text):
    return read_document(text, "a.yaml").data


class TestDocument:
    @pytest.mark.parametrize(
        ("text", "value"),
        [
            ("true", True),
            ("FALSE", False),
            ("on", "on"),
            ("no", "no"),
            ("Yes", "Yes"),
            ("y", "y"),
            ("~", None),
            ("Null", None),
            ("", None),
            ("010", 10),
            ("0o17", 15),
            ("0x1F", 31),
            pytest.param("0x" + "f" * 5000, float("inf"), id="hexadecimal"),
            pytest.param("0o" + "7" * 50_000, float("inf"), id="octal"),
            pytest.param("0x" + "0" * 5000 + "1", 1, id="zeros"),
            ("0b11", "0b11"),
            ("1_000", "1_000"),
            ("1e-3", 0.001),
            ("1E5", 1e5),
            (".5", 0.5),
            ("+5.", 5.0),
            ("-.inf", -float("inf")),
            (".", "."),
            ("1:30", "1:30"),
            ("2001-01-01", "2001-01-01"),
            ("'3'", "3"),
            ('"true"', "true"),
            ("!!str 3", "3"),
            ("! 3", "3"),
            ("!!float 3", 3.0),
            ("|-\n  3", "3"),
        ],
    )
    def test_scalars_follow_yaml_1_2(self, text, value):
        found = data_of(f"a: {text}\n")["a"]
        assert found == value
        assert type(found) is type(value)

    def test_nan_and_thousands_of_digits_are_numbers(self):
        data = data_of(f"a: .nan\nb: {'9' * 5000}")
        assert data["a"] != data["a"]
        assert data["b"] == float("inf")

    def test_keys_are_words(self):
        assert data_of("on: 1\n1: 2\nnull: 3") == {"on": 1, "1": 2, "null": 3}

    def test_aliases_share_their_value(self):
        assert data_of("a: &here [1, 2]\nb: *here") == {"a": [1, 2], "b": [1, 2]}

    @pytest.mark.parametrize(
        ("merge", "merged"),
        [
            ("<<: *a", {"x": 1, "y": 2}),
            ("<<: *a, x: 5", {"x": 5, "y": 2}),
            ("x: 5, <<: *a", {"x": 5, "y": 2}),
            ("!!merge <<: [*b, *a], z: 4", {"x": 1, "y": 3, "z": 4}),
            ("<<: [*a, {<<: *b, v: 7}]", {"x": 1, "y": 2, "v": 7}),
            ("<<: []", {}),
            ("'<<': *b", {"<<": {"y": 3}}),
        ],
    )
    def test_merge_keys_take_keys_of_other_mappings(self, merge, merged):
        text = f"a: &a {{x: 1, y: 2}}\nb: &b {{y: 3}}\nc: {{{merge}}}"
        assert data_of(text) == {"a": {"x": 1, "y": 2}, "b": {"y": 3}, "c": merged}

    def test_keys_of_other_mappings_have_their_own_line(self):
        document = read_document("a: &a\n  x: [1, 2]\nb:\n  <<: *a\n  y: 2\n", "a.yaml")
        assert [document.line(("b", key)) for key in ("x", "y", "z")] == [2, 5, 3]

    def test_merge_keys_do_not_copy_without_end(self, monkeypatch):
        monkeypatch.setattr(reading, "MAX_VALUES", 1000)
        lines = ["a: &a {" + ", ".join(f"k{i}: 1" for i in range(200)) + "}", "b:", *["- {<<: *a}"] * 6]
        with pytest.raises(CaseError, match=r"a.yaml:8: more than 1,000 keys are taken from other mappings"):
            data_of("\n".join(lines))

    def test_line_is_that_of_the_longest_known_part_of_a_path(self):
        document = read_document(SQUARE, "a.yaml")
        assert document.line(("domain", "outer", "labels", 2)) == 4
        assert document.line(("domain", "holes", 0, "circle", "radius")) == 6
        assert document.line(("domain", "holes", 7)) == 5
        assert document.line(("spacing", "deeper")) == 7
        assert document.line(("nothing",)) is None

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", r"a.yaml:1: the file is empty"),
            ("# only a comment\n", r"a.yaml:1: the file is empty"),
            ("[1, 2]", r"a.yaml:1: a case must be a mapping"),
            ("text", r"a.yaml:1: a case must be a mapping"),
            ("a: 1\nb: [1, 2\nc: 3\n", r"a.yaml:3: not valid YAML.*in line 2.*check the indentation"),
            ("a: 1\n\tb: 2", r"a.yaml:2: not valid YAML"),
            ("a: 'open\nb: 1\n", r"not valid YAML.*starts in line 1"),
            ("a: 1\nb: 2\na: 3\n", r"a.yaml:3: the key 'a' is given twice \(first in line 1\)"),
            ("a: 1\nb: {c: 1, 'c': 2}\n", r"a.yaml:2: the key 'c' is given twice"),
            ("a: 1\nb: !!python/object:os.system x", r"a.yaml:2: the tag !!python/object:os.system"),
            ("b: !!python/object/apply:os.system [x]", r"a.yaml:1: the tag !!python/object/apply:os.system"),
            ("b: !mine 3", r"a.yaml:1: the tag !mine"),
            ("b: !!set {x}", r"a.yaml:1: the tag !!set"),
            ("b: !!int word", r"a.yaml:1: the tag !!int does not fit"),
            ("!!python/name:os.system x: 1", r"a.yaml:1: the tag !!python/name:os.system"),
            ("a: 1\nb: &b [1, *b]", r"a.yaml:2: the alias \*b is inside its own anchor"),
            ("a: {b: 1, <<: {c: 1}, <<: {d: 1}}", r"a.yaml:1: the key '<<' is given twice"),
            ("a: {b: 1, <<: {c: 1}, b: 2}", r"a.yaml:1: the key 'b' is given twice"),
            ("a: &a 1\nb: {<<: *a}", r"a.yaml:2: << takes keys from a mapping, or a list of mappings"),
            ("a: &a {}\nb:\n  <<: [*a, [1, 2]]", r"a.yaml:3: << takes keys from a mapping"),
            ("a: &a {b: {<<: *a}}", r"a.yaml:1: the alias \*a is inside its own anchor"),
            ("a: *b", r"a.yaml:1: the alias \*b has no anchor"),
            ("a: 1\n? [1, 2]\n: 3", r"a.yaml:2: a key must be a word"),
            ("a: 1\n---\nb: 1", r"a.yaml:2: a second document"),
            ("a: 1\nb: \x07", r"a.yaml:2: not plain text \(found character U\+0007\)"),
            (
                "d\0o\0m\0",
                r"a.yaml:1: not plain text \(found character U\+0000\): it looks like UTF-16: save it as UTF-8",
            ),
            ("a: 1\nb: \udc80", r"a.yaml:2: not UTF-8"),
            ("a: " + "[" * 100_000, r"a.yaml:1: nested more than 100 deep"),
            ("a:\n" + "- " * 100_000, r"a.yaml:2: nested more than 100 deep"),
        ],
    )
    def test_error_names_the_line(self, text, message):
        with pytest.raises(CaseError, match=message):
            read_document(text, "a.yaml")

    def test_alias_bomb(self):
        lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
        lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 10)}]" for i in range(1, 30)]
        with pytest.raises(CaseError, match=r"a.yaml:7: more than 5,000,000 values"):
            data_of("\n".join(lines))

    def test_aliases_cannot_nest_without_end(self):
        lines = ["a0: &a0 [x]", *(f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 1000))]
        with pytest.raises(CaseError, match=r"nested more than 100 deep through aliases"):
            data_of("\n".join(lines))

    def test_value_alone_has_its_source_as_place(self):
        assert read_value("[1, {a: on}]", "--set a") == [1, {"a": "on"}]
        assert read_value("", "--set a") is None
        with pytest.raises(CaseError, match=r"^--set a: not valid YAML"):
            read_value("[1", "--set a")


class TestFile:
    def test_missing_file_and_folder(self, tmp_path):
        with pytest.raises(FileError, match=r"none.yaml: the case file cannot be read: No such file"):
            read_case_text(tmp_path / "none.yaml")
        with pytest.raises(FileError, match="it is a folder"):
            read_case_text(tmp_path)
        with pytest.raises(FileError, match="null"):
            read_case_text(tmp_path / "a\0b")

    def test_bytes_must_be_utf8(self, tmp_path):
        path = tmp_path / "latin.yaml"
        path.write_bytes("name: a\nlabel: Düse".encode("latin-1"))
        with pytest.raises(CaseError, match=r"latin.yaml:2: not UTF-8 text \(found byte 0xfc\)"):
            read_case_text(path)
        path.write_bytes("name: a".encode("utf-16"))
        with pytest.raises(CaseError, match=r"latin.yaml:1: not UTF-8"):
            read_case_text(path)

    def test_byte_order_mark_is_skipped(self, tmp_path):
        path = tmp_path / "mark.yaml"
        path.write_bytes(b"\xef\xbb\xbfname: a")
        assert read_case_text(path) == "name: a"


# Lists of numbers wherever they can stand, and what only looks like them.
WITH_LISTS = (
    "a: [[0, 0.5], [1, 2e-3],\n  [-3.5, 4]]\nb: 1",
    "{a: [[0, 0], [1, 1], [2, 2]], b: {c: [1.5, 2.5, 3.5, 4.5]}}",
    '{"a":[[0, 0], [1, 1], [2, 2]], "b":[1.5, 2.5, 3.5, 4.5]}',
    "a: &one [[0, 0], [1, 1], [2, 2]]\nb: [*one, *one]",
    "a:\n- [1000000, 2000000]\n- [3000000, 4000000] # comment [5000000, 6000000]\n- b: [1.25, 2.25, 3.25]\n",
    "a:\r\n  b: [[0, 0], [1, 1],\r\n    [2, 2]]\r\n  c: 3\r\nd: 4",
    "a: [1, 2, 3, 4, 5, 6, 7, " + "9" * 400 + "]",
    "a: [[0, 0], [1, 1], [[2, 2], [3, 3]]]\nb: [[], [], [], [], [], []]\nc: [01, 02, 03, 04, 05]",
    "a: [[1, 2, 3, 4], 5, 6, 7, 8]\nb: [1:30, 2, 3, 4, 5, 6, 7]\nc: [1e5, 2E+5, +3, .5, 4., -0, -0.0]",
    "a: text [1, 2, 3, 4, 5, 6]\nb: 1",
    "a: '[1, 2, 3, 4, 5, 6]'\nb: \"[1, 2, 3, 4, 5, 6]\"\nc: |\n  [1, 2, 3,\n  4, 5, 6]\nd: >\n  [1, 2, 3, 4, 5]\n",
    "a:[1, 2, 3, 4, 5, 6]: 3",
    "a: !!seq [1, 2, 3, 4, 5, 6]\nb: !!str [1, 2, 3, 4, 5, 6]",
    "a: !!seq [1, 2, 3, 4, 5, 6]",
    "[1, 2, 3, 4, 5, 6]: 1",
    "? [1, 2, 3, 4, 5, 6]\n: 1",
    "{[1, 2, 3, 4, 5, 6]}",
    "a: [1, 2, 3, 4, 5, 6]more",
    "a: [1, 2, 3, 4, 5, 6]\n  more",
    "a: [1, 2, 3, 4, 5, 6]# comment\nb: 1",
    "a: [[1, 2, 3, 4, 5, 6] [7, 8]]",
    "a: [1, 2, 3, 4, 5, 6]]\n",
    "a: [1, 2, 3, 4, 5,\n6]\na: 2",
    "a: [1, 2, 3, 4,\n5, 6]\nb: *c",
    f"a: [1, 2, 3, 4, 5, 6]\nb: {MARK}0\nc: '{MARK}0'",
    "a: " + "[" * 99 + "1, 2, 3, 4, 5, 6" + "]" * 99,
    # As lines with dashes.
    "a:\n- [1, 2]\n- [3.5, 4e2]\nb: 1",
    "a:\n  b:\n  - [1, 2]\n  - [3, 4]\n  c:\n      - [5, 6]\n      -   [7, 8]",
    "a:  # one\r\n - [1, 2]  # two\r\n\r\n# three\r\n - [3, 4]\r\n   # four\r\n - [5, 6]\r\nb: 1\r\n",
    "a:\n- [1, 2] # c\r- [3, 4]\n- [5, 6]\n- [7, 8] # d\u2028- [9, 9]\n",
    "a:\n - [1, 2]#c\n - [3, 4]#d\n",
    "a:\n - b: 1\n - [1, 2]\n - [3, 4]\n",
    "a:\n - [1, 2]\n - [3, 4]\n - 5\n",
    "a:\n - [1, 2]\n - [3, 4]\n - b\n",
    "a:\n - [1, 2]\n - [3, 4]\n -\n",
    "a:\n - [1, 2]\n - [3, 4]\n  - [5, 6]\n",
    "a:\n  - [1, 2]\n  - [3, 4]\n - [5, 6]\n",
    "a:\n - [1, 2]\n - [3, 4]\n   b\n",
    "a:\n - - [1, 2]\n   - [3, 4]\n   - [5, 6]\n - [[7, 8]]\n - []\n - []\n",
    "a:\n -\n  - [1, 2]\n  - [3, 4]\n -\n  - [5, 6]\n  - [7, 8]\n",
    "a: text\n - [1, 2]\n - [3, 4]\n",
    "a: |\n - [1, 2]\n - [3, 4]\nb: 'x\n\n - [1, 2]\n\n - [3, 4]\n'\n",
    "a: [5, 6]\n - [1, 2]\n - [3, 4]\n",
    "a: &x\n - [1, 2]\n - [3, 4]\nb: *x\nc: !!seq\n - [1, 2]\n - [3, 4]\n",
    "a: &x\n - [1, 2]\n - [3, 4]\nb: *x\n",
    "a: &x\n [[1, 2, 3, 4],\n [5, 6, 7, 8]]\nb: *x\n",
    "a: *x\n - [1, 2]\n - [3, 4]\n",
    "a: {b:\n - [1, 2]\n - [3, 4]\n}\n",
    "a: [\n - [1, 2]\n - [3, 4]\n ]\n",
    "- [1, 2]\n- [3, 4]\n",
    "a:\n - [1, 2]\n - [3, 4]\n - [5, 6] x\n",
    "a:\n - [1, 2]\n - [3, 4]\n\n # c\n - [5, 6\n",
    "a:\n - [1, 2]\n - [3, 4]\n \n -",
    "- [1, 2]\n- [3, 4]\n: 5\n",
    "? - [1, 2]\n  - [3, 4]\n: 5\n",
    "a:\n - [1, 2]\n - [3, 4]\n: 5\n",
    "a:\n - [1, 2]\n - [3, 4]\n---\n",
    "a:\n - [NaN, 2]\n - [3, -Infinity]\nb:\n - [0x1, 2]\n - [.5, 01]\n",
    "a:\n - [1, 2]\n\t\n - [3, 4]\n",
    "a:\n" + " - [1, 2]\n" * 3 + "\n" * 3,
    "a: " + "[a, " * 99 + "[1, 2, 3, 4, 5, 6]" + "]" * 99,
    "a: " + "[a, " * 98 + "[1, 2, 3, 4, 5, 6]" + "]" * 98,
    "a: " + "[" * 100_000,
)


def shown(node):
    """A node with the lines of all that is in it."""
    places = node.places.found if isinstance(node.places, reading._LatePlaces) else node.places
    pairs = places.items() if isinstance(places, dict) else enumerate(places)
    return repr(node.value), node.size, node.height, {key: (place.line, shown(place.node)) for key, place in pairs}


class TestListsOfNumbers:
    @pytest.mark.parametrize("text", WITH_LISTS, ids=lambda text: text[:30])
    def test_they_are_what_the_parser_makes_of_them(self, text):
        def outcome(read):
            try:
                return shown(read())
            except CaseError as error:
                return str(error)

        place = "line {}".format
        assert outcome(lambda: reading._root(text, place)) == outcome(lambda: reading._Reader(text, place).read())

    def test_they_are_read_at_once(self, monkeypatch):
        monkeypatch.setattr(reading, "unquoted", lambda text: pytest.fail("read one by one"))
        assert data_of("a: [[0, 0.5], [1, 1], [2, 2]]")["a"] == [[0, 0.5], [1, 1], [2, 2]]
        assert data_of("a:\n- [0, 0.5] # first\n\n- [1, 1]\n- [2, 2]\nb: {}")["a"] == [[0, 0.5], [1, 1], [2, 2]]

    def test_brackets_take_no_time(self):
        with pytest.raises(CaseError, match="nested more than 100 deep"):
            data_of("a: " + "[" * 1_000_000)


FILLED = "# ...\n" * 20_000


class TestValueAhead:
    @pytest.mark.parametrize(
        "text",
        [
            "a: {b: 'it\"s', c: [1, {}]}\n" + FILLED + "limits: {seconds: 2}",
            FILLED + "limits:\n  # a comment\n\n  seconds: 2\nb: 3",
            '{"a": "{' + "x" * 100_000 + '", "limits": {"seconds": 2}, "b": 1}',
            "{\n" + FILLED + "a: {b: 1},\n limits: {seconds: 2}}",
        ],
    )
    def test_it_is_that_of_the_whole(self, text):
        assert value_ahead(text, "limits") == data_of(text)["limits"] == {"seconds": 2}

    @pytest.mark.parametrize(
        "text",
        [
            "limits: {seconds: 2}",  # a short text is read as it is
            FILLED + "a: 'b\nlimits: {seconds: 2}\n'",
            FILLED + "a: {b: c,\nlimits: {seconds: 2}}",
            FILLED + "a: {limits: {seconds: 2}}",
            FILLED + "a: |\n  limits: {seconds: 2}",
            FILLED + "# limits: {seconds: 2}\na: 1",
            FILLED + "limits: {seconds: 2\n}",
            FILLED + "limits: *a",
            "{a: {limits: {seconds: 2}}}" + FILLED,
            "{a: 'b, limits: {seconds: 2}'}" + FILLED,
            '{a: "b, \\"limits": {seconds: 2}"}' + FILLED,
            "{a: 1} # {limits: {seconds: 2}}" + FILLED,
        ],
    )
    def test_what_is_not_surely_it_is_not_taken(self, text):
        assert value_ahead(text, "limits") is None
