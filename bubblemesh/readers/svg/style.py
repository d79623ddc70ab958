"""Styles of an SVG drawing: attributes, rules of style sheets, and what elements inherit."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bubblemesh.readers.svg.source import COMMENT, Element
from bubblemesh.records import record

INHERITED = ("fill", "fill-rule", "clip-rule", "stroke", "visibility")
OWN = ("display", "opacity", "clip-path", "mask", "overflow", "transform-origin", "transform-box")
CSS = ("transform", "translate", "rotate", "scale")  # properties that are not attributes, or have another syntax there
IMPORTANT = re.compile(r"!\s*important\s*$")
NO_OPACITY = re.compile(r"[-+]?(0+\.?0*|\.0+)%?|-.*")
RULE = re.compile(r"([^{}]+)\{([^{}]*)\}")
PART = re.compile(r"([.#]?)([\w-]+|\*)")
COMPOUND = re.compile(r"(?:[.#]?[\w-]+|\*)(?:[.#][\w-]+)*")

StyleKeys = dict[str, str]


class Declared(NamedTuple):
    """Declarations of a rule or a style, and those marked as important."""

    usual: StyleKeys
    important: StyleKeys


@record
class _Rule:
    """Declarations, and their selector as steps from the outermost ancestor to the element itself."""

    steps: tuple[frozenset[str], ...]  # of names with their marks: path, .class, #id
    weight: tuple[int, int, int, int]  # ids, classes, tags, place in the sheet
    declared: Declared


@dataclass
class StyleSheet:
    """Rules of all style sheets of a drawing, by one of the names that elements must have."""

    rules: dict[str, list[_Rule]] = field(default_factory=dict)

    @classmethod
    def of(cls, root: Element) -> "StyleSheet":
        """The rules of a drawing; those with selectors beyond tags, classes, ids and ancestors are left out."""
        sheet = cls()
        text = "".join(COMMENT.sub("", "".join(one.text)) for one in root.all() if one.tag == "style")
        for number, (selectors, body) in enumerate(RULE.findall(text)):
            declared = _declared(body)
            for selector in selectors.split(",") if any(declared) else ():
                words = selector.replace(">", " ").split()
                if words and all(COMPOUND.fullmatch(word) for word in words):
                    steps = tuple(frozenset(mark + name for mark, name in PART.findall(word)) for word in words)
                    names = [name for step in steps for name in step if name != "*"]
                    ids, classes = (sum(name.startswith(mark) for name in names) for mark in "#.")
                    weight = (ids, classes, len(names) - ids - classes, number)
                    sheet.rules.setdefault(min(steps[-1]), []).append(_Rule(steps, weight, declared))
        return sheet

    def style(self, element: Element, around: Sequence[Element], inherited: Mapping[str, str]) -> StyleKeys:
        """Style of an element within the elements ``around`` it, the outermost first."""
        found: StyleKeys = {key: inherited[key] for key in INHERITED if key in inherited}
        given = {key: element.attributes[key].strip() for key in (*INHERITED, *OWN) if key in element.attributes}
        names = _names(element)
        rules = [rule for name in ("*", *names) for rule in self.rules.get(name, ()) if rule.steps[-1] <= names | {"*"}]
        rules = [rule for rule in rules if len(rule.steps) == 1 or _is_within(rule.steps[:-1], around)]
        declared = [rule.declared for rule in sorted(rules, key=lambda rule: rule.weight)]
        declared.append(_declared(element.attributes.get("style", "")))
        for one in (*(some.usual for some in declared), *(some.important for some in declared)):
            given |= one
        return found | {key: value for key, value in given.items() if value != "inherit"}


def is_out_of_sight(style: Mapping[str, str]) -> bool:
    """Whether an element with this style, and everything in it, is invisible."""
    return style.get("display") == "none" or bool(NO_OPACITY.fullmatch(style.get("opacity", "1")))


def _names(element: Element) -> frozenset[str]:
    """Names by which a selector may refer to an element."""
    given = element.attributes
    ids = [f"#{given['id']}"] if "id" in given else []
    return frozenset([element.tag, *ids, *(f".{name}" for name in given.get("class", "").split())])


def _is_within(steps: Sequence[frozenset[str]], around: Sequence[Element]) -> bool:
    """Whether elements around one fit the steps, in their order."""
    left: Iterator[Element] = iter(around)
    return all(any(step <= _names(element) | {"*"} for element in left) for step in steps)


def _declared(body: str) -> Declared:
    usual, important = StyleKeys(), StyleKeys()
    for key, _, value in (part.partition(":") for part in body.split(";")):
        name, plain = key.strip().lower(), IMPORTANT.sub("", value).strip()
        if name in (*INHERITED, *OWN, *CSS) and plain:
            kept = usual if IMPORTANT.search(value) is None else important
            kept[name] = plain if "url(" in plain else plain.lower()  # ids have their case
    return Declared(usual, important)
