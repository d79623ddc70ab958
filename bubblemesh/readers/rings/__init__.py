"""Rings of curves: joining the curves of a file, leaving some out, and advice if they stay open."""
