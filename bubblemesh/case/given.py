"""The spacing that a program gives as a mapping, in place of a case file."""

from collections.abc import Mapping, Sequence
from typing import Any

from pydantic import Field, ValidationError

from bubblemesh.case.domain import InnerKeys, RegionKeys
from bubblemesh.case.faults import problems
from bubblemesh.case.fields import Strict
from bubblemesh.case.models import Case
from bubblemesh.case.spacing import SpacingTerms, expressions
from bubblemesh.errors import CaseError
from bubblemesh.spacing.expression import Expression


class Given(Strict):
    """What the keys in messages start with."""

    spacing: SpacingTerms = Field(description="The terms.")


def spacing_case(spacing: Mapping[str, Any], regions: Sequence[str]) -> Case:
    """A case of a checked spacing and the names of regions alone: it has no geometry, and cannot be run.

    Raises
    ------
    CaseError
        If the mapping is not valid; each line of the message names a key.
    """
    try:
        terms = Given.model_validate({"spacing": dict(spacing)}).spacing
    except ValidationError as error:
        raise CaseError("\n".join(problems(error, Given, lambda path: ""))) from None
    for path, text in expressions(terms):
        try:
            Expression.parse(text)
        except CaseError as error:
            raise CaseError(f"{'.'.join(map(str, ('spacing', *path)))}: {error}") from None
    named = tuple(RegionKeys.model_construct(name=name, spacing=None) for name in regions)
    return Case.model_construct(parameters={}, spacing=terms, domain=InnerKeys.model_construct(regions=named))
