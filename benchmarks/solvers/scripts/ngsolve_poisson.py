"""NGSolve: the common problem on out/ring.msh, elements of the order given on straight triangles."""

import sys

from netgen.read_gmsh import ReadGmsh
from ngsolve import BND, CF, H1, BilinearForm, GridFunction, Integrate, LinearForm, Mesh, ds, dx, grad

mesh = Mesh(ReadGmsh("out/ring.msh"))
space = H1(mesh, order=int(sys.argv[1]), dirichlet="rim")
u, v = space.TnT()
k = mesh.MaterialCF({"inside": 1, "outside": 10})
a = BilinearForm(k * grad(u) * grad(v) * dx).Assemble()
b = LinearForm(v * ds("bore")).Assemble()
found = GridFunction(space)
found.vec.data = a.mat.Inverse(space.FreeDofs()) * b.vec
bore = mesh.Boundaries("bore")
print("mean", Integrate(found, mesh, BND, definedon=bore) / Integrate(CF(1), mesh, BND, definedon=bore))
edges, cells = [edge.mat for edge in mesh.Elements(BND)], [cell.mat for cell in mesh.Elements()]
print("labels", *(edges.count(name) for name in ("rim", "bore")))
print("regions", *(cells.count(name) for name in ("outside", "inside")))
