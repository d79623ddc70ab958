"""Rings of curves: how those of a file are joined, which are left out, and what is advised where they stay open."""
