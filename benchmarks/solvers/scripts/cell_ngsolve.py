"""NGSolve: the conductivity of the periodic cell in out/cell.msh, whose pairs of nodes it is told one by one."""

import json
from pathlib import Path

import numpy as np
from netgen.meshing import PointId
from netgen.read_gmsh import ReadGmsh
from ngsolve import H1, BilinearForm, GridFunction, Integrate, LinearForm, Mesh, Periodic, dx, grad

cell = ReadGmsh("out/cell.msh")
node_at = {tuple(np.round(point.p[:2], 6) + 0.0): k for k, point in enumerate(cell.Points(), 1)}
groups = json.loads(Path("out/cell.labels.json").read_text()).values()
shifts = [group["periodic"]["shift"] for group in groups if "periodic" in group]
for number, shift in enumerate((shift for shift in shifts if sum(shift) > 0), 1):
    for place, node in node_at.items():
        other = node_at.get(tuple(np.round(np.add(place, shift), 6) + 0.0))
        if other:
            cell.AddPointIdentification(PointId(node), PointId(other), number)
mesh = Mesh(cell)
space = Periodic(H1(mesh, order=1))
u, v = space.TnT()
a = BilinearForm(grad(u) * grad(v) * dx + 1e-10 * u * v * dx).Assemble()
b = LinearForm(-grad(v)[0] * dx).Assemble()
found = GridFunction(space)
found.vec.data = a.mat.Inverse(space.FreeDofs()) * b.vec
print("conductivity", Integrate(1 + grad(found)[0], mesh))
