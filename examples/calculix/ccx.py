"""Files of CalculiX: the mesh that tetloom writes, a job on it, and what the solver prints."""
import re
import subprocess
import sys

import numpy

# Barycentric coordinates and weights of the points in which CalculiX integrates, by nodes of the tet.
INNER, OUTER = (5 + 3 * 5**0.5) / 20, (5 - 5**0.5) / 20
POINTS = {4: numpy.full((1, 4), 0.25), 10: numpy.full((4, 4), OUTER) + (INNER - OUTER) * numpy.eye(4)}
EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]  # of the mid nodes


class Mesh:
    """Nodes from 0, tets of 4 or 10 nodes, and the names of sets and surfaces in the file."""

    def __init__(self, path):
        nodes, tets, self.numbers = [], [], []
        self.node_sets, self.element_sets, self.surfaces = {}, [], []
        current = None
        for line in path.read_text().splitlines():
            if line.startswith("*"):
                current = self.begin(line, nodes, tets)
            elif current is not None:
                current(line)
        self.nodes, self.tets = numpy.array(nodes), numpy.array(tets)

    def begin(self, keyword, nodes, tets):
        """What is done with the lines that follow."""
        name = re.search(r"(?:NSET|ELSET|NAME)=([^,]+)", keyword)
        if keyword.startswith("*NODE"):
            return lambda line: nodes.append([float(word) for word in line.split(",")[1:]])
        if keyword.startswith("*ELEMENT"):
            self.element_sets.append(name[1])

            def add(line):
                words = [int(word) for word in line.split(",")]
                self.numbers.append(words[0])
                tets.append([word - 1 for word in words[1:]])

            return add
        if keyword.startswith("*NSET"):
            found = self.node_sets[name[1]] = []
            return lambda line: found.extend(int(word) - 1 for word in line.split(","))
        if keyword.startswith("*SURFACE"):
            self.surfaces.append(name[1])
        return None

    def straightened(self):
        """The nodes with all mid nodes in the middle of their edges."""
        nodes = self.nodes.copy()
        for mid, (a, b) in enumerate(EDGES):
            nodes[self.tets[:, 4 + mid]] = 0.5 * (nodes[self.tets[:, a]] + nodes[self.tets[:, b]])
        return nodes


def shape_functions(count):
    """Of a tet with `count` nodes, and their derivatives by barycentric coordinates, where CalculiX integrates."""
    points = POINTS[count]
    if count == 4:
        return points, numpy.broadcast_to(numpy.eye(4), (1, 4, 4))
    values, slopes = numpy.zeros((len(points), 10)), numpy.zeros((len(points), 10, 4))
    for v in range(4):
        values[:, v], slopes[:, v, v] = points[:, v] * (2 * points[:, v] - 1), 4 * points[:, v] - 1
    for mid, (a, b) in enumerate(EDGES):
        values[:, 4 + mid] = 4 * points[:, a] * points[:, b]
        slopes[:, 4 + mid, a], slopes[:, 4 + mid, b] = 4 * points[:, b], 4 * points[:, a]
    return values, slopes


def integration_points(nodes, tets):
    """Places and weights: (tets, points, 3) and (tets, points). The weights add up to the volume."""
    values, slopes = shape_functions(tets.shape[1])
    corners = nodes[tets]
    places = numpy.einsum("pn,tnc->tpc", values, corners)
    along = numpy.einsum("pnk,tnc->tpkc", slopes[:, :, 1:] - slopes[:, :, :1], corners)
    return places, numpy.linalg.det(along) / (6 * len(values))


def run_job(solver, folder, mesh_file, conditions, young=210000.0, poisson=0.3, nodes=None):
    """Solves a linear static job. `conditions`: lines of the step, and of what holds before. Returns the mesh, the
    displacements of nodes and the stresses (tets, points, 6: xx yy zz xy xz yz)."""
    mesh = Mesh(folder / mesh_file)
    text = (folder / mesh_file).read_text()
    if nodes is not None:  # others in their places
        lines = [f"{i + 1},{x:.13e},{y:.13e},{z:.13e}" for i, (x, y, z) in enumerate(nodes)]
        begin = text.index("\n", text.index("*NODE")) + 1
        text = text[:begin] + "\n".join(lines) + "\n" + text[text.index("*", begin):]
        mesh.nodes = nodes
    fixed, load = conditions(mesh)
    lines = [text, f"*MATERIAL, NAME=steel\n*ELASTIC\n{young},{poisson}"]
    lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=steel" for name in mesh.element_sets]
    lines += ["*BOUNDARY", *fixed, "*STEP\n*STATIC", *load, "*NODE PRINT, NSET=all_nodes\nU"]
    lines += [f"*EL PRINT, ELSET={name}\nS" for name in mesh.element_sets] + ["*END STEP", ""]
    (folder / "job.inp").write_text("\n".join(lines))
    done = subprocess.run([solver, "job"], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0 or "*ERROR" in done.stdout:
        sys.exit(f"ccx.py: the solver failed on {mesh_file}\n{done.stdout[-2000:]}{done.stderr}")
    return mesh, *read_results(folder / "job.dat", mesh)


def read_results(path, mesh):
    """The displacements of all nodes, and the stresses in all integration points."""
    tables = {"displacements": [], "stresses": []}
    table = None
    for line in path.read_text().splitlines():
        words = line.split()
        if words and words[0] in tables:
            table = tables[words[0]]
        elif words and table is not None:
            table.append([float(word) for word in words])
    displacements = numpy.array(tables["displacements"])
    stresses = numpy.array(tables["stresses"])
    place = {number: i for i, number in enumerate(mesh.numbers)}
    ordered = numpy.zeros((len(mesh.tets), len(POINTS[mesh.tets.shape[1]]), 6))
    ordered[[place[int(n)] for n in stresses[:, 0]], stresses[:, 1].astype(int) - 1] = stresses[:, 2:]
    return displacements[numpy.argsort(displacements[:, 0]), 1:], ordered
