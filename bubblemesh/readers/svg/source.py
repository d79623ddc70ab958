"""Check of the source of an SVG drawing before it is read, since the library silently skips what it cannot read."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from xml.parsers import expat

from bubblemesh.errors import CaseError, LimitError
from bubblemesh.messages import shown

SVG = "http://www.w3.org/2000/svg"
HREFS = ("href", "http://www.w3.org/1999/xlink href")
# Possessive quantifiers (*+, ++) do not backtrack, so that the time is proportional to the length of any text.
NUMBER = r"[-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d++)?"
LENGTH = re.compile(rf"\s*+{NUMBER}\s*+(?:px|pt|pc|mm|cm|in|em|ex|rem|vw|vh|%)?\s*+")
NUMBERS = re.compile(rf"[\s,]*+(?:{NUMBER}[\s,]*+)*+")
TOKEN = re.compile(rf"[MmZzLlHhVvCcSsQqTtAa]|{NUMBER}|[\s,]+")
TRANSFORM = re.compile(r"[\s,]*(?:(?:matrix|translate|scale|rotate|skewX|skewY)\s*\([^()]*\)[\s,]*)*")
STEP = re.compile(r"(\w+)\s*\(([^()]*)\)")  # of a transform
STEPS = {"matrix": (6,), "translate": (1, 2), "scale": (1, 2), "rotate": (1, 3), "skewX": (1,), "skewY": (1,)}
ARGUMENTS = {"M": 2, "L": 2, "H": 1, "V": 1, "C": 6, "S": 4, "Q": 4, "T": 2}  # but arcs
LENGTHS = {
    "rect": ("x", "y", "width", "height", "rx", "ry"),
    "circle": ("cx", "cy", "r"),
    "ellipse": ("cx", "cy", "rx", "ry"),
    "line": ("x1", "y1", "x2", "y2"),
    "svg": ("x", "y", "width", "height"),
}
SIZES = {"svg": ("width", "height"), "rect": ("width", "height"), "circle": ("r",), "ellipse": ("rx", "ry")}
UNDRAWN = ("defs", "symbol", "clipPath", "mask", "marker", "pattern")
MOST_ELEMENTS = 200_000  # drawn elements; those used several times count each time
CHARACTERS = 100  # so many characters of attributes count as one more element
LONGEST_ENTITY = 1000  # characters: drawing programs use entities for addresses
MOST_STYLED = 200_000_000  # characters of styles that are searched for all elements together
# The parts of style sheets. With other text, the library would try to match from each of its characters on.
RULE = re.compile(r"[^{]*+\{[^}]*+\}")
COMMENT = re.compile(r"/\*[\s\S]*?\*/|//.*$", re.MULTILINE)
LONGEST_REST = 200  # characters
DEEPEST = 100


@dataclass
class Element:
    """An element with its line and what it contains."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)
    text: list[str] = field(default_factory=list)  # in pieces

    @property
    def name(self) -> str:
        """Name of the element in messages."""
        label = self.attributes.get("id")
        return f"{self.tag} {shown(label, 40)!r} in line {self.line}" if label else f"{self.tag} in line {self.line}"

    def all(self) -> Iterator["Element"]:
        """The element and all within it."""
        yield self
        for child in self.children:
            yield from child.all()

    @property
    def size(self) -> int:
        """Number of simple elements that take as long to draw."""
        classes = self.attributes.get("class", "").split()
        return 1 + len(classes) + sum(map(len, self.attributes.values())) // CHARACTERS


def view_box(element: Element) -> tuple[float, float, float, float] | None:
    """x, y, width and height in the viewBox of an element, with any separators; None if there is none."""
    numbers = [float(number) for number in re.findall(NUMBER, element.attributes.get("viewBox", ""))]
    return (numbers[0], numbers[1], numbers[2], numbers[3]) if len(numbers) == 4 else None


def checked_drawing(content: bytes) -> Element:
    """The root of a drawing, after a check that all of it can be read.

    CaseError, with the element and line, if numbers, paths or transforms are invalid or an element uses itself;
    LimitError if the drawing is too large.
    """
    root = _parsed(content)
    if root.tag != "svg":
        raise CaseError(f"its root element is {shown(root.tag, 40)!r}: no SVG drawing")
    for element in root.all():
        _check(element)
    by_id = {element.attributes["id"]: element for element in root.all() if "id" in element.attributes}
    known: dict[int, int] = {}
    drawn = _drawn(root, by_id, (), known)
    for element in root.all():
        if element.tag == "clipPath" and _drawn(element, by_id, (), known) > MOST_ELEMENTS:
            raise too_much_clipping()
    if drawn > MOST_ELEMENTS:
        raise LimitError(f"its uses draw more than {MOST_ELEMENTS:,} elements, or as much in long ones: simplify it")
    sheet = sum(_sheet_size(element) for element in root.all() if element.tag == "style")
    if drawn * sheet > MOST_STYLED:
        raise LimitError("its style sheet is too long for so many elements: write the shapes without styles")
    return root


def too_much_clipping() -> LimitError:
    """Error for clips that draw too many elements, alone or all together."""
    return LimitError(f"its clips draw more than {MOST_ELEMENTS:,} elements: remove some of them, or simplify it")


def _parsed(content: bytes) -> Element:
    """The root element of a drawing; CaseError if it is not valid XML, LimitError if it has too many elements."""
    parser = expat.ParserCreate(namespace_separator=" ")
    open_ = [Element("", {}, 0)]

    def start(tag: str, attributes: dict[str, str]) -> None:
        if len(open_) > DEEPEST:
            raise CaseError(f"line {parser.CurrentLineNumber}: elements are nested more than {DEEPEST} deep")
        element = Element(tag.removeprefix(f"{SVG} "), attributes, parser.CurrentLineNumber)
        open_[-1].children.append(element)
        open_.append(element)

    parser.StartElementHandler = start
    parser.EndElementHandler = lambda tag: open_.pop()
    parser.EntityDeclHandler = _check_entity
    parser.CharacterDataHandler = lambda text: open_[-1].text.append(text)
    try:
        parser.Parse(content, True)
    except expat.ExpatError as error:
        raise CaseError(f"line {error.lineno}: not valid XML: {expat.ErrorString(error.code)}") from None
    return open_[0].children[0]


def _check_entity(name: str, is_parameter: int, value: str | None, *place: str | None) -> None:
    """CaseError for an entity that contains others or is long: used often, it would fill the memory."""
    if value is None or "&" in value or "%" in value or len(value) > LONGEST_ENTITY:
        raise CaseError(f"the entity {shown(name, 40)!r} is not read: write what it stands for in its places")


def _sheet_size(element: Element) -> int:
    """Number of characters of a style sheet; CaseError if it is not made of rules."""
    text = "".join(element.text)
    if text.rfind("/*") > text.rfind("*/"):
        raise CaseError(f"{element.name}: a comment in it has no end: close it by */")
    plain = COMMENT.sub("", text)
    end = 0
    while rule := RULE.match(plain, end):
        end = rule.end()
    empty = max((len(before) - before.rfind("}") for before in plain.split("{}")[:-1]), default=0)
    if max(len(plain[end:].strip()), empty) > LONGEST_REST:
        raise CaseError(f"{element.name}: it is not made of rules with braces: correct it, or remove it")
    return len(text)


def _check(element: Element) -> None:
    """Check the attributes on which the shape of an element depends."""
    _check_lengths(element)
    _check_numbers(element)
    if element.tag == "path":
        _check_path(element)
    _check_transform(element, element.attributes.get("transform", ""))


def _check_transform(element: Element, transform: str) -> None:
    fault = None if TRANSFORM.fullmatch(transform) else _fault(TRANSFORM, transform)
    for step in STEP.finditer(transform):
        if fault is None and len(re.findall(NUMBER, step[2])) not in STEPS[step[1]]:
            fault = repr(shown(step[0], 40))
    if fault is not None:
        raise CaseError(f"{element.name}: its transform is not valid: {fault}: correct it")


def _check_lengths(element: Element) -> None:
    given = element.attributes
    for key in LENGTHS.get(element.tag, ()):
        if key in given and not LENGTH.fullmatch(given[key]) and given[key] != "auto":
            raise CaseError(f"{element.name}: {key} is no length: {shown(repr(given[key]))}")
    for key in SIZES.get(element.tag, ()):
        if given.get(key, "").strip().startswith("-"):
            raise CaseError(f"{element.name}: {key} is negative: {shown(repr(given[key]))}")


def _check_numbers(element: Element) -> None:
    given = element.attributes
    if element.tag in ("polygon", "polyline"):
        points = given.get("points", "")
        if not NUMBERS.fullmatch(points) or len(re.findall(NUMBER, points)) % 2:
            raise CaseError(f"{element.name}: its points are no pairs of numbers: {_fault(NUMBERS, points)}")
    if element.tag == "svg" and "viewBox" in given:
        box = view_box(element)
        if not NUMBERS.fullmatch(given["viewBox"]) or box is None or min(box[2:]) <= 0:
            raise CaseError(f"{element.name}: its viewBox is not valid: {shown(repr(given['viewBox']))}")


def _fault(valid: re.Pattern[str], text: str) -> str:
    """The rest of a text from the place where it becomes invalid."""
    match = valid.match(text)
    return repr(shown(text[match.end() if match and match.end() < len(text) else 0 :], 40))


def _check_path(element: Element) -> None:
    """Check that a path consists of commands with the right number of arguments."""
    text = element.attributes.get("d", "")
    at, command, numbers = 0, "", 0
    for token in TOKEN.finditer(text):
        if token.start() != at:
            break
        at = token.end()
        word = token.group()
        if word.isalpha():
            _check_arguments(element, command, numbers, token.start())
            command, numbers = word, 0
        elif not word.isspace() and word.strip(" \t\r\n,"):
            numbers += 1
    if at < len(text):
        raise CaseError(f"{element.name}: its path is not valid from here on: {shown(text[at:], 40)!r}")
    _check_arguments(element, command, numbers, at)


def _check_arguments(element: Element, command: str, numbers: int, at: int) -> None:
    needed = ARGUMENTS.get(command.upper())
    wrong = numbers > 0 if command in ("", "Z", "z") else needed is not None and (numbers == 0 or numbers % needed)
    if wrong:
        before = shown(element.attributes["d"][max(at - 40, 0) : at], 40)
        raise CaseError(f"{element.name}: its path has {numbers} numbers for {command or 'no command'}: {before!r}")


def _drawn(element: Element, by_id: dict[str, Element], around: tuple[str, ...], known: dict[int, int]) -> int:
    """Size of all elements that are drawn for an element; CaseError if it uses itself."""
    if id(element) in known:
        return known[id(element)]
    inside = (*around, element.attributes["id"]) if "id" in element.attributes else around
    count = element.size + sum(
        _drawn(child, by_id, inside, known) for child in element.children if child.tag not in UNDRAWN
    )
    if element.tag == "use":
        target = next((element.attributes[key] for key in HREFS if key in element.attributes), "").removeprefix("#")
        if target in inside:
            raise CaseError(f"{element.name}: it uses {shown(target, 40)!r}, which it is a part of: remove it")
        if target in by_id:
            count += _drawn(by_id[target], by_id, inside, known)
    known[id(element)] = count
    return count
