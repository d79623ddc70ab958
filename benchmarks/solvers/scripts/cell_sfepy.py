"""SfePy: the conductivity of the periodic cell in out/cell.vtk, whose sides are matched by their places."""

import numpy as np
from sfepy.base.base import output
from sfepy.discrete import Equation, Equations, FieldVariable, Function, Functions, Integral, Material, Problem
from sfepy.discrete.conditions import Conditions, EssentialBC, PeriodicBC
from sfepy.discrete.fem import FEDomain, Field, Mesh
from sfepy.discrete.fem.periodic import match_x_line, match_y_line
from sfepy.solvers.ls import ScipyDirect
from sfepy.solvers.nls import Newton
from sfepy.terms import Term

output.set_output(quiet=True)
domain = FEDomain("cell", Mesh.from_file("out/cell.vtk"))
whole = domain.create_region("Whole", "all")
places = {"Left": "x < 0.000001", "Right": "x > 0.999999", "Bottom": "y < 0.000001", "Top": "y > 0.999999"}
sides = {name: domain.create_region(name, f"vertices in ({place})", "facet") for name, place in places.items()}
corner = domain.create_region("Corner", "vertices in (x < 0.000001) & (y < 0.000001)", "vertex")
field = Field.from_args("u", np.float64, "scalar", whole, approx_order=1)
u = FieldVariable("u", "unknown", field)
v = FieldVariable("v", "test", field, primary_var_name="u")
one, pull = Material("m", values={"k": np.eye(2)}), Material("p", values={"x": [[1.0], [0.0]]})
once = Integral("i", order=1)
stiff = Term.new("dw_diffusion(m.k, v, u)", once, whole, m=one, v=v, u=u)
load = Term.new("dw_diffusion_r(p.x, v)", once, whole, p=pull, v=v)
problem = Problem("cell", equations=Equations([Equation("corrector", stiff + load)]))
across = Function("across", match_y_line), Function("along", match_x_line)
pairs = [PeriodicBC("x", [sides["Left"], sides["Right"]], {"u.0": "u.0"}, match="across")]
pairs += [PeriodicBC("y", [sides["Bottom"], sides["Top"]], {"u.0": "u.0"}, match="along")]
fixed = Conditions([EssentialBC("fixed", corner, {"u.0": 0.0})])
problem.set_bcs(ebcs=fixed, epbcs=Conditions(pairs))
problem.functions = Functions(across)
problem.set_solver(Newton({}, lin_solver=ScipyDirect({})))
problem.solve(save_results=False)
slope = problem.evaluate("ev_grad.1.Whole(u)", mode="eval", u=u)
area = problem.evaluate("ev_volume.1.Whole(u)", mode="eval", u=u)
print("conductivity", float(area) + float(np.ravel(slope)[0]))
