"""Terms of a spacing: each a function of the place."""
