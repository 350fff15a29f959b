"""MEDIT's text files, as far as the loop needs them: points and tetrahedra; scalars at points and at tetrahedra."""
import numpy


class Mesh:
    """Points, and the tetrahedra between them, numbered from 0, of a file."""

    def __init__(self, path, points, tets):
        self.path, self.points, self.tets = path, points, tets


def read_mesh(path):
    words = path.read_text().split()

    def section(name, width):
        if name not in words:
            return numpy.empty((0, width))
        at = words.index(name)
        count = int(words[at + 1])
        return numpy.array(words[at + 2:at + 2 + count * width], dtype=float).reshape(count, width)

    points = section("Vertices", 4)[:, :3]
    tets = section("Tetrahedra", 5)[:, :4].astype(int) - 1
    return Mesh(path, points, tets)


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
