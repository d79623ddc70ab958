"""FEniCSx: the common problem on out/ring.xdmf, elements of the order given."""

import json
import sys
from pathlib import Path

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem
from dolfinx.io import XDMFFile
from mpi4py import MPI
from petsc4py import PETSc

order = int(sys.argv[1])
with XDMFFile(MPI.COMM_WORLD, "out/ring.xdmf", "r") as file:
    mesh = file.read_mesh(name="Grid")
    regions = file.read_meshtags(mesh, name="Grid")
mesh.topology.create_connectivity(1, 2)
with XDMFFile(MPI.COMM_WORLD, "out/ring_facets.xdmf", "r") as file:
    labels = file.read_meshtags(mesh, name="Grid")
ids = {name: group["id"] for name, group in json.loads(Path("out/ring.labels.json").read_text()).items()}
make = getattr(fem, "functionspace", None) or fem.FunctionSpace
space, flat = make(mesh, ("Lagrange", order)), make(mesh, ("DG", 0))
k = fem.Function(flat)
k.x.array[:] = np.where(regions.values[np.argsort(regions.indices)] == ids["inside"], 1.0, 10.0)
u, v, ds = ufl.TrialFunction(space), ufl.TestFunction(space), ufl.Measure("ds", mesh, subdomain_data=labels)
fixed = fem.dirichletbc(PETSc.ScalarType(0), fem.locate_dofs_topological(space, 1, labels.find(ids["rim"])), space)
one = fem.Constant(mesh, PETSc.ScalarType(1))
options = {"ksp_type": "preonly", "pc_type": "lu"}
problem = LinearProblem(
    k * ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, one * v * ds(ids["bore"]), [fixed], petsc_options=options
)
u = problem.solve()
bore = [fem.assemble_scalar(fem.form(value * ds(ids["bore"]))) for value in (u, one)]
print("mean", bore[0] / bore[1])
print("labels", *(len(labels.find(ids[name])) for name in ("rim", "bore")))
print("regions", *(len(regions.find(ids[name])) for name in ("outside", "inside")))
