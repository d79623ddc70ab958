"""Node spacing as a function of place."""
