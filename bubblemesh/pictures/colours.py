"""Colours that pictures and pages share."""

INK = "#22303c"
BARE = "#eef3f6"  # of triangles whose colour shows nothing
# Dark enough for thin lines on white, and pale enough for edges in ink upon them; told apart by colour-blind readers.
LABELS = ("#1f5fa8", "#d1495b", "#2e8b57", "#8e44ad", "#c9820a", "#00798c", "#7f4f24", "#4a4e69")
REGIONS = ("#cfe0f1", "#f4c9b4", "#d3dd8e", "#f6e5ae", "#f3c3d3", "#a5d8c9", "#c8c2e4", "#dcdcdc")
