#!/usr/bin/python3
"""Draws a mesh (.vtu, .msh, .mesh, .meshb, .stl) to a PNG: the surface coloured by CAD face or solid with the mesh's
edges, and, with --clip, the tetrahedra inside. Of a mesh in parts (.pvtu) one part, with the CAD faces that it needs.

usage: scripts/draw_mesh.py MESH OUT.png [--clip AX,AY,AZ[,SHARE]] [--view AZIMUTH,ELEVATION] [--size WxH] [--part K]
  --clip     removes the tets beyond a plane with this outward normal; SHARE (0 ... 1, default 0.5) says how much of the
             mesh, measured along the normal, remains
  --view     in degrees; default -60,28
  --size     of the picture in pixels; default 1200x800
  --part     which part of a .pvtu, from 0; the CAD faces that it lies on are drawn as far as they go, paler

Needs the Debian packages python3-meshio python3-numpy python3-pil (scripts/install-deps.sh picture).
"""
import argparse
import os
import sys
from xml.etree import ElementTree

try:
    import meshio
    import numpy as np
    from PIL import Image
except ImportError as error:
    sys.exit(f"draw_mesh.py: {error}; run scripts/install-deps.sh picture and use /usr/bin/python3")

SUPERSAMPLING = 3
BACKGROUND = np.array([255, 255, 255], np.float32)
# Colours that can be told apart by most people (after Okabe & Ito), softened.
PALETTE = np.array([[120, 170, 210], [230, 170, 90], [110, 185, 155], [225, 205, 100], [205, 140, 175], [150, 160, 175],
                    [215, 130, 100], [140, 150, 210]], np.float32)
TET_FACES = np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]])  # normals point outwards


# --- the mesh -------------------------------------------------------------------------------------------------------

class DrawnMesh:
    """Points, triangles and tets with the tags of their CAD faces and solids, and colours by tag."""

    def __init__(self, path):
        mesh = meshio.read(path)
        self.points = np.asarray(mesh.points, float)[:, :3]
        self.triangles, self.triangle_tags = self._cells(mesh, "triangle")
        self.tets, self.tet_tags = self._cells(mesh, "tetra")
        if not len(self.triangles) and not len(self.tets):
            sys.exit(f"draw_mesh.py: {path} holds neither triangles nor tetrahedra")
        self.face_colors = self._colors(mesh, "face_colors", self.triangle_tags)
        self.region_colors = self._colors(mesh, "region_colors", self.tet_tags)

    @staticmethod
    def _cells(mesh, kind):
        width = {"triangle": 3, "tetra": 4}[kind]
        blocks = [i for i, block in enumerate(mesh.cells) if block.type == kind]
        tags = next((mesh.cell_data[key] for key in ("entity_tag", "gmsh:geometrical", "medit:ref")
                     if key in mesh.cell_data), None)
        if not blocks:
            return np.zeros((0, width), int), np.zeros(0, int)
        cells = np.concatenate([mesh.cells[i].data for i in blocks]).astype(int)
        if tags is None:
            return cells, np.zeros(len(cells), int)
        return cells, np.concatenate([np.asarray(tags[i]).reshape(-1) for i in blocks]).astype(int)

    @staticmethod
    def _colors(mesh, key, tags):
        """RGB by tag: the file's own colours where it has them, else the palette."""
        count = int(tags.max(initial=0)) + 1
        colors = PALETTE[(np.arange(count) - 1) % len(PALETTE)].copy()
        given = np.asarray(mesh.field_data.get(key, np.zeros((0, 4))), float).reshape(-1, 4)
        for tag in range(1, min(count, len(given) + 1)):
            red, green, blue, known = given[tag - 1]
            if known > 0 and np.isfinite([red, green, blue]).all():
                linear = np.clip([red, green, blue], 0, 1)
                srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
                colors[tag] = 40 + 0.84 * 255 * srgb
        return colors


class DrawnPart(DrawnMesh):
    """A part of a mesh: its tets, and the triangles of all parts on the CAD faces that it has triangles of."""

    def __init__(self, path, part):
        folder = os.path.dirname(path)
        pieces = [os.path.join(folder, piece.get("Source")) for piece in ElementTree.parse(path).iter("Piece")]
        if not 0 <= part < len(pieces):
            sys.exit(f"draw_mesh.py: {path} has the parts 0 to {len(pieces) - 1}")
        meshes = [DrawnMesh(piece) for piece in pieces]
        own = meshes[part]
        held = np.unique(own.triangle_tags)
        starts = np.cumsum([0] + [len(mesh.points) for mesh in meshes])
        self.points = np.concatenate([mesh.points for mesh in meshes])
        self.tets, self.tet_tags = own.tets + starts[part], own.tet_tags
        self.triangles, self.triangle_tags = own.triangles + starts[part], own.triangle_tags
        self.face_colors, self.region_colors = own.face_colors, own.region_colors
        others = [i for i in range(len(meshes)) if i != part]
        chosen = [np.isin(meshes[i].triangle_tags, held) for i in others]
        self.around = np.concatenate([meshes[i].triangles[c] + starts[i] for i, c in zip(others, chosen)])
        self.around_tags = np.concatenate([meshes[i].triangle_tags[c] for i, c in zip(others, chosen)])


def boundary_of_tets(tets):
    """Faces of exactly one tet, outward, and the tet of each."""
    faces = tets[:, TET_FACES].reshape(-1, 3)
    keys = np.sort(faces, 1)
    order = np.lexsort((keys[:, 2], keys[:, 1], keys[:, 0]))
    same = (keys[order][1:] == keys[order][:-1]).all(1)
    alone = np.ones(len(faces), bool)
    alone[order[1:][same]] = alone[order[:-1][same]] = False
    chosen = np.flatnonzero(alone)
    return faces[chosen], chosen // 4


def visible_triangles(mesh, clip):
    """Triangles to draw with a colour each: CAD faces in their own colours, cut surfaces in the solid's."""
    if not len(mesh.tets):
        return mesh.triangles, mesh.face_colors[mesh.triangle_tags], True
    tets, tags = mesh.tets, mesh.tet_tags
    if clip is not None:
        normal, share = np.array(clip[:3]) / np.linalg.norm(clip[:3]), clip[3]
        heights = mesh.points @ normal
        limit = heights.min() + share * (heights.max() - heights.min())
        keep = heights[tets].mean(1) <= limit
        tets, tags = tets[keep], tags[keep]
        if not len(tets):
            sys.exit("draw_mesh.py: nothing is left of the mesh behind the plane of --clip")
    faces, owners = boundary_of_tets(tets)
    colors = 0.55 * mesh.region_colors[tags[owners]] + 0.45 * 255
    if len(mesh.triangles):
        base = len(mesh.points)
        key = lambda a: (np.sort(a, 1) @ np.array([base * base, base, 1], object)).astype(object)
        by_key = dict(zip(key(mesh.triangles), mesh.triangle_tags))
        for i, k in enumerate(key(faces)):
            if k in by_key:
                colors[i] = mesh.face_colors[by_key[k]]
    if isinstance(mesh, DrawnPart):
        pale = 0.3 * mesh.face_colors[mesh.around_tags] + 0.7 * 255
        return np.concatenate([faces, mesh.around]), np.concatenate([colors, pale]), True
    return faces, colors, False


# --- the picture ----------------------------------------------------------------------------------------------------

def view_axes(azimuth, elevation):
    """Right, up and the direction towards the eye."""
    a, e = np.radians([azimuth, elevation])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0])
    return right, np.cross(eye, right), eye


def shade(normals, axes):
    """Light from over the left shoulder of the eye, some from the side, some from everywhere."""
    right, up, eye = axes
    key = -0.45 * right + 0.65 * up + 0.75 * eye
    rim = 0.9 * right + 0.2 * up + 0.4 * eye
    light = lambda d: np.clip(normals @ (d / np.linalg.norm(d)), 0, 1)
    return 0.34 + 0.60 * light(key) + 0.14 * light(rim)


class Canvas:
    """A z-buffer, filled by batches of triangles, all of numpy."""

    def __init__(self, width, height):
        self.width, self.height = width, height
        self.depth = np.full(width * height, -np.inf, np.float32)
        self.color = np.tile(BACKGROUND, (width * height, 1))

    def draw(self, corners, colors, line_width):
        """corners (n,3,3): x, y in pixels, z towards the eye; colors (n,3)."""
        low = np.clip(np.floor(corners[:, :, :2].min(1)), 0, [self.width - 1, self.height - 1]).astype(int)
        high = np.clip(np.ceil(corners[:, :, :2].max(1)), 0, [self.width - 1, self.height - 1]).astype(int)
        spans = high - low + 1
        areas = spans[:, 0] * spans[:, 1]
        order = np.argsort(areas, kind="stable")
        start = 0
        while start < len(order):  # batches of some million candidate pixels
            total = np.cumsum(areas[order[start:]])
            count = max(1, int(np.searchsorted(total, 4_000_000)))
            chosen = order[start:start + count]
            self._draw_batch(corners[chosen], colors[chosen], low[chosen], spans[chosen], areas[chosen], line_width)
            start += count

    def _draw_batch(self, corners, colors, low, spans, areas, line_width):
        owner = np.repeat(np.arange(len(corners)), areas)
        local = np.arange(len(owner)) - np.repeat(np.cumsum(areas) - areas, areas)
        x = low[owner, 0] + local % spans[owner, 0]
        y = low[owner, 1] + local // spans[owner, 0]
        a, b, c = (corners[:, i] for i in range(3))
        double_area = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
        double_area = np.where(np.abs(double_area) < 1e-12, np.inf, double_area)
        weights, heights = [], []
        for p, q in ((b, c), (c, a), (a, b)):
            cross = (q[owner, 0] - p[owner, 0]) * (y - p[owner, 1]) - (q[owner, 1] - p[owner, 1]) * (x - p[owner, 0])
            weights.append(cross / double_area[owner])
            length = np.hypot(q[:, 0] - p[:, 0], q[:, 1] - p[:, 1])
            heights.append(np.abs(cross) / np.maximum(length, 1e-9)[owner])
        inside = (weights[0] >= -1e-6) & (weights[1] >= -1e-6) & (weights[2] >= -1e-6)
        owner, pixel = owner[inside], (y * self.width + x)[inside]
        z = sum(w[inside] * corners[owner, i, 2] for i, w in enumerate(weights)).astype(np.float32)
        on_line = np.minimum.reduce(heights)[inside] < line_width
        self._store(pixel, z, np.where(on_line[:, None], 0.42 * colors[owner], colors[owner]))

    def _store(self, pixel, z, color):
        nearer = z > self.depth[pixel]
        pixel, z, color = pixel[nearer], z[nearer], color[nearer]
        order = np.argsort(z, kind="stable")  # of several values for one pixel, the last one stays
        self.depth[pixel[order]] = z[order]
        self.color[pixel[order]] = color[order]

    def image(self):
        pixels = np.clip(self.color, 0, 255).astype(np.uint8).reshape(self.height, self.width, 3)
        picture = Image.fromarray(pixels[::-1])
        return picture.resize((self.width // SUPERSAMPLING, self.height // SUPERSAMPLING), Image.LANCZOS)


def render(mesh, options):
    faces, colors, two_sided = visible_triangles(mesh, options.clip)
    axes = view_axes(*options.view)
    seen = np.stack([mesh.points @ axis for axis in axes], 1)
    corners = seen[faces]
    normals = np.cross(mesh.points[faces[:, 1]] - mesh.points[faces[:, 0]],
                       mesh.points[faces[:, 2]] - mesh.points[faces[:, 0]])
    normals /= np.maximum(np.linalg.norm(normals, axis=1), 1e-300)[:, None]
    towards_eye = normals @ axes[2]
    if two_sided:
        normals[towards_eye < 0] *= -1
    else:
        corners, colors, normals = (v[towards_eye > 0] for v in (corners, colors, normals))
    width, height = (SUPERSAMPLING * n for n in options.size)
    low, high = corners[:, :, :2].min((0, 1)), corners[:, :, :2].max((0, 1))
    scale = 0.94 * min(width / (high[0] - low[0]), height / (high[1] - low[1]))
    corners[:, :, :2] = (corners[:, :, :2] - (low + high) / 2) * scale + np.array([width, height]) / 2
    canvas = Canvas(width, height)
    canvas.draw(corners, (colors * shade(normals, axes)[:, None]).astype(np.float32), 0.22 * SUPERSAMPLING)
    return canvas.image()


def numbers(text, counts, what):
    try:
        values = [float(word) for word in text.replace("x", ",").split(",")]
    except ValueError:
        values = []
    if len(values) not in counts:
        raise argparse.ArgumentTypeError(f"{what}, not '{text}'")
    return values


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("picture")
    parser.add_argument("--part", type=int)
    parser.add_argument("--clip", type=lambda t: (numbers(t, (3, 4), "three or four numbers") + [0.5])[:4])
    parser.add_argument("--view", type=lambda t: numbers(t, (2,), "two angles"), default=[-60, 28])
    parser.add_argument("--size", type=lambda t: [int(v) for v in numbers(t, (2,), "WIDTHxHEIGHT")],
                        default=[1200, 800])
    return parser.parse_args()


def main():
    options = parse_arguments()
    picture = render(DrawnMesh(options.mesh) if options.part is None else DrawnPart(options.mesh, options.part), options)
    # 256 colours are enough for shaded faces, and make a file a third as large.
    picture.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(options.picture, optimize=True)


if __name__ == "__main__":
    main()
