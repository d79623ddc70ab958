"""Curves, rings and the domain they bound."""
