"""Boundary layers: thin cells in columns on the walls, and the domain that they leave for the bubbles.

Columns stand on the nodes of walls, as many layers high as there is room for. Their tops are the boundary of the rest,
which is packed as any other domain; both are joined to one net of the whole.

The words of this room::

      rest
    --o-------o-------o--     front
      |       |       |
      o-------o-------o       each cell is in a layer
      |       |       |
    --o-------o-------o--     wall
      column  column  column  with a strip between two of them

wall
    A chain of boundary edges with layers on the side that faces the domain.
ladder
    The heights of the layers that a case asks for on the walls of some labels.
column
    The line from a node of a wall up through the layers, with its direction and its height.
strip
    The cells between two neighbouring columns.
fan
    Several columns on one node, around a corner of the wall that points into the domain.
pinch
    Several columns on short edges, at a concave bend or on a straight wall, that are one, from the first layer on or
    from a later one; the counterpart of a fan.
front
    A straight edge between the layers and the rest.
rest
    The part of the domain without layers, which is packed with bubbles.
"""
