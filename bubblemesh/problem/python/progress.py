"""Progress of a packing as it is reported to Python programs."""

from collections.abc import Callable

from bubblemesh.errors import CaseError

STEP = 0.01  # share of a packing


def in_steps(progress: Callable[[float], object]) -> Callable[[float], None]:
    """The callback in a form that may be called with any share very often: it passes each hundredth on, once.

    A share that is less than the last one begins anew. CaseError if the callback is not a function.
    """
    if not callable(progress):
        raise CaseError(f"progress: must be a function of the share that is done (found {progress!r})")
    last = -1.0

    def report(share: float) -> None:
        nonlocal last
        if share < last or share >= last + STEP:
            last = share
            progress(share)

    return report
