"""Bubble packing: methods as rows of schemes, `multilevel` and the published ones, and the rounds that run them."""
