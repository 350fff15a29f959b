#!/usr/bin/python3
"""Solves, adapts and transfers, cycle after cycle, beside the same steps on uniform meshes of as many elements.

usage: adaptive_loop.py --tetloom PROGRAM --freefem PROGRAM --model PART.step --folder FOLDER
                        [--cycles N] [--complexities C,C,...] [--plot FILE.svg]
Start with run.sh, which finds the programs and makes the model.
"""
import argparse
import math
import pathlib
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
from error_plot import draw_errors
from layer import Layer, error, volumes
from medit import read_mesh, read_solution, write_solution

TURN = math.radians(9)  # of the layer in one cycle
START_SIZE = 8.0  # millimetres
LAYER = Layer(thickness=1.5, axis=(60.0, 40.0), diffusivity=10.0, step=1.0)
BOUNDS = ["--norm", "2", "--h-max", "15", "--max-aspect", "100", "--gradation", "2", "--curvature", "16"]


class Programs:
    """What is run, always in the same folder."""

    def __init__(self, tetloom, freefem, model, folder):
        self.tetloom, self.freefem, self.model, self.folder = tetloom, freefem, model, folder
        self.script = pathlib.Path(__file__).resolve().with_name("advection_diffusion.edp")

    def run(self, *arguments):
        words = [str(argument) for argument in arguments]
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"adaptive_loop.py: this failed: {' '.join(words)}\n{done.stdout}{done.stderr}")

    def make_mesh(self, name, size):
        """A uniform mesh of the model, in the file of that name too."""
        self.run(self.tetloom, "mesh", self.model, "-o", name, "--size", size, "--quiet")
        return read_mesh(self.folder / name)

    def solve(self, mesh, old, angles):
        """The solution at the second angle, from that at the first."""
        write_solution(self.folder / "old.sol", [old])
        values = [mesh.path.name, "old.sol", "new.sol", *angles]
        values += [LAYER.thickness, *LAYER.axis, LAYER.diffusivity, LAYER.step]
        (self.folder / "step.txt").write_text(" ".join(map(str, values)) + "\n")
        self.run(self.freefem, "-nw", "-v", "0", self.script)
        return read_solution(self.folder / "new.sol")[0][0]


class AdaptedMesh:
    """A mesh that follows the solution, and what hangs on it. The file adapted.mesh is the same."""

    def __init__(self, programs, complexity):
        """Adapted to the layer where it starts."""
        self.programs, self.complexity = programs, complexity
        self.mesh = programs.make_mesh("adapted.mesh", START_SIZE)
        for _ in range(3):
            self._set_start()
            self.adapt(self.solution)
        self._set_start()

    def _set_start(self):
        self.solution = LAYER.values(self.mesh.points, 0)
        centers = self.mesh.points[self.mesh.tets].mean(axis=1)
        self.tracer = (centers[:, 0] < LAYER.axis[0]).astype(float)  # one value per tetrahedron

    def adapt(self, wanted):
        """To the second derivatives of the field `wanted`; the solution and the tracer are carried over."""
        folder = self.programs.folder
        write_solution(folder / "adapted.sol", [self.solution, wanted], [self.tracer])
        # MEDIT's fields have no names: the first one on points and the first one on tetrahedra are both solution_1.
        self.programs.run(self.programs.tetloom, "adapt", "adapted.mesh", "-o", "next.mesh", "--model",
                          self.programs.model, "--hessian", "solution_2", "--complexity", self.complexity, *BOUNDS,
                          "--transfer", "solution_1", "--quiet")
        (folder / "next.mesh").rename(folder / "adapted.mesh")
        self.mesh = read_mesh(folder / "adapted.mesh")
        [self.solution], [self.tracer] = read_solution(folder / "next.sol")

    def tracer_integral(self):
        return volumes(self.mesh) @ self.tracer


def angles_of(cycle):
    return TURN * cycle, TURN * (cycle + 1)


def run_adapted(programs, complexity, cycles):
    """The mean number of elements, the mean error, and how far the tracer's integral has changed in the end."""
    adapted = AdaptedMesh(programs, complexity)
    tracer = adapted.tracer_integral()
    elements, errors = [], []
    for cycle in range(cycles):
        angles = angles_of(cycle)
        guess = programs.solve(adapted.mesh, adapted.solution, angles)
        # The sum has both layers: the one that is to be carried over, and the one that is to be found.
        adapted.adapt(adapted.solution + guess)
        adapted.solution = programs.solve(adapted.mesh, adapted.solution, angles)
        elements.append(len(adapted.mesh.tets))
        errors.append(error(adapted.mesh, adapted.solution, LAYER, angles[1]))
        print(f"  complexity {complexity:g}, cycle {cycle + 1}: {elements[-1]} tets, error {errors[-1]:.4f}", flush=True)
    return numpy.mean(elements), numpy.mean(errors), adapted.tracer_integral() / tracer - 1


def run_uniform(programs, elements, cycles):
    """The same without adaptation, on a mesh of about so many elements: how many they are, and the mean error."""
    size = START_SIZE
    for _ in range(3):
        mesh = programs.make_mesh("uniform.mesh", size)
        size *= (len(mesh.tets) / elements)**(1 / 3)
    solution, errors = LAYER.values(mesh.points, 0), []
    for cycle in range(cycles):
        angles = angles_of(cycle)
        solution = programs.solve(mesh, solution, angles)
        errors.append(error(mesh, solution, LAYER, angles[1]))
    return len(mesh.tets), numpy.mean(errors)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in ("tetloom", "freefem", "model", "folder"):
        parser.add_argument(f"--{name}", type=pathlib.Path, required=True)
    parser.add_argument("--cycles", type=int, default=10)
    parser.add_argument("--complexities", type=lambda text: [float(word) for word in text.split(",")],
                        default=[250, 500, 1000, 2000])
    parser.add_argument("--plot", type=pathlib.Path)
    return parser.parse_args()


def main():
    options = parse_arguments()
    programs = Programs(*(path.resolve() for path in (options.tetloom, options.freefem, options.model, options.folder)))
    rows = []
    for complexity in options.complexities:
        adapted = run_adapted(programs, complexity, options.cycles)
        rows.append((complexity, *adapted, *run_uniform(programs, adapted[0], options.cycles)))

    print("\ncomplexity  adapted tets    error  tracer's change  uniform tets    error  ratio")
    for complexity, elements, off, change, uniform, uniform_off in rows:
        print(f"{complexity:10g}  {elements:12.0f} {off:8.4f}  {change:15.1e}  {uniform:12d} {uniform_off:8.4f} "
              f"{uniform_off / off:6.1f}")
    if options.plot:
        draw_errors(options.plot, [("adapted", [(row[1], row[2]) for row in rows]),
                                   ("uniform", [(row[4], row[5]) for row in rows])],
                    "tetrahedra", "root of the mean square error, mean of all cycles")
    # What the loop is to show: a run that does not is a failure.
    if any(abs(row[3]) > 1e-12 for row in rows):
        sys.exit("adaptive_loop.py: the integral of the tracer has changed")
    if any(row[2] > 0.5 * row[5] for row in rows):
        sys.exit("adaptive_loop.py: adapted meshes have not halved the error of uniform ones")


if __name__ == "__main__":
    main()
