"""Who does the work of a batch."""

from collections.abc import Callable
from contextlib import AbstractContextManager

from bubblemesh.batch.cluster import cluster_workers, require_address
from bubblemesh.batch.local import local_workers
from bubblemesh.batch.workers import Workers
from bubblemesh.errors import CaseError
from bubblemesh.resources import available_cores


def workers_at(jobs: int | None, cluster: str | None) -> Callable[[int], AbstractContextManager[Workers]]:
    """What gives the workers for a number of cases: so many local processes, or those of a cluster.

    Raises
    ------
    CaseError
        If both are given, or the cluster's address is not one.
    """
    if cluster is None:
        most = jobs or available_cores()
        return lambda cases: local_workers(min(most, cases))
    if jobs is not None:
        raise CaseError("--jobs counts processes of this machine, a cluster has its own: drop --jobs or --cluster")
    require_address(cluster)
    return lambda cases: cluster_workers(cluster)
