"""Kinds of values that the models of a case file share."""

from collections.abc import Callable, Mapping
from copy import copy
from difflib import get_close_matches
from pathlib import PurePath
from typing import Annotated, Any, Literal, LiteralString, NamedTuple, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    GetCoreSchemaHandler,
    PlainSerializer,
    Tag,
    ValidationInfo,
)
from pydantic_core import CoreSchema, PydanticCustomError

from bubblemesh.arrays import LARGEST_NUMBER
from bubblemesh.case.parameters import filled_in, is_number
from bubblemesh.errors import CaseError
from bubblemesh.files import LARGEST_ID, LONGEST_NAME, is_writable, with_home
from bubblemesh.spacing.expression import Expression, UnknownNameError, constant
from bubblemesh.spacing.quantities import Dimension

T = TypeVar("T")

# Kind of errors that follow from another error.
FOLLOWS = "follows"

# Tags become parts of Pydantic's error locations, so they must not look like keys of the file.
TAG = "<{}>"


class Strict(BaseModel):
    """A mapping of a case file: frozen, with no keys but its own."""

    # Validators are built when needed: that of a case contains those of all its parts.
    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Once:
    """Mark at the end of an annotated type, for which Pydantic then builds its checks only once for all keys."""

    def __init__(self) -> None:
        self._schema: CoreSchema | None = None

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        if self._schema is None:
            self._schema = handler(source)
        return copy(self._schema)


def described(value: object) -> str:
    """A value as text, for messages that show what was found."""
    match value:
        case None:
            return "nothing"
        case bool():
            return str(value).lower()
        case str():
            return f"the text {_cut(repr(value))}"
        case dict():
            return f"the keys {_cut(', '.join(map(str, value)))}" if value else "an empty mapping"
        case list() | tuple():
            return f"the list {value}" if len(str(value)) <= 60 else f"a list of {len(value)} values"
    return _cut(str(value))


def _cut(text: str) -> str:
    return text if len(text) <= 60 else text[:57] + "..."


class Choice(NamedTuple):
    """A choice of several models for a mapping, which has exactly one of ``keys``."""

    what: str
    keys: tuple[str, ...]

    def tag(self, value: Any) -> str:
        """Tag by which Pydantic chooses the model of a `checked` value."""
        return TAG.format(next(key for key in self.keys if key in _keys(value)))

    def checked(self, value: Any) -> Any:
        """Check that a value is a mapping with exactly one of the keys."""
        if isinstance(value, dict | BaseModel) and sum(key in _keys(value) for key in self.keys) == 1:
            return value
        context = {"what": self.what, "keys": ", ".join(self.keys), "hint": self._hint(value)}
        raise PydanticCustomError("choice", "must be {what} with exactly one of the keys {keys}{hint}", context)

    def _hint(self, value: Any) -> str:
        words = [key for key in value if key not in self.keys] if isinstance(value, dict) else []
        close = [match for word in words for match in get_close_matches(word, self.keys, n=1)]
        return f"; did you mean {close[0]!r}?" if close else ""


def _keys(value: Any) -> Any:
    return type(value).model_fields if isinstance(value, BaseModel) else value


def list_of(count: int, what: str) -> BeforeValidator:
    """Check for a list of ``count`` entries, with a message on the whole list."""

    def check(value: Any) -> Any:
        if not isinstance(value, list | tuple) or len(value) != count:
            raise PydanticCustomError("list_of", "must be {what}", {"what": what})
        return value

    return BeforeValidator(check)


def not_empty(value: Any) -> Any:
    """Check that a list is not empty; Pydantic's own check would count the valid entries only."""
    if isinstance(value, list | tuple) and not value:
        raise PydanticCustomError("empty", "must have at least one entry")
    return value


OneOrMore = Annotated[
    Annotated[T, Tag("<one>")] | Annotated[tuple[T, ...], BeforeValidator(not_empty), Tag("<several>")],
    Discriminator(lambda value: "<several>" if isinstance(value, list | tuple) else "<one>"),
]


def several(given: T | tuple[T, ...] | None) -> tuple[T, ...]:
    """What is given under a key of one or more, as a tuple: none, one, or several."""
    if given is None:
        return ()
    return given if isinstance(given, tuple) else (given,)


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _parts(value: Any) -> Any:
    whole = _whole(value)
    if value != "auto" and (isinstance(whole, bool) or not isinstance(whole, int) or whole < 1):
        raise PydanticCustomError("parts", "must be auto, or a whole number of at least 1")
    return value


def _label(value: Any) -> Any:
    if isinstance(value, float):  # the text is not known any more: 1.1 may have been 1.10
        raise PydanticCustomError(
            "label", "must be a text or a whole number (found {found}): put it in quotes", {"found": str(value)}
        )
    return str(value) if isinstance(value, int) and not isinstance(value, bool) else value


def _refusing(is_bad: Callable[[str], bool], message: str) -> AfterValidator:
    def check(text: str) -> str:
        if is_bad(text):
            raise PydanticCustomError("text", message)
        return text

    return AfterValidator(check)


def _parameters(info: ValidationInfo) -> Mapping[str, float]:
    return {} if info.context is None else info.context


def evaluated(value: Any, info: ValidationInfo, dimension: Dimension = "length") -> Any:
    """The number that a text stands for, with parameters from the context of the validation.

    A unit has to fit the dimension.
    """
    if not isinstance(value, str) or is_number(value):  # a number in quotes is a mistake with a message of its own
        return value
    try:
        return constant(value, _parameters(info), dimension)
    except CaseError as error:
        message = "must be a number (found {found}), or an expression of the parameters: {problem}"
        raise fault_of(error, "expression", message, found=described(value)) from None


def _length(value: Any, info: ValidationInfo) -> Any:
    return evaluated(value, info)


def _evaluated_area(value: Any, info: ValidationInfo) -> Any:
    return evaluated(value, info, "area")


def _with_parameters(value: Any, info: ValidationInfo) -> Any:
    if not isinstance(value, str) or info.context is None:
        return value
    try:
        return filled_in(value, info.context)
    except CaseError as error:
        raise fault_of(error, "text") from None


def fault_of(
    error: CaseError, kind: LiteralString, message: LiteralString = "{problem}", **context: str
) -> PydanticCustomError:
    """Pydantic's error for an error of an expression or a text.

    Its kind is `FOLLOWS` if a faulty parameter is the cause; its context has the unknown name, if there is one.
    """
    if isinstance(error, UnknownNameError):
        kind, context = FOLLOWS if error.follows else kind, context | {"unknown": error.name}
    return PydanticCustomError(kind, message, context | {"problem": str(error)})


def as_expression(
    parse: Callable[[str, Mapping[str, float]], Expression],
) -> Callable[[Any, ValidationInfo], Expression]:
    """Check that parses a text or a number as an expression, with parameters from the context of the validation."""

    def check(value: Any, info: ValidationInfo) -> Expression:
        if isinstance(value, Expression):
            return value
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise PydanticCustomError("no_expression", "must be a number or an expression")
        try:
            return parse(str(value), _parameters(info))
        except CaseError as error:
            raise fault_of(error, "expression") from None

    return check


AS_GIVEN = PlainSerializer(lambda expression: expression.given, return_type=str)  # writes an expression as it was given

Constant = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST_NUMBER, le=LARGEST_NUMBER)]
# Numbers that may be expressions of the case's parameters, which are the context of the validation.
Number = Annotated[Constant, BeforeValidator(_length, json_schema_input_type=Constant | str), Once()]
_Positive = Annotated[float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST_NUMBER)]
Positive = Annotated[_Positive, BeforeValidator(_length, json_schema_input_type=_Positive | str), Once()]
PositiveArea = Annotated[_Positive, BeforeValidator(_evaluated_area, json_schema_input_type=_Positive | str), Once()]
Growth = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=1, le=2), BeforeValidator(_length)]
Fraction = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=0, le=1)]
# Whole numbers may be written 1e6.
Count = Annotated[int, Field(strict=True, gt=0), BeforeValidator(_whole)]
GroupId = Annotated[int, Field(strict=True, gt=0, le=LARGEST_ID), BeforeValidator(_whole)]
Layers = Annotated[int, Field(strict=True, gt=0, le=500), BeforeValidator(_whole)]
Parts = Annotated[Literal["auto"] | Count, BeforeValidator(_parts)]
MOST_COPIES = 100_000
_Copies = Annotated[int, Field(strict=True, ge=1, le=MOST_COPIES)]
Copies = Annotated[
    _Copies, BeforeValidator(_whole), BeforeValidator(_length, json_schema_input_type=_Copies | str), Once()
]
Point = Annotated[tuple[Number, Number], list_of(2, "a point [x, y]"), Once()]

# A text may name parameters in braces. Cases that are not from a file have no parameters: texts stay as they are.
Text = Annotated[str, BeforeValidator(_with_parameters), Once()]
Filled = Annotated[Any, BeforeValidator(_with_parameters)]  # any value, texts with their parameters
Label = Annotated[
    Text,
    BeforeValidator(_label),
    Field(min_length=1, max_length=LONGEST_NAME),
    _refusing(lambda text: not is_writable(text), "must be printable and short, without double quotes and backslashes"),
    Once(),
]
OneLabel = Annotated[Label | None, Field(description="Name of this boundary in the mesh files.")]


def is_file_name(path: str) -> bool:
    """Whether a path can be that of a file; ``.`` and ``/``, for example, are always folders."""
    return PurePath(path).name not in ("", "..")


Folder = Annotated[Text, Field(min_length=1), AfterValidator(with_home)]
InputFile = Annotated[
    Text,
    Field(min_length=1),
    AfterValidator(with_home),
    _refusing(lambda text: not is_file_name(text), "must be the name of a file, not a folder"),
    Once(),
]
FileName = Annotated[
    Text,
    Field(min_length=1, max_length=200),
    _refusing(
        lambda text: not text.isprintable() or bool({*text} & {*"/\\"}) or text.strip(". ") == "",
        "must be usable as a file name: printable, without slashes",
    ),
]
