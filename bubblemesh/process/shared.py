"""What all threads of a process share: filters of warnings, and settings of libraries.

One thread at a time changes them; otherwise a second one would reset what the first has set.
"""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from threading import RLock
from typing import Literal

ALONE = RLock()  # held by the thread that has changed what all share


@contextmanager
def warnings_are(action: Literal["ignore", "error"], message: str = "") -> Iterator[None]:
    """Within the block, ignore warnings whose text matches the pattern ``message``, or turn them into errors."""
    with ALONE, warnings.catch_warnings():
        warnings.filterwarnings(action, message)
        yield
