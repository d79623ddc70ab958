"""Phrases that messages share."""

import pytest

from bubblemesh.messages import cause, closest, counted, duration, printable


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0123, "12 ms"),
        (0.9996, "1 s"),
        (12.34, "12.3 s"),
        (59.97, "1 min 0 s"),
        (119.7, "2 min 0 s"),
        (185.2, "3 min 5 s"),
        (3599.9, "1 h 0 min"),
        (7500, "2 h 5 min"),
    ],
)
def test_durations_are_in_the_unit_that_suits_them(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(("number", "text"), [(0, "no holes"), (1, "1 hole"), (2, "2 holes"), (1500, "1,500 holes")])
def test_counts_have_their_noun(number, text):
    assert counted(number, "hole") == text


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plate.yaml:3: too many", "plate.yaml:3: too many"),
        ("größe 直径 ±", "größe 直径 ±"),
        ("two\nlines", "two\nlines"),
        ("\x1b]0;title\x07 \x9b31m", r"\x1b]0;title\x07 \x9b31m"),
        ("a\rb\tc\x7f\x00", r"a\rb\tc\x7f\x00"),
        ("gpj.\u202elmay", r"gpj.\u202elmay"),
        ("name-\udcff", r"name-\udcff"),
    ],
)
def test_what_steers_a_terminal_is_shown_as_an_escape(text, expected):
    assert printable(text) == expected


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (ValueError("line 3:\nno number"), "line 3: no number"),
        (EOFError(), "it ends too early"),
        (StopIteration(), "it ends too early"),
        (AssertionError(), "it is not as its format asks for"),
    ],
)
def test_an_error_without_a_text_is_told_in_words(error, text):
    assert cause(error) == text


@pytest.mark.parametrize(
    ("word", "meant"),
    [
        ("wall a", "Wall A"),
        ("WALL A", "Wall A"),
        ("wall c", "Wall B"),
        ("inle", "inlet"),
        ("o", "outflow"),
        ("x", None),
    ],
)
def test_a_word_is_taken_for_one_of_the_same_letters_before_others_that_are_alike(word, meant):
    assert closest(word, ["Wall B", "Wall A", "inlet", "outflow"]) == meant
