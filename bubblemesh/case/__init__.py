"""The case file: reading, overriding and checking it."""

from bubblemesh.case.loading import load_case
from bubblemesh.case.models import Case

__all__ = ["Case", "load_case"]
