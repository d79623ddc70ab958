"""How the program stands what strangers give it: ``python -m benchmarks.robustness``."""
