"""Parts of a picture of a mesh; `bubblemesh.pictures.plots` puts them together."""
