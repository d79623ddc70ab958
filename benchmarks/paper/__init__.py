"""The paper's tables and figures, measured anew: ``python -m benchmarks.paper`` writes docs/reproduction.md."""
