"""What all runs of Gmsh are set to, apart from what needs our own package: a program of Gmsh alone starts as fast."""

DELAUNAY, FRONTAL = 5, 6
OPTIONS = {
    "General.Terminal": 0,
    "General.NumThreads": 1,
    "Mesh.MeshSizeExtendFromBoundary": 0,
    "Mesh.MeshSizeFromPoints": 0,
    "Mesh.MeshSizeFromCurvature": 0,
}
TRIANGLE = 2  # Gmsh's number of the element
