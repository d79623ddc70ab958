"""Triangle meshes, their quality and their triangulation."""
