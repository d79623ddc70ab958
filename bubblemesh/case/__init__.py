"""The case file: reading, overriding and checking it."""

from bubblemesh.case.load import case_variants, load_case
from bubblemesh.case.models import Case, Output
from bubblemesh.case.overrides import Override, overrides_of
from bubblemesh.case.sweep import SweepError, Variant

__all__ = ["Case", "Output", "Override", "SweepError", "Variant", "case_variants", "load_case", "overrides_of"]
