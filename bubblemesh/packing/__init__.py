"""Bubble packing: the published methods as schemes, and the rounds that run them."""
