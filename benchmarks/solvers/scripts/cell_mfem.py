"""MFEM: the conductivity of the periodic cell in out/cell.msh, whose pairs of nodes it joins."""

import mfem.ser as mfem

mesh = mfem.Mesh("out/cell.msh")
kind = mfem.H1_FECollection(1, 2)
space = mfem.FiniteElementSpace(mesh, kind)
stiffness, load, area = mfem.BilinearForm(space), mfem.LinearForm(space), mfem.LinearForm(space)
one, small, pull = mfem.ConstantCoefficient(1.0), mfem.ConstantCoefficient(1e-10), mfem.Vector([-1.0, 0.0])
pull = mfem.VectorConstantCoefficient(pull)
stiffness.AddDomainIntegrator(mfem.DiffusionIntegrator())
stiffness.AddDomainIntegrator(mfem.MassIntegrator(small))
load.AddDomainIntegrator(mfem.DomainLFGradIntegrator(pull))
area.AddDomainIntegrator(mfem.DomainLFIntegrator(one))
for form in (stiffness, load, area):
    form.Assemble()
u, ones = mfem.GridFunction(space), mfem.GridFunction(space)
u.Assign(0.0)
ones.Assign(1.0)
A, X, B, none = mfem.SparseMatrix(), mfem.Vector(), mfem.Vector(), mfem.intArray()
stiffness.FormLinearSystem(none, u, load, A, X, B)
mfem.PCG(A, mfem.GSSmoother(A), B, X, 0, 2000, 1e-24, 0.0)
stiffness.RecoverFEMSolution(X, load, u)
print("conductivity", area(ones) - load(u))
