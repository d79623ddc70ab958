"""The choice of workers: processes of this machine, or those of a cluster."""

from contextlib import AbstractContextManager
from typing import Protocol

from bubblemesh.errors import CaseError
from bubblemesh.process.resources import available_cores
from bubblemesh.workers.local import local_workers
from bubblemesh.workers.workers import Workers


class Hire(Protocol):
    """Starts workers."""

    def __call__(self, count: int, ahead: str | None = None, /) -> AbstractContextManager[Workers]:
        """Workers for so many jobs; those that start for it load the module ``ahead`` before the first of them."""


def workers_at(jobs: int | None, cluster: str | None) -> Hire:
    """Function that starts workers for a number of jobs: so many local processes, or those of a cluster.

    CaseError if both are given, or the cluster's address is not one.
    """
    if cluster is None:
        most = jobs or available_cores()
        return lambda count, ahead=None: local_workers(min(most, count), ahead)
    if jobs is not None:
        raise CaseError("--jobs counts processes of this machine, a cluster has its own: drop --jobs or --cluster")
    # Imported here since few have a cluster.
    from bubblemesh.workers.cluster import cluster_workers, require_address

    require_address(cluster)
    return lambda count, ahead=None: cluster_workers(cluster)
