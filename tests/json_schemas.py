"""A check of data against a JSON Schema, as editors make it, with the keywords that the schema of cases has."""

import math

TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "null": type(None),
    "number": (int, float),
    "integer": (int, float),
}
WITHOUT_MEANING = {"$schema", "$defs", "title", "description", "default", "ge", "le"}


def faults(value, schema, root=None, path=()):
    """Paths and keywords of all that a schema does not allow; a keyword that is not known here is an error."""
    root = schema if root is None else root
    for keyword, given in schema.items():
        if keyword in WITHOUT_MEANING:
            continue
        if keyword == "$ref":
            yield from faults(value, root["$defs"][given.rpartition("/")[2]], root, path)
        elif keyword == "anyOf":
            if all(any(True for _ in faults(value, one, root, path)) for one in given):
                yield path, keyword
        elif not CHECKS[keyword](value, given, schema):
            yield path, keyword
    for key, part, inner in _parts(value, schema):
        yield from faults(part, inner, root, (*path, key))


def _parts(value, schema):
    """Keys, values and schemas of what is inside of a value."""
    if isinstance(value, dict):
        others = schema.get("additionalProperties", {})
        for key, part in value.items():
            inner = schema.get("properties", {}).get(key, others)
            yield key, part, inner if isinstance(inner, dict) else {}
    if isinstance(value, list):
        first = schema.get("prefixItems", [])
        for number, part in enumerate(value):
            yield number, part, first[number] if number < len(first) else schema.get("items", {})


def _is(value, kind):
    if isinstance(value, bool) and kind != "boolean":
        return False
    return isinstance(value, TYPES[kind]) and (kind != "integer" or (math.isfinite(value) and value == int(value)))


def _of_numbers(holds):
    return lambda value, given, schema: not _is(value, "number") or holds(value, given)


def _of(kind, holds):
    return lambda value, given, schema: not isinstance(value, kind) or holds(value, given)


CHECKS = {
    "type": lambda value, given, schema: _is(value, given),
    "enum": lambda value, given, schema: value in given,
    "const": lambda value, given, schema: value == given,
    "minimum": _of_numbers(lambda value, least: value >= least),
    "maximum": _of_numbers(lambda value, most: value <= most),
    "exclusiveMinimum": _of_numbers(lambda value, least: value > least),
    "minLength": _of(str, lambda value, least: len(value) >= least),
    "maxLength": _of(str, lambda value, most: len(value) <= most),
    "minItems": _of(list, lambda value, least: len(value) >= least),
    "maxItems": _of(list, lambda value, most: len(value) <= most),
    "prefixItems": lambda value, given, schema: True,
    "items": lambda value, given, schema: True,
    "properties": lambda value, given, schema: True,
    "propertyNames": _of(dict, lambda value, given: not any(any(faults(key, given)) for key in value)),
    "required": _of(dict, lambda value, keys: all(key in value for key in keys)),
    "additionalProperties": lambda value, given, schema: (
        given is not False or not isinstance(value, dict) or {*value} <= {*schema.get("properties", ())}
    ),
}
