"""The command ``bubblemesh``, also as ``python -m bubblemesh``: heeds interrupts before it loads anything else."""

import atexit
import gc
import os
import signal
from contextlib import suppress
from types import FrameType

from bubblemesh.errors import INTERRUPTED

# What libraries need not do at each start: NumPy's threads, for large matrices, of which a mesh takes none, would wait
# busily; Pydantic would look for plugins in all packages that are installed.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


def main() -> None:
    """Entry point of the command."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    from bubblemesh.process.resources import keep_freed_memory, seldom_look_for_garbage

    seldom_look_for_garbage()
    atexit.register(gc.freeze)  # or Python looks for garbage among all that ends with the process anyway
    from bubblemesh.cli import main as command

    seldom_look_for_garbage()
    keep_freed_memory()
    command()


def _leave(number: int, frame: FrameType | None) -> None:
    """End at once: nothing has been begun, and what is being loaded might turn an exception into any other one."""
    with suppress(OSError):
        os.write(2, b"error: interrupted\n")
    os._exit(INTERRUPTED)


if __name__ == "__main__":
    main()
