"""What docs/solvers.md shows, run in the solvers that are installed, and compared with exact solutions."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
import skfem
from solver_programs import SECONDS, SYSTEM, mfem_python, openfoam, program, python_with, run
from solvers_page import PAGE, blocks, meshed, prepare

import bubblemesh
from benchmarks.solvers.programs import CONDUCTIVITY, SCRIPTS
from bubblemesh.geometry import rings
from bubblemesh.meshfiles.mesh_files import MeshFiles
from bubblemesh.meshfiles.writing import write_files

pytestmark = pytest.mark.solver

SPACINGS = (0.2, 0.1, 0.05, 0.025)


def test_the_page_shows_every_solver_and_format():
    from bubblemesh.meshfiles.formats import FORMATS, FORMATS_FOR

    for name in (*FORMATS_FOR, *FORMATS):
        assert f"`{name}`" in PAGE
    for order in ("yes", "no"):
        rows = re.findall(rf"^\| (`.*?) \|.*?\| {order} \|", PAGE, flags=re.MULTILINE)
        found = {name for row in rows for name in re.findall(r"`(.*?)`", row)}
        assert found == {name for name, form in FORMATS.items() if (2 in form.orders) == (order == "yes")}
    rows = re.findall(r"^\| (`.*?) \|.*?\| (?:yes|no) \| (.*?) \|", PAGE, flags=re.MULTILINE)
    found = {name for row, quads in rows if quads not in ("-", "as triangles") for name in re.findall(r"`(.*?)`", row)}
    assert found == {name for name, form in FORMATS.items() if form.quads}


def test_parts_on_the_page(tmp_path):
    prepare("Parallel solvers", tmp_path)
    (code,) = blocks("Parallel solvers", "python")
    run([sys.executable, "-c", f"{code}\nassert set(partitioning) == set(owner) == {{0, 1, 2, 3}}"], tmp_path)


# scikit-fem


def test_scikit_fem_on_the_page(tmp_path):
    prepare("scikit-fem", tmp_path)
    code = "\n".join(blocks("scikit-fem", "python"))
    printed = run([sys.executable, "-W", "error", "-c", code], tmp_path)
    assert float(printed) < 0.005


def test_the_error_of_a_poisson_problem_falls_with_the_square_of_the_spacing(tmp_path):
    context = {"__name__": "page"}
    exec(blocks("scikit-fem", "python")[1].replace("print(l2_error(mesh))", ""), context)
    disc = bubblemesh.Domain.of(rings.circle((0, 0), 1, "rim"), [rings.circle((0, 0), 0.4, "bore")])
    errors = []
    for spacing in SPACINGS:
        bubblemesh.mesh(disc, spacing).write(tmp_path / f"{spacing}.msh")
        errors.append(context["l2_error"](skfem.MeshTri.load(tmp_path / f"{spacing}.msh")))
    order = np.polyfit(np.log(SPACINGS), np.log(errors), 1)[0]
    assert 1.85 < order < 2.25, errors


def test_second_order_triangles_on_true_curves_converge_faster(tmp_path):
    context = {"__name__": "page"}
    code = blocks("scikit-fem", "python")[1].replace("print(l2_error(mesh))", "")
    exec(code.replace("ElementTriP1", "ElementTriP2").replace("exact(*mesh.p)", "exact(*basis.doflocs)"), context)
    disc = bubblemesh.Domain.of(rings.circle((0, 0), 1, "rim"), [rings.circle((0, 0), 0.4, "bore")])
    errors = []
    for spacing in SPACINGS[:3]:
        curved, _ = bubblemesh.mesh(disc, spacing).second_order()
        write_files(curved, {}, {}, MeshFiles(tmp_path, str(spacing), ["skfem"]))
        errors.append(context["l2_error"](skfem.MeshTri2.load(tmp_path / f"{spacing}.vtu")))
    order = np.polyfit(np.log(SPACINGS[:3]), np.log(errors), 1)[0]
    assert order > 2.8, errors


# FEniCSx

POISSON = """
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem

assert mesh.geometry.dim == 2
assert set(regions.values) == {ids["domain"]}
assert len(regions.values) == mesh.topology.index_map(2).size_local
assert set(labels.values) == {ids["rim"], ids["bore"]}
make = getattr(fem, "functionspace", None) or fem.FunctionSpace
space = make(mesh, ("Lagrange", 1))
x = ufl.SpatialCoordinate(mesh)
exact = ufl.exp(x[0]) * ufl.cos(2 * x[1])
u, v, n = ufl.TrialFunction(space), ufl.TestFunction(space), ufl.FacetNormal(mesh)
ds = ufl.Measure("ds", mesh, subdomain_data=labels)
given = fem.Function(space)
given.interpolate(lambda x: np.exp(x[0]) * np.cos(2 * x[1]))
fixed = fem.dirichletbc(given, fem.locate_dofs_topological(space, 1, rim))
load = 3 * exact * v * ufl.dx + ufl.inner(ufl.grad(exact), n) * v * ds(ids["bore"])
uh = LinearProblem(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, load, [fixed]).solve()
print("error", fem.assemble_scalar(fem.form((uh - exact) ** 2 * ufl.dx)) ** 0.5)
"""


def test_fenicsx_solves_with_the_labels(tmp_path):
    python = python_with("dolfinx", "mpi4py", "petsc4py")
    if python is None:
        pytest.skip("dolfinx is not installed, so that its reading of XDMF is not tested")
    prepare("FEniCSx", tmp_path)
    code = blocks("FEniCSx", "python")[0]
    printed = run([python, "-c", code + POISSON], tmp_path)
    assert float(re.findall(r"^error (\S+)", printed, flags=re.M)[-1]) < 0.005


def test_fenicsx_reads_the_gmsh_file(tmp_path):
    python = python_with("dolfinx", "mpi4py", "gmsh")
    if python is None:
        pytest.skip("dolfinx with Gmsh is not installed, so that its reading of msh is not tested")
    prepare("FEniCSx", tmp_path)
    code = (
        "\n".join(blocks("FEniCSx", "python")[1:])
        + """
assert sorted(place_of) == list(range(len(original)))
print(mesh.geometry.dim, *(sorted(set(tags.values)) for tags in (regions, labels)))
print(len(regions.values), len(labels.values))
"""
    )
    printed = " ".join(run([python, "-c", code], tmp_path).splitlines()[-2:])
    report = json.loads((tmp_path / "out/disc.report.json").read_text())
    assert printed == f"2 [3] [1, 2] {report['triangles']} {report['boundary_nodes']}"


# FreeFEM


def test_freefem_solves_with_the_labels(tmp_path):
    freefem = program("FreeFem++-nw", "FreeFem++")
    prepare("FreeFEM", tmp_path)
    ids = json.loads((tmp_path / "out/disc.labels.json").read_text())
    assert (ids["rim"]["id"], ids["bore"]["id"], ids["domain"]["id"]) == (1, 2, 3)
    (code,) = blocks("FreeFEM", "freefem")
    more = 'cout << "measures " << int1d(Th, 2)(1.) << " " << int2d(Th, 3)(1.) << " " << Th.nt << endl;\n'
    (tmp_path / "poisson.edp").write_text(code + more)
    printed = run([freefem, "-nw", "-v", "0", "poisson.edp"], tmp_path)
    assert float(re.search(r"^error (\S+)", printed, flags=re.M)[1]) < 0.005
    perimeter, area, triangles = re.search(r"^measures (\S+) (\S+) (\S+)", printed, flags=re.M).groups()
    report = json.loads((tmp_path / "out/disc.report.json").read_text())
    assert int(triangles) == report["triangles"]
    assert float(area) == pytest.approx(report["area"], rel=1e-5)
    assert float(perimeter) == pytest.approx(2 * np.pi * 0.4, rel=0.01)


# CalculiX


@pytest.mark.parametrize(("order", "tolerance"), [(1, 0.04), (2, 0.002)])
def test_calculix_finds_the_widening_of_a_ring(tmp_path, order, tolerance):
    ccx = program("ccx")
    prepare("CalculiX", tmp_path, "--set", f"output.order={order}")
    (deck,) = blocks("CalculiX", "inp")
    (tmp_path / "ring.inp").write_text(deck)
    printed = run([ccx, "ring"], tmp_path)
    assert "*ERROR" not in printed
    rows = re.findall(r"^ +\d+ +(\S+) +(\S+) +\S+$", (tmp_path / "ring.dat").read_text(), flags=re.M)
    widening = np.hypot(*np.array(rows, float).T)
    # Lamé: u = A r + B / r vanishes at radius b, and its radial stress is the pressure at radius a.
    a, b, young, poisson, pressure = 0.4, 1.0, 210000.0, 0.3, 100.0
    scale = -pressure * (1 - poisson**2) / young / (1 + poisson + (1 - poisson) * b**2 / a**2)
    assert len(rows) > 20
    np.testing.assert_allclose(widening, scale * (a - b**2 / a), rtol=tolerance)


# MFEM

MFEM_POISSON = """
import numpy as np

assert (mesh.Dimension(), mesh.SpaceDimension()) == (2, 2)
assert (rim.ToList(), bore.ToList(), disc.ToList()) == ([1, 0], [0, 1], [0, 0, 1])


class Exact(mfem.PyCoefficient):
    def EvalValue(self, x):
        return np.exp(x[0]) * np.cos(2 * x[1])


class Source(mfem.PyCoefficient):
    def EvalValue(self, x):
        return 3 * np.exp(x[0]) * np.cos(2 * x[1])


class Slope(mfem.VectorPyCoefficient):
    def EvalValue(self, x):
        return [np.exp(x[0]) * np.cos(2 * x[1]), -2 * np.exp(x[0]) * np.sin(2 * x[1])]


exact, source, slope = Exact(), Source(), Slope(2)
kind = mfem.H1_FECollection(ORDER, 2)
space = mfem.FiniteElementSpace(mesh, kind)
stiffness, load, u = mfem.BilinearForm(space), mfem.LinearForm(space), mfem.GridFunction(space)
stiffness.AddDomainIntegrator(mfem.DiffusionIntegrator())
stiffness.Assemble()
load.AddDomainIntegrator(mfem.DomainLFIntegrator(source))
load.AddBoundaryIntegrator(mfem.BoundaryNormalLFIntegrator(slope), bore)
load.Assemble()
u.ProjectCoefficient(exact)
fixed, A, X, B = mfem.intArray(), mfem.SparseMatrix(), mfem.Vector(), mfem.Vector()
space.GetEssentialTrueDofs(rim, fixed)
stiffness.FormLinearSystem(fixed, u, load, A, X, B)
mfem.PCG(A, mfem.GSSmoother(A), B, X, 0, 2000, 1e-24, 0.0)
stiffness.RecoverFEMSolution(X, load, u)
print("error", u.ComputeL2Error(exact), mesh.GetNE(), mesh.GetNBE())
"""


@pytest.mark.parametrize(("order", "bound"), [(1, 0.005), (2, 0.0001)])
def test_mfem_solves_with_the_labels(tmp_path, order, bound):
    python = mfem_python()
    prepare("MFEM", tmp_path, "--set", f"output.order={order}")
    (code,) = blocks("MFEM", "python")
    printed = run([python, "-c", code + MFEM_POISSON.replace("ORDER", str(order))], tmp_path)
    error, triangles, edges = re.search(r"^error (\S+) (\d+) (\d+)", printed, flags=re.M).groups()
    report = json.loads((tmp_path / "out/disc.report.json").read_text())
    assert float(error) < bound
    assert (int(triangles), int(edges)) == (report["triangles"], report["boundary_nodes"])


# NGSolve

NGSOLVE_POISSON = """
from ngsolve import CF, BND, BilinearForm, GridFunction, Integrate, LinearForm, cos, ds, dx, exp, grad, sin
from ngsolve import specialcf, sqrt, x, y

assert (mesh.dim, mesh.GetMaterials(), mesh.GetBoundaries()) == (2, ("domain",), ("rim", "bore"))
u, v = space.TnT()
exact = exp(x) * cos(2 * y)
slope = CF((exp(x) * cos(2 * y), -2 * exp(x) * sin(2 * y)))
stiffness = BilinearForm(grad(u) * grad(v) * dx("domain")).Assemble()
load = LinearForm(3 * exact * v * dx + slope * specialcf.normal(2) * v * ds("bore")).Assemble()
found = GridFunction(space)
found.Set(exact, BND)
free = stiffness.mat.Inverse(space.FreeDofs())
found.vec.data += free * (load.vec - stiffness.mat * found.vec)
print("error", sqrt(Integrate((found - exact) ** 2, mesh)), mesh.ne)
"""


def test_ngsolve_solves_with_the_labels(tmp_path):
    python = python_with("ngsolve", "netgen.read_gmsh")
    if python is None:
        pytest.skip("the Python package ngsolve is not installed, so that its reading of the files is not tested")
    prepare("NGSolve", tmp_path)
    (code,) = blocks("NGSolve", "python")
    printed = run([python, "-c", code.replace("order=2", "order=1") + NGSOLVE_POISSON], tmp_path)
    error, triangles = re.search(r"^error (\S+) (\d+)", printed, flags=re.M).groups()
    assert float(error) < 0.005
    assert int(triangles) == json.loads((tmp_path / "out/disc.report.json").read_text())["triangles"]


# GetDP


def test_getdp_solves_with_the_groups(tmp_path):
    getdp = program("getdp")
    prepare("GetDP", tmp_path)
    (text,) = blocks("GetDP", "getdp")
    (tmp_path / "disc.pro").write_text(text)
    run([getdp, "disc.pro", "-msh", "out/disc.msh", "-solve", "Solve", "-pos", "Check", "-v", "2"], tmp_path)
    assert float((tmp_path / "error.txt").read_text().split()[-1]) ** 0.5 < 0.005


# SfePy

SFEPY_COUNT = """
print("counts", len(disc.entities[2]), len(rim.entities[1]), len(bore.entities[1]), mesh.dim)
"""


def test_sfepy_finds_regions_and_sides(tmp_path):
    python = python_with("sfepy")
    if python is None:
        pytest.skip("the Python package sfepy is not installed, so that its reading of the files is not tested")
    prepare("SfePy", tmp_path)
    (code,) = blocks("SfePy", "python")
    printed = run([python, "-c", code + SFEPY_COUNT], tmp_path)
    triangles, rim, bore, dimension = map(int, re.search(r"^counts (.*)$", printed, flags=re.M)[1].split())
    report = json.loads((tmp_path / "out/disc.report.json").read_text())
    assert (triangles, rim + bore, dimension) == (report["triangles"], report["boundary_nodes"], 2)
    assert rim > bore > 20


# deal.II

DEALII_COUNT = """
#include <iostream>
#include <map>

int main()
{
  Triangulation<2> mesh;
  read(mesh);
  std::map<unsigned int, unsigned int> materials, boundaries;
  for (const auto &cell : mesh.active_cell_iterators())
    {
      ++materials[cell->material_id()];
      for (const auto &face : cell->face_iterators())
        if (face->at_boundary())
          ++boundaries[face->boundary_id()];
    }
  std::cout << "counts " << materials[3] << " " << boundaries[1] << " " << boundaries[2] << " " << materials.size()
            << " " << boundaries.size() << std::endl;
}
"""
DEALII_PROJECT = """
cmake_minimum_required(VERSION 3.13)
find_package(deal.II 9.3 REQUIRED)
deal_ii_initialize_cached_variables()
project(disc CXX)
add_executable(disc disc.cc)
deal_ii_setup_target(disc)
add_custom_target(run COMMAND disc)
"""


def test_dealii_finds_materials_and_boundaries(tmp_path):
    cmake = program("cmake")
    prepare("deal.II", tmp_path)
    (code,) = blocks(r"deal\.II", r"c\+\+")
    (tmp_path / "disc.cc").write_text(code + DEALII_COUNT)
    (tmp_path / "CMakeLists.txt").write_text(DEALII_PROJECT)
    configured = subprocess.run([cmake, "."], cwd=tmp_path, capture_output=True, text=True, timeout=SECONDS)
    if "find_package" in configured.stderr or "Could not find" in configured.stderr:
        pytest.skip("deal.II is not installed, so that its reading of the files is not tested")
    printed = run([cmake, "--build", ".", "--target", "run"], tmp_path)
    triangles, rim, bore, *kinds = map(int, re.search(r"^counts (.*)$", printed, flags=re.M)[1].split())
    report = json.loads((tmp_path / "out/disc.report.json").read_text())
    assert (triangles, rim + bore, kinds) == (report["triangles"], report["boundary_nodes"], [1, 2])


# OpenFOAM


def test_openfoam_finds_a_sound_plane_mesh(tmp_path):
    program("gmshToFoam")
    prepare("OpenFOAM", tmp_path)
    (lines,) = blocks("OpenFOAM", "sh")
    printed = openfoam(tmp_path, lines, SYSTEM)
    assert "Mesh OK." in printed
    boundary = (tmp_path / "constant/polyMesh/boundary").read_text()
    for patch in ("rim", "bore", "front", "back"):
        assert re.search(rf"^\s*{patch}$", boundary, flags=re.M)
    assert "(1 1 0)" in printed  # geometric directions: a plane case


# Periodic sides: the effective conductivity of a perforated cell, the same in all programs that can tell it

SCIKIT_FEM_CELL = """
from skfem import Basis, BilinearForm, ElementTriP1, Functional, LinearForm, condense, solve
from skfem.helpers import dot, grad
from skfem.io.meshio import from_meshio

basis = Basis(from_meshio(mesh.to_meshio()), ElementTriP1())
stiffness = spread.T @ BilinearForm(lambda u, v, w: dot(grad(u), grad(v))).assemble(basis) @ spread
load = spread.T @ LinearForm(lambda v, w: -grad(v)[0]).assemble(basis)
u = spread @ solve(*condense(stiffness.tocsr(), load, D=np.zeros(1, int)))
print("conductivity", Functional(lambda w: 1 + w["u"].grad[0]).assemble(basis, u=basis.interpolate(u)))
"""


def conductivity(printed):
    return float(re.search(r"^conductivity (\S+)", printed, flags=re.M)[1])


def test_scikit_fem_joins_periodic_sides_by_their_pairs(tmp_path):
    meshed(tmp_path, "cell.yaml")
    (code,) = blocks("Periodic sides", "python")
    printed = run([sys.executable, "-W", "error", "-c", code + SCIKIT_FEM_CELL], tmp_path)
    assert conductivity(printed) == pytest.approx(CONDUCTIVITY, rel=2e-3)


def test_freefem_joins_periodic_sides_by_their_labels(tmp_path):
    freefem = program("FreeFem++-nw", "FreeFem++")
    meshed(tmp_path, "cell.yaml", "-o", "out", "--for", "freefem")
    (code,) = blocks("Periodic sides", "freefem")
    (tmp_path / "cell.edp").write_text(code)
    printed = run([freefem, "-nw", "-v", "0", "cell.edp"], tmp_path)
    assert conductivity(printed) == pytest.approx(CONDUCTIVITY, rel=2e-3)


def test_mfem_joins_periodic_sides_by_itself(tmp_path):
    python = mfem_python()
    meshed(tmp_path, "cell.yaml", "-o", "out", "--for", "mfem")
    assert conductivity(run([python, SCRIPTS / "cell_mfem.py"], tmp_path)) == pytest.approx(CONDUCTIVITY, rel=2e-3)


def test_openfoam_joins_periodic_sides_as_cyclic_patches(tmp_path):
    program("gmshToFoam")
    meshed(tmp_path, "cell.yaml", "-o", "out", "--for", "openfoam")
    (patches,) = blocks("Periodic sides", "foam")
    (lines,) = blocks("OpenFOAM", "sh")
    lines = lines.replace("disc", "cell").replace("checkMesh", "createPatch -overwrite\ncheckMesh")
    printed = openfoam(tmp_path, lines, {**SYSTEM, "createPatchDict": patches})
    assert "Mesh OK." in printed
    boundary = (tmp_path / "constant/polyMesh/boundary").read_text()
    for patch in ("west", "east", "south", "north"):
        assert re.search(rf"^\s*{patch}\s*{{\s*type\s+cyclic;", boundary, flags=re.M)


# Meshless codes


def test_nodes_on_the_page(tmp_path):
    prepare("Meshless codes", tmp_path)
    (code,) = blocks("Meshless codes", "python")
    check = """
points = np.column_stack([nodes["x"], nodes["y"]])
assert inside.sum() > bore.sum() > 20
np.testing.assert_allclose(normals, -points[bore] / 0.4, atol=1e-6)
rim = nodes["label"] == "rim"
np.testing.assert_allclose(np.column_stack([nodes["nx"], nodes["ny"]])[rim], points[rim], atol=1e-6)
"""
    run([sys.executable, "-W", "error", "-c", code + check], tmp_path)
