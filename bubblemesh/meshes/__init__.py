"""Triangle meshes: the product, its quality and its triangulation."""
