"""The exact solution, a layer that turns about an axis, and how far a solution on a mesh is from it."""
import math

import numpy


class Layer:
    """tanh of the distance from a plane, over the thickness. Lengths are those of the model."""

    def __init__(self, thickness, axis, diffusivity, step):
        self.thickness, self.axis, self.diffusivity, self.step = thickness, axis, diffusivity, step

    def values(self, points, angle):
        x, y = points[..., 0] - self.axis[0], points[..., 1] - self.axis[1]
        return numpy.tanh((math.cos(angle) * x + math.sin(angle) * y) / self.thickness)


def tet_rule(order):
    """Barycentric points and weights, of sum 1: Gauss-Legendre points of the cube, one of its sides shrunk to an edge and
    that to a corner."""
    t, w = numpy.polynomial.legendre.leggauss(order)
    t, w = (t + 1) / 2, w / 2
    a, b, c = (g.ravel() for g in numpy.meshgrid(t, t, t, indexing="ij"))
    wa, wb, wc = (g.ravel() for g in numpy.meshgrid(w, w, w, indexing="ij"))
    x, y, z = a, b * (1 - a), c * (1 - a) * (1 - b)
    weights = wa * wb * wc * (1 - a)**2 * (1 - b)
    return numpy.column_stack([1 - x - y - z, x, y, z]), weights / weights.sum()


def volumes(mesh):
    x = mesh.points[mesh.tets]
    return numpy.einsum("ij,ij->i", numpy.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), x[:, 3] - x[:, 0]) / 6


def error(mesh, values, layer, angle, order=6):
    """The root of the mean square of what lies between them."""
    points, weights = tet_rule(order)
    of_tets = volumes(mesh)
    total = 0.0
    for begin in range(0, len(mesh.tets), 4096):
        tets = mesh.tets[begin:begin + 4096]
        exact = layer.values(numpy.einsum("qi,tic->tqc", points, mesh.points[tets]), angle)
        off = numpy.einsum("qi,ti->tq", points, values[tets]) - exact
        total += of_tets[begin:begin + 4096] @ (off**2 @ weights)
    return math.sqrt(total / of_tets.sum())
