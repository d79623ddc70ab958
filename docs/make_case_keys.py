"""All keys of the case file as Markdown, made of its JSON Schema: the second half of the site's page on case files."""

from collections.abc import Iterator, Mapping
from typing import Any

from bubblemesh.case.models import case_schema

Schema = Mapping[str, Any]
HUGE = 1e50  # bounds beyond are there for the arithmetic, not for people
BOUNDS = {"minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below"}
PLAIN = {"string": "text", "integer": "whole number", "boolean": "`true` or `false`", "object": "mapping"}


def case_keys() -> str:
    """Sections of the page: the keys of a case, then those of each mapping in it."""
    schema = case_schema()
    definitions = schema["$defs"]
    names = {name: _title(name, definition) for name, definition in definitions.items()}
    inner = {f"`{key}`": part for key, part in schema["properties"].items() if part.get("properties")}
    lines = ["## All keys", "", "Made of the schema of the case file.", "", *_table(schema, names)]
    for title, part in inner.items():
        lines += [f"### {title}", "", part.get("description", ""), "", *_table(part, names)]
    for name, definition in definitions.items():
        lines += [f"(case-{name.lower()})=", f"### {names[name]}", "", *_table(definition, names)]
    return "\n".join(lines)


def _title(name: str, definition: Schema) -> str:
    return str(definition.get("description", name)).splitlines()[0].rstrip(".")


def _table(schema: Schema, names: Mapping[str, str]) -> Iterator[str]:
    """Lines of the table of a mapping's keys; required ones are bold, also those that a base may give."""
    if not (properties := schema.get("properties")):
        return
    required = next((part["required"] for part in schema.get("anyOf", ())), schema.get("required", ()))
    yield from ("| key | value | default | meaning |", "|---|---|---|---|")
    for key, part in properties.items():
        shown = f"**`{key}`**" if key in required else f"`{key}`"
        default = part.get("default")
        default = "" if default is None or isinstance(default, Mapping) or default in ([], ()) else f"`{default}`"
        cells = (shown, _kind(part, names), default, part.get("description", ""))
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"
    yield ""


def _kind(part: Schema, names: Mapping[str, str]) -> str:
    """What a value may be, in words."""
    if reference := part.get("$ref"):
        name = reference.rpartition("/")[2]
        return f"[{names[name]}](#case-{name.lower()})"
    if "enum" in part or "const" in part:
        return ", ".join(f"`{value}`" for value in part.get("enum", [part.get("const")]))
    if choices := part.get("anyOf") or part.get("oneOf"):
        kinds = (_kind(choice, names) for choice in choices if choice.get("type") != "null")
        return " or ".join(dict.fromkeys(kind for several in kinds for kind in several.split(" or ")))
    if part.get("type") == "array":
        return _list(part, names)
    if part.get("type") in ("number", "integer"):
        return _number(part)
    if part.get("type") == "object" and isinstance(part.get("additionalProperties"), Mapping):
        return f"mapping of names to: {_kind(part['additionalProperties'], names)}"
    return PLAIN.get(part.get("type", ""), "any value")


def _list(part: Schema, names: Mapping[str, str]) -> str:
    if fixed := part.get("prefixItems"):
        return f"\\[{', '.join(_kind(item, names) for item in fixed)}\\]"
    return f"list of: {_kind(part.get('items', {}), names)}"


def _number(part: Schema) -> str:
    bounds = [f"{word} {part[key]:g}" for key, word in BOUNDS.items() if key in part and abs(part[key]) < HUGE]
    kind = PLAIN.get(part["type"], "number")
    return f"{kind} {' and '.join(bounds)}" if bounds else kind
