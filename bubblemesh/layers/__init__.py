"""Boundary layers: thin cells in columns on the walls, and the domain that they leave for the bubbles.

Columns stand on the nodes of walls, as many layers high as there is room for. Their tops are the boundary of the rest,
which is packed as any other domain; both are joined to one net of the whole.
"""
