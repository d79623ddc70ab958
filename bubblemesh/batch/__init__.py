"""Many cases, in worker processes of this machine or of a cluster."""

from bubblemesh.batch.dispatch import BatchListener
from bubblemesh.batch.plan import BatchOptions, Entry, case_files, parse_shard, plan_cases, planned
from bubblemesh.batch.preview import Preview, preview_of, totals_of
from bubblemesh.batch.row import Row
from bubblemesh.batch.run import run_batch

__all__ = [
    "BatchListener",
    "BatchOptions",
    "Entry",
    "Preview",
    "Row",
    "case_files",
    "parse_shard",
    "plan_cases",
    "planned",
    "preview_of",
    "run_batch",
    "totals_of",
]
