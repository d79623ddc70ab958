"""FEniCSx: the conductivity of the periodic cell in out/cell.xdmf, with one unknown for nodes of one place."""

import json
from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import assemble_matrix
from dolfinx.io import XDMFFile
from mpi4py import MPI
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import spsolve
from scipy.spatial import KDTree

with XDMFFile(MPI.COMM_WORLD, "out/cell.xdmf", "r") as file:
    mesh = file.read_mesh(name="Grid")
space = (getattr(fem, "functionspace", None) or fem.FunctionSpace)(mesh, ("Lagrange", 1))
places = space.tabulate_dof_coordinates()[:, :2]
groups = json.loads(Path("out/cell.labels.json").read_text()).values()
shifts = [group["periodic"]["shift"] for group in groups if "periodic" in group]
n, tree = len(places), KDTree(places)
near = np.array([tree.query(places + shift, distance_upper_bound=1e-9)[1] for shift in shifts])  # n for none
_, one = joined = np.nonzero(near < n)
pairs = one, near[joined]
count, number = connected_components(coo_array((np.ones(len(one)), pairs), shape=(n, n)))
spread = coo_array((np.ones(n), (np.arange(n), number)), shape=(n, count)).tocsr()
u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
matrix = assemble_matrix(fem.form(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx))
matrix.assemble()
stiffness = spread.T @ csr_array(matrix.getValuesCSR()[::-1], shape=(n, n)) @ spread
pull = fem.assemble_vector(fem.form(v.dx(0) * ufl.dx))
pull = spread.T @ getattr(pull, "array", pull)
area = fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * ufl.dx))
found = np.zeros(count)
found[1:] = spsolve(stiffness.tocsc()[1:, 1:], -pull[1:])
print("conductivity", area + pull @ found)
