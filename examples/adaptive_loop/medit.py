"""MEDIT's text files, as far as the loop needs them: points, triangles and tetrahedra; scalars at points and at tetrahedra."""
import numpy


class Mesh:
    """Points, and the tetrahedra and triangles between them, numbered from 0."""

    def __init__(self, points, triangles, tets):
        self.points, self.triangles, self.tets = points, triangles, tets


def read_mesh(path):
    words = path.read_text().split()

    def section(name, width):
        if name not in words:
            return numpy.empty((0, width))
        at = words.index(name)
        count = int(words[at + 1])
        return numpy.array(words[at + 2:at + 2 + count * width], dtype=float).reshape(count, width)

    points = section("Vertices", 4)[:, :3]
    triangles = section("Triangles", 4)[:, :3].astype(int) - 1
    tets = section("Tetrahedra", 5)[:, :4].astype(int) - 1
    return Mesh(points, triangles, tets)


def write_mesh_for_solver(path, mesh):
    """All of the boundary has the label 1."""

    def rows(items, label):
        return "\n".join(" ".join(map(str, item)) + f" {label}" for item in items.tolist())

    path.write_text(f"MeshVersionFormatted 2\nDimension 3\nVertices\n{len(mesh.points)}\n{rows(mesh.points, 0)}\n"
                    f"Tetrahedra\n{len(mesh.tets)}\n{rows(mesh.tets + 1, 1)}\n"
                    f"Triangles\n{len(mesh.triangles)}\n{rows(mesh.triangles + 1, 1)}\nEnd\n")


def write_solution(path, at_points, at_tets=()):
    """Arrays of one value per point, and per tetrahedron."""
    text = "MeshVersionFormatted 2\nDimension 3\n"
    for name, fields in (("SolAtVertices", at_points), ("SolAtTetrahedra", at_tets)):
        if not fields:
            continue
        kinds = " 1" * len(fields)
        values = "\n".join(" ".join(map(repr, row)) for row in numpy.column_stack(fields).tolist())
        text += f"{name}\n{len(fields[0])}\n{len(fields)}{kinds}\n{values}\n"
    path.write_text(text + "End\n")


def read_solution(path):
    """The scalars at points, then those at tetrahedra: two lists of arrays."""
    words = path.read_text().split()
    result = []
    for name in ("SolAtVertices", "SolAtTetrahedra"):
        fields = []
        if name in words:
            at = words.index(name)
            count, kinds = int(words[at + 1]), int(words[at + 2])
            begin = at + 3 + kinds
            fields = list(numpy.array(words[begin:begin + count * kinds], dtype=float).reshape(count, kinds).T)
        result.append(fields)
    return result
