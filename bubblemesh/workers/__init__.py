"""Processes that are called for work, here or on a cluster: cases of a batch, parts of a mesh."""
