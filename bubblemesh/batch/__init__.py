"""Many cases, in worker processes of this machine or of a cluster."""

from bubblemesh.batch.choosing import workers_at
from bubblemesh.batch.course import course
from bubblemesh.batch.events import Begun, Event, Finished, Waiting
from bubblemesh.batch.gathering import case_files
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
    "Waiting",
    "case_files",
    "course",
    "planned",
    "workers_at",
]
