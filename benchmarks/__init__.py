"""Measurements that take too long, or depend too much on the machine, for a test."""

import os

# Programs are timed as installed ones run, with the bytecode that the first run leaves.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
