"""Rings from files of other programs."""
