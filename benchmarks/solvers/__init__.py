"""One problem in all solvers that are installed: what each reads of the mesh, and what it answers."""
