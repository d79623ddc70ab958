"""Which of the trials to run: ``python -m benchmarks.robustness meshes --help``."""

import sys
from importlib import import_module

TRIALS = ("meshes", "page", "fuzz", "kills", "disk", "clock", "changes", "batches", "limits")


def main() -> None:
    """Hand on to the trial."""
    if len(sys.argv) < 2 or sys.argv[1] not in TRIALS:
        raise SystemExit(f"usage: python -m benchmarks.robustness {{{','.join(TRIALS)}}} [options]")
    import_module(f"benchmarks.robustness.{sys.argv[1]}").main(sys.argv[2:])


if __name__ == "__main__":
    main()
