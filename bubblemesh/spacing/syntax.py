"""From the text of an expression to its syntax tree, and messages that point into the text."""

import ast
from textwrap import shorten

from bubblemesh.errors import CaseError
from bubblemesh.process.shared import warnings_are
from bubblemesh.spacing.quantities import is_quantity, quantity_within

MAX_CHARACTERS = 10_000

# What people write who come from other languages, and what is meant here.
HINTS: dict[type[ast.AST], str] = {
    ast.BitXor: "'^' is not a power here: use ** for powers",
    ast.BitAnd: "'&' is not an operator here: use 'and'",
    ast.BitOr: "'|' is not an operator here: use 'or'",
    ast.Invert: "'~' is not an operator here: use 'not'",
}

FORBIDDEN: dict[type[ast.AST], str] = {
    ast.Set: "a name in braces, which are for texts such as part-{r}.dxf,",
    ast.Attribute: "a dot between names",
    ast.Subscript: "an index in brackets",
    ast.Starred: "unpacking with *",
    ast.Lambda: "a lambda",
    ast.NamedExpr: "an assignment",
    ast.JoinedStr: "text in quotes",
    ast.List: "a list",
    ast.Tuple: "a comma outside a call",
}


def parsed(text: str) -> ast.expr:
    """Syntax tree of ``text``, of a quantity with a unit a name; columns count in characters of the text as one line.

    CaseError if the text is no expression; the message names the column and the part of the text.
    """
    if not text:
        raise CaseError("the expression is empty: give a number or a formula in x and y")
    if len(text) > MAX_CHARACTERS:
        raise CaseError(f"the expression has {len(text):,} characters: at most {MAX_CHARACTERS:,} are allowed")
    if "\\" in text:
        raise _error("no backslashes in an expression", text, text.index("\\"))
    if (comment := _comment(text)) is not None:
        raise _error("no comments in an expression", text, comment)
    if is_quantity(text):
        return ast.Name(text, lineno=1, col_offset=0, end_lineno=1, end_col_offset=len(text))
    try:
        with warnings_are("error"):
            return ast.parse(_one_line(text), mode="eval").body
    except (RecursionError, MemoryError):
        raise CaseError(f"the expression is nested too deeply: {shown(text)}") from None
    except SyntaxError as error:
        if (quantity := quantity_within(text)) is not None:
            told = (
                "a unit stands only behind a number that is the whole value: write parameters: "
                f"{{far: {quantity[0]}}} and here far, or * to multiply"
            )
            raise _error(told, text, *quantity.span()) from None
        # The parser gives column 0 where the text ends too early.
        column = min(error.offset or len(text), len(text)) - 1
        raise _error(f"not an expression ({shorten(error.msg, 100)})", text, column) from None
    except ValueError as error:
        raise CaseError(f"the expression is not readable text ({error}): {shown(text)}") from None


def _one_line(text: str) -> str:
    """The text with all kinds of blanks as spaces, of as many characters."""
    return "".join(" " if character.isspace() else character for character in text)


def _comment(text: str) -> int | None:
    """Column where a comment begins, at a # outside quotes."""
    quote = ""
    for column, character in enumerate(text):
        if character == "#" and not quote:
            return column
        if character in "\"'" and quote in ("", character):
            quote = "" if quote else character
    return None


def shown(part: str) -> str:
    """A part of an expression as messages show it."""
    return repr(part if len(part) <= 60 else part[:57] + "...")


def _error(problem: str, text: str, start: int, end: int | None = None) -> CaseError:
    return CaseError(f"column {start + 1}: {problem}, at {shown(text[start:end])}")


def error_at(node: ast.expr, text: str, problem: str) -> CaseError:
    """Error for a problem with a node of the tree of ``text``."""
    # The tree counts bytes of UTF-8, of which other blanks than a space have several.
    encoded = _one_line(text).encode()
    start, end = (len(encoded[:offset].decode()) for offset in (node.col_offset, node.end_col_offset))
    return _error(problem, text, start, end)
