"""SVG drawings: their shapes with transforms, styles, fills, clips and size on paper."""
