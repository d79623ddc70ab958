"""Mesh files of all formats, to write and to read, and the files that are written beside them."""
