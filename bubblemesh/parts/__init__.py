"""Meshes made in parts: the domain is cut, its parts are packed side by side and joined, and seams packed again."""
