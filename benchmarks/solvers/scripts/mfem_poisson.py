"""MFEM: the common problem on out/ring.msh, elements of the order given."""

import sys

import mfem.ser as mfem
import numpy as np

order = int(sys.argv[1])
mesh = mfem.Mesh("out/ring.msh")
rim, bore = (mesh.bdr_attribute_sets.GetAttributeSetMarker(name) for name in ("rim", "bore"))
inside = mesh.attribute_sets.GetAttributeSetMarker("inside").ToList()
outside = mesh.attribute_sets.GetAttributeSetMarker("outside").ToList()
kind = mfem.H1_FECollection(order, 2)
space = mfem.FiniteElementSpace(mesh, kind)
k = mfem.PWConstCoefficient(
    mfem.Vector([1.0 * here + 10.0 * there for here, there in zip(inside, outside, strict=True)])
)
a, b, u = mfem.BilinearForm(space), mfem.LinearForm(space), mfem.GridFunction(space)
one = mfem.ConstantCoefficient(1.0)
a.AddDomainIntegrator(mfem.DiffusionIntegrator(k))
a.Assemble()
b.AddBoundaryIntegrator(mfem.BoundaryLFIntegrator(one), bore)
b.Assemble()
u.Assign(0.0)
fixed, A, X, B = mfem.intArray(), mfem.SparseMatrix(), mfem.Vector(), mfem.Vector()
space.GetEssentialTrueDofs(rim, fixed)
a.FormLinearSystem(fixed, u, b, A, X, B)
mfem.PCG(A, mfem.GSSmoother(A), B, X, 0, 5000, 1e-28, 0.0)
a.RecoverFEMSolution(X, b, u)
ones = mfem.GridFunction(space)
ones.Assign(1.0)
print("mean", b(u) / b(ones))
edges = np.bincount([mesh.GetBdrAttribute(k) for k in range(mesh.GetNBE())], minlength=9)
cells = np.bincount([mesh.GetAttribute(k) for k in range(mesh.GetNE())], minlength=9)
print("labels", *(edges[1 + marker.ToList().index(1)] for marker in (rim, bore)))
print("regions", *(cells[1 + marker.index(1)] for marker in (outside, inside)))
