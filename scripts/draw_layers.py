#!/usr/bin/python3
"""Draws cuts through boundary layers: at a trailing edge, at a step in the floor, and on a symmetry plane.

usage: scripts/draw_layers.py OUT.svg [--tetloom PROGRAM] [--keep FOLDER]
  --tetloom  default: build/release/bin/tetloom
  --keep     the model and the mesh go there

The model, made here, is a wing section between two symmetry planes, in a channel with a step. Needs the Debian packages
python3-meshio python3-numpy (scripts/install-deps.sh picture).
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

try:
    import meshio
    import numpy as np
except ImportError as error:
    sys.exit(f"draw_layers.py: {error}; run scripts/install-deps.sh picture and use /usr/bin/python3")

SPAN = 0.24
FLOOR = [(-0.5, -0.4), (0.8, -0.4), (0.8, -0.28), (1.7, -0.28), (1.7, 0.4), (-0.5, 0.4)]
SIDES = ["floor", "step", "floor_behind", "outlet", "ceiling", "inlet"]
CELLS = {"tetra": [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
         "pyramid": [(0, 1), (1, 2), (2, 3), (3, 0), (0, 4), (1, 4), (2, 4), (3, 4)],
         "wedge": [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)],
         "hexahedron": [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]}
# Told apart by the colour-blind as well (Okabe & Ito 2008), softened.
COLOURS = {"wedge": "#9cc9e8", "hexahedron": "#9cc9e8", "pyramid": "#f0c27a", "tetra": "#f4f4f0", "layer_tet": "#9fd6b8"}


# --- the model ------------------------------------------------------------------------------------------------------

def wing_section(count=60):
    """NACA 0012 with a sharp trailing edge, from there over the upper side, counter-clockwise."""
    def half(x):
        return 0.6 * (0.2969 * math.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    xs = [0.5 * (1 + math.cos(math.pi * i / count)) for i in range(count + 1)]
    return [(x, half(x) if x < 1 else 0.0) for x in xs] + [(x, -half(x)) for x in xs[-2:0:-1]]


def cross(o, a, b):
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])


def clip_ears(points, ring):
    """Triangles of a simple polygon, counter-clockwise; points may repeat along a bridge."""
    triangles, ring = [], list(ring)
    while len(ring) > 3:
        for i in range(len(ring)):
            a, b, c = ring[i - 1], ring[i], ring[(i + 1) % len(ring)]
            p, q, r = points[a], points[b], points[c]
            if cross(p, q, r) <= 1e-14:
                continue
            if any(cross(p, q, points[v]) >= 0 and cross(q, r, points[v]) >= 0 and cross(r, p, points[v]) >= 0
                   for v in ring if points[v] not in (p, q, r)):
                continue
            triangles.append((a, b, c))
            del ring[i]
            break
        else:
            sys.exit("draw_layers.py: the ends of the model cannot be cut into triangles")
    return triangles + [tuple(ring)]


def write_model(path):
    """The space around the wing section as OBJ, with a group for every face; normals point out of it."""
    wing = wing_section()
    outer, inner = len(FLOOR), len(wing)
    points = FLOOR + wing
    # The hole is joined to the outline by a bridge from the leading edge to the corner beside it.
    nose = outer + min(range(inner), key=lambda i: wing[i][0])
    hole = [outer + (nose - outer - i) % inner for i in range(inner)]
    corner = 0
    ring = [*range(outer), corner, *hole, nose]
    ring = [*range(1, outer), corner, *hole, nose, corner]
    lines = [f"v {x:.12g} {y:.12g} {z:.12g}" for z in (0, SPAN) for x, y in points]
    top = len(points)
    ends = clip_ears(points, ring)

    def add(name, triangles):
        lines.append(f"g {name}")
        lines.extend("f {} {} {}".format(*(v + 1 for v in triangle)) for triangle in triangles)

    def walls(loop):
        for a, b in zip(loop, loop[1:] + loop[:1]):
            yield [(a, b, top + b), (a, top + b, top + a)]
    add("symmetry_0", [(a, c, b) for a, b, c in ends])
    add("symmetry_1", [(top + a, top + b, top + c) for a, b, c in ends])
    for name, quad in zip(SIDES, walls(list(range(outer)))):
        add(name, quad)
    add("wing", [t for quad in walls(hole) for t in quad])
    path.write_text("\n".join(lines) + "\n")


# --- cuts -----------------------------------------------------------------------------------------------------------

def polygons_of_cut(mesh, z):
    """Kind and corners (x, y) of every cell's intersection with a plane."""
    layers = dict_of_field(mesh, "layer")
    for block, layer in zip(mesh.cells, layers):
        edges = CELLS.get(block.type)
        if edges is None:
            continue
        height = mesh.points[block.data][:, :, 2] - z
        for cell, h, of_layer in zip(block.data, height, layer):
            if h.min() >= 0 or h.max() < 0:
                continue
            corners = []
            for a, b in edges:
                if (h[a] < 0) != (h[b] < 0):
                    t = h[a] / (h[a] - h[b])
                    corners.append((1 - t) * mesh.points[cell[a]][:2] + t * mesh.points[cell[b]][:2])
            corners = np.array(corners)
            middle = corners.mean(axis=0)
            order = np.argsort(np.arctan2(*(corners - middle).T[::-1]))
            yield ("layer_tet" if block.type == "tetra" and of_layer > 0 else block.type), corners[order]


def dict_of_field(mesh, name):
    if name not in mesh.cell_data:
        sys.exit(f"draw_layers.py: the mesh has no field '{name}'")
    return [np.asarray(values).reshape(-1) for values in mesh.cell_data[name]]


def polygons_on_plane(mesh):
    """The elements on the symmetry plane z = 0."""
    for block in mesh.cells:
        if block.type in ("triangle", "quad"):
            for cell in block.data:
                if np.abs(mesh.points[cell][:, 2]).max() < 1e-9:
                    yield ("wedge" if block.type == "quad" else "tetra"), mesh.points[cell][:, :2]


# --- the picture ----------------------------------------------------------------------------------------------------

def draw_panel(polygons, title, window, left, width):
    """`window`: x, y and width of what is shown; as high as wide."""
    x, y, size = window
    top, scale = 34, width / size
    parts = [f'<clipPath id="c{left}"><rect x="{left}" y="{top}" width="{width}" height="{width}"/></clipPath>',
             f'<text x="{left}" y="22">{title}</text>', f'<g clip-path="url(#c{left})" stroke="#333" stroke-width="0.5">',
             f'<rect x="{left}" y="{top}" width="{width}" height="{width}" fill="#d8d8d8"/>']
    for kind, corners in polygons:
        low, high = corners.min(axis=0), corners.max(axis=0)
        if high[0] < x or high[1] < y or low[0] > x + size or low[1] > y + size:
            continue
        text = " ".join(f"{left + scale * (px - x):.1f},{top + width - scale * (py - y):.1f}" for px, py in corners)
        parts.append(f'<polygon points="{text}" fill="{COLOURS[kind]}"/>')
    return "\n".join(parts + ["</g>", f'<rect x="{left}" y="{top}" width="{width}" height="{width}" fill="none" '
                                      f'stroke="#444"/>'])


def draw(mesh, path):
    width, gap = 400, 20
    cut = list(polygons_of_cut(mesh, 0.47 * SPAN))
    panels = [(cut, "cut at the trailing edge", (0.9, -0.075, 0.15)),
              (cut, "cut at a step: a concave and a convex corner", (0.65, -0.42, 0.3)),
              (list(polygons_on_plane(mesh)), "symmetry plane, imprinted", (-0.1, -0.15, 0.3))]
    whole = len(panels) * (width + gap) + gap
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{whole}" height="{width + 80}" font-family="sans-serif" '
             f'font-size="14">', f'<rect width="{whole}" height="{width + 80}" fill="white"/>']
    for number, (polygons, title, window) in enumerate(panels):
        parts.append(draw_panel(polygons, title, window, gap + number * (width + gap), width))
    x = gap
    for name, kind in (("prisms", "wedge"), ("pyramids", "pyramid"), ("tets of layers", "layer_tet"),
                       ("tets", "tetra")):
        parts.append(f'<rect x="{x}" y="{width + 52}" width="16" height="16" fill="{COLOURS[kind]}" stroke="#333"/>'
                     f'<text x="{x + 24}" y="{width + 65}">{name}</text>')
        x += 150
    path.write_text("\n".join(parts) + "\n</svg>\n")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("output", type=pathlib.Path)
    parser.add_argument("--tetloom", default="build/release/bin/tetloom")
    parser.add_argument("--keep", type=pathlib.Path)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = options.keep or pathlib.Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        write_model(folder / "wing.obj")
        subprocess.run([options.tetloom, "mesh", str(folder / "wing.obj"), "-o", str(folder / "wing.vtu"), "--size", "0.03",
                        "--curvature", "60", "--feature-angle", "25", "--layers", "wing,floor*,step,ceiling",
                        "--first-height", "0.0008", "--growth", "1.25", "--layer-count", "12", "--quiet"], check=True)
        draw(meshio.read(folder / "wing.vtu"), options.output)


if __name__ == "__main__":
    main()
