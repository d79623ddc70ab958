"""Placement: where the first bubbles are."""
