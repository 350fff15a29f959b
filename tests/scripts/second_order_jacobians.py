#!/usr/bin/python3
"""Judges meshes of second order without the bound that tetloom proves: the Jacobian of every tet at random points.

usage: second_order_jacobians.py --tetloom PROGRAM [--points N] [--size R] [--curvature N] [--min Q] MODEL...
Meshes every model with --order 2 and evaluates the determinant of the map from the straight tet, at its vertices, mid
nodes and N points of random barycentric coordinates (the same ones in every tet, seed 1). Where a model is meshed, the
exit status is 1 for a determinant that is not positive, or below the bound that the report states. A folder stands for
all models in it.
Status 77 where numpy or meshio are missing.
"""
import argparse
import itertools
import json
import pathlib
import subprocess
import sys
import tempfile

try:
    import meshio
    import numpy
except ImportError as missing:
    print(f"second_order_jacobians.py: {missing}: skipped")
    sys.exit(77)

EDGES = numpy.array([[0, 1], [1, 2], [0, 2], [0, 3], [1, 3], [2, 3]])
# Derivatives of the barycentric coordinates by the coordinates of the reference tet.
GRADIENTS = numpy.array([[-1, -1, -1], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)


def shape_gradients(barycentric):
    """Of the ten shape functions at one point: 10 x 3."""
    corners = [(4 * barycentric[i] - 1) * GRADIENTS[i] for i in range(4)]
    mids = [4 * (barycentric[a] * GRADIENTS[b] + barycentric[b] * GRADIENTS[a]) for a, b in EDGES]
    return numpy.array(corners + mids)


def sample_points(count):
    random = numpy.random.default_rng(1)
    corners = numpy.eye(4)
    return numpy.concatenate([corners, corners[EDGES].mean(axis=1), random.dirichlet(numpy.ones(4), count)])


def least_scaled(points, tets, samples):
    """Of each tet the least determinant over that of the straight tet.

    The Jacobian matrix is linear in the point, so its determinant is a sum over triples of vertices: of the product of
    their barycentric coordinates, times the determinant of the first column at the first vertex, and so on.
    """
    nodes = points[tets]
    straight = numpy.linalg.det(nodes[:, 1:4] - nodes[:, :1])
    columns = numpy.einsum("tnx,vnd->vdtx", nodes, numpy.array([shape_gradients(corner) for corner in numpy.eye(4)]))
    triples = {}
    for i, j, k in itertools.product(range(4), repeat=3):
        determinant = numpy.einsum("tx,tx->t", numpy.cross(columns[i, 0], columns[j, 1]), columns[k, 2])
        key = tuple(sorted((i, j, k)))
        triples[key] = triples.get(key, 0) + determinant
    products = numpy.array([samples[:, i] * samples[:, j] * samples[:, k] for i, j, k in triples]).T
    coefficients = numpy.array(list(triples.values()))
    least = [(products @ coefficients[:, begin:begin + 5000]).min(axis=0) for begin in range(0, len(tets), 5000)]
    return numpy.concatenate(least) / straight


def judge(options, model, folder):
    """A line of text, and whether all is well; a model that cannot be meshed is not judged."""
    mesh, report = folder / "mesh.vtu", folder / "report.json"
    done = subprocess.run([options.tetloom, "mesh", model, "-o", mesh, "--order", "2", "--relative-size", str(options.size),
                           "--curvature", str(options.curvature), "--min-scaled-jacobian", str(options.min), "--report", report, "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        return f"status {done.returncode}: not judged", True
    figures = json.loads(report.read_text())["second_order"]
    read = meshio.read(mesh)
    tets = [block.data for block in read.cells if block.type == "tetra10"]
    if not tets:
        return "no tets: not judged", True
    least = least_scaled(read.points, numpy.concatenate(tets), sample_points(options.points))
    stated = figures["min_scaled_jacobian"]
    surface = [block.data[:, 3:] for block in read.cells if block.type == "triangle6"]
    on_surface = len(numpy.unique(numpy.concatenate(surface)))
    text = (f"{len(least):8} tets, least {least.min():.4f}, stated {stated:.4f}, not positive {(least <= 0).sum()}, below {options.min}: "
            f"{(least < options.min - 1e-9).sum()}, mid nodes off the model {figures['off_model_count']} "
            f"of {on_surface} on faces, {figures['curved']} of them curved")
    fine = least.min() > 0 and least.min() >= stated - 1e-9
    return text + ("" if fine else "  NOT WELL"), fine


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tetloom", required=True)
    parser.add_argument("--points", type=int, default=1000)
    parser.add_argument("--size", type=float, default=1 / 40)
    parser.add_argument("--curvature", type=float, default=24)
    parser.add_argument("--min", type=float, default=0.1)
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    models = []
    for path in options.models:
        models += sorted(p for p in path.iterdir() if p.suffix != ".md") if path.is_dir() else [path]
    fine = True
    for model in models:
        with tempfile.TemporaryDirectory() as folder:
            text, holds = judge(options, model, pathlib.Path(folder))
        fine = fine and holds
        print(f"{model.name[:48]:48} {text}", flush=True)
    sys.exit(0 if fine else 1)


if __name__ == "__main__":
    main()
