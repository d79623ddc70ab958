"""scikit-fem: the common problem on out/ring.vtu, elements of the order given."""

import sys

import numpy as np
import skfem
from skfem.helpers import dot, grad

second = sys.argv[1] == "2"
mesh = (skfem.MeshTri2 if second else skfem.MeshTri).load("out/ring.vtu")
element = skfem.ElementTriP2() if second else skfem.ElementTriP1()
basis = skfem.Basis(mesh, element, intorder=6)
k = basis.with_element(skfem.ElementTriP0()).zeros()
k[mesh.subdomains["inside"]], k[mesh.subdomains["outside"]] = 1, 10
material = basis.with_element(skfem.ElementTriP0()).interpolate(k)
bore = skfem.FacetBasis(mesh, element, facets="bore", intorder=6)
a = skfem.BilinearForm(lambda u, v, w: w["k"] * dot(grad(u), grad(v))).assemble(basis, k=material)
b = skfem.LinearForm(lambda v, w: v).assemble(bore)
u = skfem.solve(*skfem.condense(a, b, D=basis.get_dofs("rim")))
length = skfem.Functional(lambda w: 1 + 0 * w.x[0])
print("mean", b @ u / length.assemble(bore))
print("labels", *(len(np.asarray(mesh.boundaries[name])) for name in ("rim", "bore")))
print("regions", *(len(mesh.subdomains[name]) for name in ("outside", "inside")))
