"""The choice of who packs the parts of a mesh, made before anything else is loaded."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Literal

from bubblemesh.errors import CaseError

if TYPE_CHECKING:
    from bubblemesh.parts.work import Crew

PACKING = "bubblemesh.parts.packing"  # what workers call, as they load it by its name


def crew_for(
    parts: int | Literal["auto"] | None,
    jobs: int | None,
    cluster: str | None,
    warn: Callable[[str], None],
    *,
    at_once: bool,
    memory_mb: float | None,
) -> "AbstractContextManager[Crew]":
    """Crew that packs the parts of a mesh.

    Parameters
    ----------
    parts
        What the case says: None for a mesh in one piece, which this process packs.
    jobs, cluster
        So many local processes at most, or the address of a cluster; by default as many as there are cores.
    warn
        Called with warnings on workers.
    at_once
        Whether workers are started now, or for the first part.
    memory_mb
        Limit on the memory of each worker; None for no limit.

    Raises
    ------
    CaseError
        If jobs or a cluster are named for a mesh in one piece, or both are named.
    """
    if parts is None:
        from bubblemesh.parts.work import alone

        given = [option for option, value in (("--jobs", jobs), ("--cluster", cluster)) if value is not None]
        if given:
            raise CaseError(f"{' and '.join(given)}: a mesh in one piece takes one process: add --parts auto")
        return nullcontext(alone)
    # Imported here since few meshes have parts.
    from bubblemesh.workers.crew import MANY, crew_of
    from bubblemesh.workers.hire import workers_at

    # With `parts: auto` one part may be enough, and they start in vain; but who asks for parts mostly has a large mesh.
    ahead = PACKING if at_once and parts != 1 else None
    return crew_of(workers_at(jobs, cluster), warn, ahead, MANY if parts == "auto" else parts, memory_mb)
