#!/usr/bin/python3
"""Judges meshes of second order without the bound that tetloom proves: the Jacobian of every cell at random points.

usage: second_order_jacobians.py --tetloom PROGRAM [--points N] [--size R] [--curvature N] [--min Q] [--layers H] MODEL...
Meshes every model with --order 2, with --layers also with 6 boundary layers on all faces, the first one H high, and
evaluates the determinant of the map from the straight tet at its vertices, mid nodes and N points of random barycentric
coordinates (the same ones in every tet, seed 1); that of prisms and pyramids by the shape functions of their 15 and 13
nodes at N random points, over the least at the corners of the straight cell. Where a model is meshed, the exit status
is 1 for a determinant that is not positive, or below the bound that the report states. A folder stands for
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

# Some releases of meshio read these types and do not know their dimension.
meshio._mesh.topological_dimension.update({"wedge15": 3, "pyramid13": 3})

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


def prism_functions(r, s, t):
    """The 15 of a VTK wedge, t from -1 to 1."""
    l = [1 - r - s, r, s]
    up, bubble = [1 - t, 1 + t], 1 - t * t
    corners = [0.5 * l[i] * ((2 * l[i] - 1) * up[k] - bubble) for k in range(2) for i in range(3)]
    flat = [2 * l[i] * l[(i + 1) % 3] * up[k] for k in range(2) for i in range(3)]
    return corners + flat + [l[i] * bubble for i in range(3)]


def pyramid_functions(x, y, z):
    """The 13 of Bedrosian (1992), in the order of VTK: base from -1 to 1, apex at z = 1."""
    signs, left = [(-1, -1), (1, -1), (1, 1), (-1, 1)], 1 - z
    corners = [0.25 * (a * x + b * y - 1) * ((1 + a * x) * (1 + b * y) - z + a * b * x * y * z / left) for a, b in signs]
    base = [0.5 * (left - x) * (left + x) * (left - y) / left, 0.5 * (left - y) * (left + y) * (left + x) / left,
            0.5 * (left - x) * (left + x) * (left + y) / left, 0.5 * (left - y) * (left + y) * (left - x) / left]
    return corners + [z * (2 * z - 1)] + base + [z * (left + a * x) * (left + b * y) / left for a, b in signs]


def gradients_at(functions, places):
    """By steps along the imaginary axis, exact but for rounding: places x nodes x 3."""
    step, columns = 1e-30, []
    for axis in range(3):
        at = [places[:, k] + (1j * step if k == axis else 0) for k in range(3)]
        columns.append(numpy.array([numpy.imag(f) / step for f in functions(*at)]).T)
    return numpy.stack(columns, axis=2)


# By cell type: functions, corners with their three neighbours in right-handed order in VTK's numbering.
CELLS = {"wedge15": (prism_functions, [(0, 1, 2, 3), (1, 2, 0, 4), (2, 0, 1, 5), (3, 5, 4, 0), (4, 3, 5, 1), (5, 4, 3, 2)]),
         "pyramid13": (pyramid_functions, [(0, 1, 3, 4), (1, 2, 0, 4), (2, 3, 1, 4), (3, 0, 2, 4)])}


def places_in(kind, count):
    random = numpy.random.default_rng(1)
    a, b, c = random.random((3, count))
    if kind == "wedge15":
        flip = a + b > 1
        return numpy.stack([numpy.where(flip, 1 - a, a), numpy.where(flip, 1 - b, b), 2 * c - 1], axis=1)
    height = 1 - c ** (1 / 3)
    return numpy.stack([(2 * a - 1) * (1 - height), (2 * b - 1) * (1 - height), height], axis=1)


def least_of_cells(kind, points, cells, count):
    """As least_scaled. A VTK wedge's first triangle looks outwards, so its determinant is turned."""
    functions, corners = CELLS[kind]
    gradients = gradients_at(functions, places_in(kind, count))
    # Edges of the reference cell: a wedge is 2 high, a pyramid's base is 2 x 2.
    turn, scale = {"wedge15": (-1, 2), "pyramid13": (1, 4)}[kind]
    least = []
    for begin in range(0, len(cells), 500):
        nodes = points[cells[begin:begin + 500]]
        straight = numpy.min([turn * numpy.linalg.det(nodes[:, list(c[1:])] - nodes[:, [c[0]]]) for c in corners], axis=0)
        determinants = numpy.linalg.det(numpy.einsum("tnx,pnd->tpxd", nodes, gradients))
        least.append(scale * turn * determinants.min(axis=1) / straight)
    return numpy.concatenate(least)


def layer_options(options):
    if options.layers is None:
        return []
    return ["--layers", "*", "--first-height", str(options.layers), "--growth", "1.2", "--layer-count", "6"]


def judge(options, model, folder):
    """A line of text, and whether all is well; a model that cannot be meshed is not judged."""
    mesh, report = folder / "mesh.vtu", folder / "report.json"
    done = subprocess.run([options.tetloom, "mesh", model, "-o", mesh, "--order", "2", "--relative-size", str(options.size),
                           "--curvature", str(options.curvature), "--min-scaled-jacobian", str(options.min), *layer_options(options), "--report", report, "--quiet"], capture_output=True, text=True)
    if done.returncode != 0:
        return f"status {done.returncode}: not judged", True
    figures = json.loads(report.read_text())["second_order"]
    read = meshio.read(mesh)
    tets = [block.data for block in read.cells if block.type == "tetra10"]
    if not tets:
        return "no tets: not judged", True
    least = least_scaled(read.points, numpy.concatenate(tets), sample_points(options.points))
    others = [least_of_cells(block.type, read.points, block.data, options.points) for block in read.cells if block.type in CELLS]
    least = numpy.concatenate([least] + others)
    stated = figures["min_scaled_jacobian"]
    surface = [block.data[:, 3:] for block in read.cells if block.type == "triangle6"]
    on_surface = len(numpy.unique(numpy.concatenate(surface)))
    text = (f"{len(least):8} cells, least {least.min():.4f}, stated {stated:.4f}, not positive {(least <= 0).sum()}, below {options.min}: "
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
    parser.add_argument("--layers", type=float, help="height of the first layer, in units of the model")
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
