"""Parts of a picture of a mesh; `bubblemesh.output.plots` puts them together."""
