#!/usr/bin/python3
"""Stresses by CalculiX on meshes of first and of second order, beside those that are known.

usage: calculix.py --tetloom PROGRAM --solver PROGRAM --folder FOLDER [--quick]
FOLDER holds ball.step, shell.step and part.step. Start with run.sh, which finds the programs and makes the models.
"""
import argparse
import pathlib
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from ccx import Mesh, integration_points, run_job
from error_plot import draw_errors, slope_of

PRESSURE = 10.0
INNER, OUTER = 10.0, 20.0  # radii of the hollow sphere


def make_mesh(options, model, name, size, order):
    command = [options.tetloom, "mesh", model, "-o", name, "--size", str(size), "--order", str(order), "--quiet"]
    subprocess.run(command, cwd=options.folder, check=True)


def tensors(stresses):
    """From xx yy zz xy xz yz to matrices."""
    return stresses[..., [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(*stresses.shape[:-1], 3, 3)


def stress_error(mesh, stresses, exact):
    """Root of the mean square of the difference, over that of the exact stresses."""
    places, weights = integration_points(mesh.nodes, mesh.tets)
    wanted = exact(places)
    difference = ((tensors(stresses) - wanted)**2).sum((-1, -2))
    return float(((weights * difference).sum() / (weights * (wanted**2).sum((-1, -2))).sum())**0.5)


def lame(places):
    """The stresses in a hollow sphere under pressure from inside."""
    radius = numpy.linalg.norm(places, axis=-1)
    normal = places / radius[..., None]
    scale = PRESSURE * INNER**3 / (OUTER**3 - INNER**3)
    radial, around = scale * (1 - (OUTER / radius)**3), scale * (1 + (OUTER / radius)**3 / 2)
    outer_product = normal[..., :, None] * normal[..., None, :]
    return around[..., None, None] * numpy.eye(3) + (radial - around)[..., None, None] * outer_product


def symmetric_shell(mesh):
    fixed = [f"{name},{axis}" for name, axis in (("x_0", 1), ("y_0", 2), ("z_0", 3))]
    return fixed, ["*DSLOAD", f"inner,P,{PRESSURE}"]


def pressed_ball(mesh):
    """Three nodes keep it where it is, without forces: six components in all."""
    corners = mesh.nodes[numpy.unique(mesh.tets[:, :4])]
    on_axes = [int(numpy.unique(mesh.tets[:, :4])[numpy.argmin(numpy.linalg.norm(corners - target, axis=1))])
               for target in ((0, 0, 0), (5, 0, 0), (0, 5, 0))]
    origin, along_x, along_y = (node + 1 for node in on_axes)
    fixed = [f"{origin},1,3", f"{along_x},2,3", f"{along_y},3"]
    return fixed, ["*DSLOAD", *(f"{name},P,{PRESSURE}" for name in mesh.surfaces)]


def loaded_bracket(mesh):
    fixed = [f"{name},1,3" for name in mesh.node_sets if name.startswith("bolt_hole")]
    return fixed, ["*DSLOAD", f"spline_top,P,{PRESSURE}"]


def check_ball(options, size):
    """Under pressure from all sides the stress is the same everywhere."""
    print("ball under pressure: largest error of a stress over the pressure")
    make_mesh(options, "ball.step", "ball.inp", size, 2)
    errors = []
    for kind in ("straight", "curved"):
        nodes = None
        if kind == "straight":
            nodes = Mesh(options.folder / "ball.inp").straightened()
        mesh, _, stresses = run_job(options.solver, options.folder, "ball.inp", pressed_ball, nodes=nodes)
        errors.append(numpy.abs(tensors(stresses) + PRESSURE * numpy.eye(3)).max() / PRESSURE)
        print(f"  {kind:9} {len(mesh.tets):7d} tets of second order  {errors[-1]:.1e}")
    return errors


def check_shell(options, sizes):
    """Curves of (size, error) for first order, straight and curved second order."""
    print("hollow sphere under pressure: error of the stresses")
    print("    size    tets    order 1   order 2, straight   order 2, curved")
    curves = {"order 1": [], "order 2, straight": [], "order 2, curved": []}
    for size in sizes:
        for order in (1, 2):
            make_mesh(options, "shell.step", f"shell{order}.inp", size, order)
        for name, points in curves.items():
            file = "shell1.inp" if name == "order 1" else "shell2.inp"
            nodes = None
            if name.endswith("straight"):
                nodes = Mesh(options.folder / file).straightened()
            mesh, _, stresses = run_job(options.solver, options.folder, file, symmetric_shell, nodes=nodes)
            points.append((size, stress_error(mesh, stresses, lame)))
        errors = "   ".join(f"{points[-1][1]:14.5f}" for points in curves.values())
        print(f"  {size:6.2f} {len(mesh.tets):7d} {errors}")
    return curves


def check_bracket(options, sizes):
    """Curves of (nodes, largest displacement)."""
    print("bracket under load, held at its bolt holes: largest displacement")
    curves = {"order 1": [], "order 2": []}
    for order, points in zip((1, 2), curves.values()):
        for size in sizes:
            make_mesh(options, "part.step", "part.inp", size, order)
            mesh, moved, _ = run_job(options.solver, options.folder, "part.inp", loaded_bracket)
            points.append((len(mesh.nodes), 1000 * float(numpy.linalg.norm(moved, axis=1).max())))
            print(f"  order {order}, size {size:5.2f} {points[-1][0]:8d} nodes {points[-1][1]:9.4f} µm")
    return curves


def main():
    parser = argparse.ArgumentParser()
    for name in ("tetloom", "solver", "folder"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    options.folder = pathlib.Path(options.folder).resolve()
    options.tetloom = str(pathlib.Path(options.tetloom).resolve())

    straight, curved = check_ball(options, 4 if options.quick else 2)
    shell = check_shell(options, (5, 3.5) if options.quick else (5, 3.5, 2.5, 1.8))
    bracket = check_bracket(options, (10, ) if options.quick else (14, 10, 7, 5))
    if not options.quick:
        draw_errors(options.folder / "shell.svg", list(shell.items()), "edge length, mm",
                    "hollow sphere under pressure: error of the stresses")
        draw_errors(options.folder / "bracket.svg", list(bracket.items()), "nodes",
                    "bracket under load: largest displacement, µm")
    # What the example is to show: an error here fails.
    expected = {"ball, straight": straight < 1e-6, "ball, curved": curved < 0.02,
                "order of the stresses": slope_of(shell["order 2, curved"]) > 1.5,
                "curved is better than straight": shell["order 2, curved"][-1][1] < shell["order 2, straight"][-1][1]}
    failed = [name for name, holds in expected.items() if not holds]
    if failed:
        sys.exit("calculix.py: not as expected: " + ", ".join(failed))


if __name__ == "__main__":
    main()
