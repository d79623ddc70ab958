"""Rules of a spacing: what the boundary needs, and how fast it may grow."""
