"""SfePy: the common problem on out/ring.vtk, elements of the order given on straight triangles."""

import sys

import numpy as np
from sfepy.base.base import output
from sfepy.discrete import Equation, Equations, FieldVariable, Integral, Material, Problem
from sfepy.discrete.conditions import Conditions, EssentialBC
from sfepy.discrete.fem import FEDomain, Field, Mesh
from sfepy.solvers.ls import ScipyDirect
from sfepy.solvers.nls import Newton
from sfepy.terms import Term

output.set_output(quiet=True)
order = int(sys.argv[1])
domain = FEDomain("ring", Mesh.from_file("out/ring.vtk"))
whole = domain.create_region("Whole", "all")
outside, inside = (domain.create_region(f"R{k}", f"cells of group {k}") for k in (4, 5))
rim, bore = (domain.create_region(f"L{k}", f"vertices of group {k}", "facet") for k in (1, 2))
field = Field.from_args("u", np.float64, "scalar", whole, approx_order=order)
u = FieldVariable("u", "unknown", field)
v = FieldVariable("v", "test", field, primary_var_name="u")
many = Integral("i", order=2 * order)
k = Material("k", values={"inside": 1.0, "outside": 10.0})
flux = Material("q", values={"one": 1.0})
terms = [Term.new("dw_laplace(k.inside, v, u)", many, inside, k=k, v=v, u=u)]
terms += [Term.new("dw_laplace(k.outside, v, u)", many, outside, k=k, v=v, u=u)]
terms += [Term.new("dw_integrate(q.one, v)", many, bore, q=flux, v=v)]
problem = Problem("ring", equations=Equations([Equation("balance", terms[0] + terms[1] - terms[2])]))
problem.set_bcs(ebcs=Conditions([EssentialBC("fixed", rim, {"u.0": 0.0})]))
problem.set_solver(Newton({}, lin_solver=ScipyDirect({})))
problem.solve(save_results=False)
total = problem.evaluate(f"ev_integrate.{2 * order}.L2(u)", mode="eval", u=u)
length = problem.evaluate("ev_volume.2.L2(u)", mode="eval", u=u)
print("mean", float(total) / float(length))
print("labels", *(len(region.entities[1]) for region in (rim, bore)))
print("regions", *(len(region.entities[2]) for region in (outside, inside)))
