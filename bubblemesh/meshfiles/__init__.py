"""Mesh files of all formats, to write and to read, and what is written beside them."""
