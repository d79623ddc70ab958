"""Many cases, in worker processes of this machine or of a cluster."""

from bubblemesh.batch.choosing import workers_at
from bubblemesh.batch.course import Begun, Event, Finished, course
from bubblemesh.batch.gathering import case_files
from bubblemesh.batch.index import require_no_index, write_index
from bubblemesh.batch.jobs import Note
from bubblemesh.batch.plan import Settings, planned
from bubblemesh.batch.results import Results
from bubblemesh.batch.shards import Shard

__all__ = [
    "Begun",
    "Event",
    "Finished",
    "Note",
    "Results",
    "Settings",
    "Shard",
    "case_files",
    "course",
    "planned",
    "require_no_index",
    "workers_at",
    "write_index",
]
