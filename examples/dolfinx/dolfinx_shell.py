#!/usr/bin/python3
"""Heat through an eighth of a hollow sphere by dolfinx, on faces by their names in the CAD model, beside the exact flow.

usage: dolfinx_shell.py --tetloom PROGRAM --folder FOLDER [--quick]
FOLDER holds shell.step. Start with run.sh.
"""
import argparse
import pathlib
import subprocess
import sys

import dolfinx
import dolfinx.fem.petsc
import meshio
import numpy
import ufl
from mpi4py import MPI
from petsc4py.PETSc import ScalarType

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from error_plot import draw_errors, slope_of

INNER, OUTER = 10.0, 20.0  # radii
HOT = 100.0                # on the inner face; 0 on the outer one
EXACT = 4 * numpy.pi * HOT * INNER * OUTER / (OUTER - INNER) / 8  # with a conductivity of 1


def read_mesh(path, order):
    """The mesh of dolfinx, tags of its faces, and the tag of each name."""
    file = meshio.read(path)
    kinds = {1: ("tetra", "triangle"), 2: ("tetra10", "triangle6")}[order]
    tets, triangles = (file.get_cells_type(kind) for kind in kinds)
    tags = file.get_cell_data("gmsh:physical", kinds[1]).astype(numpy.int32)
    names = {name: int(tag) for name, (tag, dim) in file.field_data.items() if dim == 2}
    permutations = [numpy.array(dolfinx.cpp.io.perm_vtk(kind, nodes.shape[1]))
                    for kind, nodes in ((dolfinx.mesh.CellType.tetrahedron, tets), (dolfinx.mesh.CellType.triangle, triangles))]
    tets, triangles = (nodes[:, permutation].astype(numpy.int64) for nodes, permutation in zip((tets, triangles), permutations))
    element = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("tetrahedron", geometric_dimension=3), order))
    mesh = dolfinx.mesh.create_mesh(MPI.COMM_WORLD, tets, file.points, element)
    entities, values = dolfinx.cpp.io.distribute_entity_data(mesh._mesh, 2, triangles, tags)
    mesh.topology.create_connectivity(2, 3)
    mesh.topology.create_connectivity(2, 0)
    adjacency = dolfinx.cpp.graph.AdjacencyList_int32(entities)
    return mesh, dolfinx.mesh.meshtags_from_entities(mesh, 2, adjacency, values), names


def heat_flow(mesh, tags, names, order):
    """Through the shell: of the solution, twice its energy over the difference of temperatures."""
    space = dolfinx.fem.FunctionSpace(mesh, ("Lagrange", order))
    conditions = []
    for name, value in (("inner", HOT), ("outer", 0.0)):
        facets = tags.find(names[name])
        dofs = dolfinx.fem.locate_dofs_topological(space, 2, facets)
        conditions.append(dolfinx.fem.dirichletbc(ScalarType(value), dofs, space))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    zero = dolfinx.fem.Constant(mesh, ScalarType(0))
    problem = dolfinx.fem.petsc.LinearProblem(ufl.inner(ufl.grad(u), ufl.grad(v)) * ufl.dx, zero * v * ufl.dx, conditions,
                                              petsc_options={"ksp_type": "cg", "pc_type": "gamg", "ksp_rtol": 1e-10})
    solution = problem.solve()
    energy = dolfinx.fem.assemble_scalar(dolfinx.fem.form(ufl.inner(ufl.grad(solution), ufl.grad(solution)) * ufl.dx))
    return energy / HOT


def solve(options, order, size):
    """The number of tets and the relative error of the flow."""
    name = f"shell_{order}_{size:g}.msh"
    subprocess.run([options.tetloom, "mesh", "shell.step", "-o", name, "--msh-version", "2.2", "--order", str(order), "--size",
                    str(size), "--quiet"], cwd=options.folder, check=True)
    mesh, tags, names = read_mesh(options.folder / name, order)
    error = abs(heat_flow(mesh, tags, names, order) / EXACT - 1)
    print(f"order {order}, edges of {size:g}: {mesh.topology.index_map(3).size_local} tets, error of the flow {100 * error:.4f} %", flush=True)
    return error


def main():
    parser = argparse.ArgumentParser()
    for name in ("tetloom", "folder"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    options.folder = pathlib.Path(options.folder).resolve()
    options.tetloom = str(pathlib.Path(options.tetloom).resolve())
    sizes = [5.0, 3.5] if options.quick else [4.0, 2.8, 2.0, 1.4]
    curves = [(f"order {order}", [(size, solve(options, order, size)) for size in sizes]) for order in (1, 2)]
    if not options.quick:
        draw_errors(options.folder / "dolfinx.svg", curves, "edge length", "relative error of the heat flow")
        for name, points in curves:
            print(f"{name}: power {slope_of(points):.2f}")
    if not (curves[0][1][-1][1] < 0.05 and curves[1][1][-1][1] < 0.1 * curves[0][1][-1][1]):
        sys.exit("dolfinx_shell.py: the flow is not as expected")


if __name__ == "__main__":
    main()
