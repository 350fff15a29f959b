#!/usr/bin/python3
"""Flows by OpenFOAM on meshes that tetloom writes as cases: a pipe, of which the drop of pressure is known, and a manifold.

usage: openfoam.py --tetloom PROGRAM --folder FOLDER [--quick]
FOLDER holds pipe.step and manifold.step, and OpenFOAM's programs are in PATH. Start with run.sh.
"""
import argparse
import pathlib
import re
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))

from error_plot import draw_errors

RADIUS, LENGTH = 0.010, 0.160  # of the pipe, metres
VISCOSITY, SPEED = 1e-5, 0.02  # m²/s, m/s: a Reynolds number of 40
SCHEMES = """
ddtSchemes {{ default steadyState; }}
gradSchemes {{ default leastSquares; }}
divSchemes {{ default none; div(phi,U) bounded Gauss linear;
             div((nuEff*dev2(T(grad(U))))) Gauss linear; }}
laplacianSchemes {{ default Gauss linear corrected; }}
interpolationSchemes {{ default linear; }}
snGradSchemes {{ default corrected; }}
"""
SOLUTION = """
solvers {{ p {{ solver GAMG; smoother GaussSeidel; tolerance 1e-9; relTol 0.01; }}
          U {{ solver smoothSolver; smoother symGaussSeidel; tolerance 1e-10; relTol 0.05; }} }}
SIMPLE {{ nNonOrthogonalCorrectors 1; consistent yes; residualControl {{ p 1e-5; U 1e-5; }} }}
relaxationFactors {{ equations {{ U 0.9; }} fields {{ p 0.9; }} }}
"""
CONTROL = """
application simpleFoam; startFrom startTime; startTime 0; stopAt endTime; endTime {steps}; deltaT 1;
writeControl timeStep; writeInterval {steps}; purgeWrite 1; writeFormat ascii; writePrecision 10; runTimeModifiable no;
functions {{ {functions} }}
"""
PATCH_FUNCTION = """{name}_{field} {{ type surfaceFieldValue; libs (fieldFunctionObjects); fields ({field});
operation {operation}; regionType patch; name {name}; writeFields no; writeControl timeStep; writeInterval 1; log no; }}
"""
SECTION_FUNCTION = """{name}_p {{ type surfaceFieldValue; libs (fieldFunctionObjects); fields (p); operation areaAverage;
regionType sampledSurface; name {name}; writeFields no; writeControl timeStep; writeInterval 1; log no;
sampledSurfaceDict {{ type cuttingPlane; planeType pointAndNormal; interpolate false;
pointAndNormalDict {{ point (0 0 {z}); normal (0 0 1); }} }} }}
"""
SECTIONS = {"first_quarter": 0.25 * LENGTH, "last_quarter": 0.75 * LENGTH}
SHEAR_FUNCTION = "shear { type wallShearStress; libs (fieldFunctionObjects); writeControl writeTime; log no; }\n"


def header(name, kind="dictionary"):
    return f"FoamFile {{ version 2.0; format ascii; class {kind}; object {name}; }}\n"


class Case:
    """A case in a folder, whose mesh is there."""

    def __init__(self, options, model, size, more=(), name=None):
        self.folder = options.folder / ((name or model) + ".foam")
        words = [options.tetloom, "mesh", f"{model}.step", "-o", self.folder.name, "--size", str(size), "--curvature", "24",
                 "--unit", "m", "--quiet", *more]
        subprocess.run(words, cwd=options.folder, check=True)
        text = (self.folder / "constant/polyMesh/boundary").read_text()
        found = re.findall(r"(\w+)\s*\{[^}]*nFaces\s+(\d+);[^}]*startFace\s+(\d+);", text)
        self.patches = {name: (int(start), int(count)) for name, count, start in found}

    def run(self, program):
        done = subprocess.run([program], cwd=self.folder, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"openfoam.py: {program} failed in {self.folder}\n{done.stdout[-2000:]}{done.stderr}")
        return done.stdout

    def faces(self, patch):
        """The corners of each face."""
        def rows(name):
            text = (self.folder / "constant/polyMesh" / name).read_text()
            return text[text.index("\n(\n") + 3:text.rindex("\n)")].split("\n")
        points = numpy.array([[float(x) for x in row.strip("()").split()] for row in rows("points")])
        start, count = self.patches[patch]
        faces = [[int(i) for i in row[row.index("(") + 1:-1].split()] for row in rows("faces")[start:start + count]]
        return [points[face] for face in faces]

    def face_centres(self, patch):
        """Means of the corners."""
        return numpy.array([corners.mean(axis=0) for corners in self.faces(patch)])

    def face_areas(self, patch):
        fans = [numpy.cross(corners[1:-1] - corners[0], corners[2:] - corners[0]) for corners in self.faces(patch)]
        return numpy.array([numpy.linalg.norm(fan.sum(axis=0)) / 2 for fan in fans])

    def write(self, name, text, kind="dictionary"):
        path = self.folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(header(path.name, kind) + text)

    def make_walls(self, names):
        path = self.folder / "constant/polyMesh/boundary"
        text = path.read_text()
        for name in names:
            text = re.sub(rf"(\b{name}\s*\{{\s*type )patch;", r"\1wall;", text)
        path.write_text(text)

    def prepare(self, inlet, steps, sections):
        """`inlet`: the velocity at each of its faces. Outlets are the patches of that name, all others are walls.
        `sections`: across the z axis, by name, on which the mean pressure is noted."""
        outlets = [name for name in self.patches if name.startswith("outlet")]
        rows = "\n".join("({:.10g} {:.10g} {:.10g})".format(*row) for row in inlet)
        speeds = f"nonuniform List<vector> {len(inlet)} (\n{rows}\n)"
        wall = "{ type noSlip; }"
        velocity = {name: "{ type zeroGradient; }" if name in outlets else wall for name in self.patches}
        velocity["inlet"] = f"{{ type fixedValue; value {speeds}; }}"
        pressure = {name: "{ type fixedValue; value uniform 0; }" if name in outlets else "{ type zeroGradient; }"
                    for name in self.patches}
        for name, fields, units, start, kind in (("U", velocity, "[0 1 -1 0 0 0 0]", "(0 0 0)", "volVectorField"),
                                                 ("p", pressure, "[0 2 -2 0 0 0 0]", "0", "volScalarField")):
            patches = "\n".join(f"{patch} {text}" for patch, text in fields.items())
            self.write(f"0/{name}", f"dimensions {units};\ninternalField uniform {start};\nboundaryField {{\n{patches}\n}}\n", kind)
        self.walls = [name for name in self.patches if name != "inlet" and name not in outlets]
        self.make_walls(self.walls)
        functions = SHEAR_FUNCTION + "".join(SECTION_FUNCTION.format(name=name, z=z) for name, z in sections.items())
        for name in ["inlet", *outlets]:
            functions += PATCH_FUNCTION.format(name=name, field="phi", operation="sum")
        self.write("system/controlDict", CONTROL.format(steps=steps, functions=functions))
        self.write("system/fvSchemes", SCHEMES.format())
        self.write("system/fvSolution", SOLUTION.format())
        self.write("constant/transportProperties", f"transportModel Newtonian; nu {VISCOSITY};\n")
        self.write("constant/turbulenceProperties", "simulationType laminar;\n")
        return outlets

    def last_value(self, name, field):
        """Of a patch or a section."""
        table = sorted(self.folder.glob(f"postProcessing/{name}_{field}/*/surfaceFieldValue.dat"))[-1]
        return float(table.read_text().strip().splitlines()[-1].split()[1])

    def friction(self):
        """The force along the pipe on all walls, over the density."""
        last = max((path for path in self.folder.glob("*/wallShearStress")), key=lambda path: float(path.parent.name))
        text, force = last.read_text(), 0
        for name in self.walls:
            rows = re.search(rf"\b{name}\s*\{{[^}}]*List<vector>\s*\d+\s*\((.*?)\n\)", text, re.DOTALL)[1]
            shear = numpy.array([[float(x) for x in row.strip("()").split()] for row in rows.strip().split("\n")])
            force += shear[:, 2] @ self.face_areas(name)
        return abs(force)


def count_cells(case):
    return int(re.search(r"nCells:\s*(\d+)", (case.folder / "constant/polyMesh/owner").read_text())[1])


def check(case):
    text = case.run("checkMesh")
    figures = [re.search(pattern, text)[1] for pattern in (r"cells:\s+(\d+)", r"non-orthogonality Max: (\S+)",
                                                            r"Max skewness = (\S+?)[, ]")]
    verdict = "Mesh OK" in text
    print("  {} cells, non-orthogonality at most {}°, skewness at most {}: {}".format(
        *figures, "Mesh OK" if verdict else "checkMesh complains"))
    return verdict


def solve(case, steps, sections=None):
    """The flow that comes in as it is far from any end. Returns the names of outlets, and the flux."""
    centres = case.face_centres("inlet")
    profile = 2 * SPEED * (1 - (centres[:, 0]**2 + centres[:, 1]**2) / RADIUS**2).clip(0)
    outlets = case.prepare(numpy.column_stack([0 * profile, 0 * profile, profile]), steps, sections or {})
    case.run("simpleFoam")
    return outlets, -case.last_value("inlet", "phi")


def solve_pipe(options, size, steps):
    """The drop of pressure between two sections over that of Poiseuille's flow with the same flux.

    At the ends the flow is still finding its profile."""
    print(f"pipe, edges of {size} mm")
    case = Case(options, "pipe", size)
    fine = check(case)
    flux = solve(case, steps, SECTIONS)[1]
    first, last = (case.last_value(name, "p") for name in SECTIONS)
    exact = 8 * VISCOSITY * (SECTIONS["last_quarter"] - SECTIONS["first_quarter"]) * flux / (numpy.pi * RADIUS**4)
    ratio = (first - last) / exact
    print(f"  drop of pressure {100 * (ratio - 1):+.2f} % beside that of Poiseuille")
    return fine, ratio


def solve_manifold(options, size, steps):
    print(f"manifold, edges of {size} mm")
    case = Case(options, "manifold", size)
    fine = check(case)
    outlets, flux = solve(case, steps)
    shares = [case.last_value(name, "phi") / flux for name in outlets]
    for name, share in zip(outlets, shares):
        print(f"  {name}: {100 * share:.1f} % of the flux")
    return fine, sum(shares)


def layered_pipe(options, size):
    layers = ["--layers", "*,!inlet,!outlet*", "--first-height", str(0.1 * size), "--growth", "1.25"]
    layers += ["--layer-count", "4"]
    return Case(options, "pipe", size, layers, "pipe_layers")


def pipe_of_tets(options, cells, size):
    """Of about so many cells: the nearest of some sizes, as the number may jump from one size to the next."""
    finer = coarser = None
    tried = []
    for _ in range(8):
        size = round((finer * coarser)**0.5 if finer and coarser else size, 4)
        share = count_cells(Case(options, "pipe", size, (), "pipe_tets")) / cells
        tried.append((abs(share - 1), size))
        if abs(share - 1) < 0.03:
            break
        finer, coarser = (size, coarser) if share > 1 else (finer, size)
        size *= share**(1 / 3)
    return Case(options, "pipe", min(tried)[1], (), "pipe_tets")


def compare_friction(options, sizes, steps):
    """The error of the friction at the wall, with layers and of as many tets alone."""
    curves, fine = {"tets alone": [], "layers": []}, True
    for size in sizes:
        layers = layered_pipe(options, size)
        tets = pipe_of_tets(options, count_cells(layers), size)
        for name, case in (("layers", layers), ("tets alone", tets)):
            print(f"pipe, {name}")
            fine = check(case) and fine
            flux = solve(case, steps)[1]
            exact = 8 * VISCOSITY * LENGTH * flux / RADIUS**2
            error = case.friction() / exact - 1
            print(f"  friction at the wall {100 * error:+.2f} % beside that of Poiseuille")
            curves[name].append((count_cells(case), 100 * abs(error)))
    draw_errors(options.folder / "pipe_friction.svg", list(curves.items()), "cells",
                "error of the friction at the wall, %")
    return fine, curves


def main():
    parser = argparse.ArgumentParser()
    for name in ("tetloom", "folder"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    options.folder = pathlib.Path(options.folder).resolve()
    options.tetloom = str(pathlib.Path(options.tetloom).resolve())

    pipe_is_fine, ratio = solve_pipe(options, 4 if options.quick else 1.0, 60 if options.quick else 400)
    manifold_is_fine, share = solve_manifold(options, 5 if options.quick else 2.5, 60 if options.quick else 300)
    sizes, steps = ([5], 60) if options.quick else ([4, 2.8, 2], 400)
    layers_are_fine, curves = compare_friction(options, sizes, steps)
    closer = all(a[1] < b[1] for a, b in zip(curves["layers"], curves["tets alone"]))
    expected = {"checkMesh": pipe_is_fine and manifold_is_fine and layers_are_fine, "friction with layers": closer,
                "flux": abs(share - 1) < 0.01,
                "drop of pressure": abs(ratio - 1) < (0.5 if options.quick else 0.03)}
    failed = [name for name, holds in expected.items() if not holds]
    if failed:
        sys.exit("openfoam.py: not as expected: " + ", ".join(failed))


if __name__ == "__main__":
    main()
