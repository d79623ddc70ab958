"""scikit-fem: the conductivity of the periodic cell of cell.yaml, with one unknown for each pair of nodes."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skfem import Basis, BilinearForm, ElementTriP1, Functional, LinearForm, condense, solve
from skfem.helpers import dot, grad

import bubblemesh

mesh = bubblemesh.mesh_case(bubblemesh.load_case("cell.yaml")).mesh
pairs, n = np.vstack([sides.nodes for sides in mesh.periodic_sides]), len(mesh.points)
count, number = connected_components(coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n)))
spread = coo_array((np.ones(n), (np.arange(n), number)), shape=(n, count)).tocsr()
basis = Basis(mesh.to_skfem(), ElementTriP1())
stiffness = spread.T @ BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis) @ spread
load = spread.T @ LinearForm(lambda v, w: -grad(v)[0]).assemble(basis)
u = spread @ solve(*condense(stiffness.tocsr(), load, D=np.zeros(1, int)))
print("conductivity", Functional(lambda w: 1 + w["u"].grad[0]).assemble(basis, u=basis.interpolate(u)))
