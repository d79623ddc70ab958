"""The JSON Schema of the case file, for editors that complete and check it."""

from typing import Any

from bubblemesh.case.models import Case


def case_schema() -> dict[str, Any]:
    """The schema of the models, with the methods and all keys that a method may use."""
    # Imported here since the methods need SciPy, for which reading a case should not wait.
    from bubblemesh.packing.configure import all_options
    from bubblemesh.packing.methods import METHODS

    schema = Case.model_json_schema()
    properties = schema["properties"]
    properties["method"]["enum"] = list(METHODS)
    for section in ("packing", "schedule"):
        properties[section] |= {"properties": {}, "additionalProperties": False}
    for option in all_options():
        properties[option.section]["properties"][option.key] = {"description": option.meaning, **option.schema}
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}
