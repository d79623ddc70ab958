"""Distances from the lines of a domain."""
