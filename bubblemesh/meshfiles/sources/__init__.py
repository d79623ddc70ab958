"""Mesh files as they are: nodes, cells and data of each format, before anything is asked of them."""
