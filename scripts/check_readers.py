#!/usr/bin/python3
"""Programs of others read what tetloom writes: whether each of them finds the counts, the volume and the names.

usage: check_readers.py --tetloom PROGRAM --folder FOLDER MODEL...
Every model is meshed once for each format and order. A reader that is not installed is told as such and is no failure;
the exit status is 1 where a reader found something else than the mesh, or complained. Start with check_readers.sh.
"""
import argparse
import ctypes
import ctypes.util
import importlib.util
import json
import pathlib
import re
import shutil
import subprocess
import sys

import numpy

SCHEMES = """ddtSchemes { default steadyState; }
gradSchemes { default Gauss linear; }
divSchemes { default none; }
laplacianSchemes { default Gauss linear corrected; }
interpolationSchemes { default linear; }
snGradSchemes { default corrected; }
"""
CODE_SATURNE = "/usr/lib/code_saturne/cs_preprocess"
EXODUS = "exoIIv2c"  # Debian's name of the library


class Complaint(Exception):
    """What a reader found wrong."""


def run(words, folder, refused=r"\bwarning|\berror\b"):
    done = subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True, errors="replace")
    text = done.stdout + done.stderr
    found = re.search(f".*(?:{refused}).*", text, re.I) if refused else None
    if done.returncode != 0 or found:
        raise Complaint(found[0].strip() if found else f"status {done.returncode}: {text.strip()[-200:]}")
    return text


def require_close(found, expected, what, tolerance=1e-6):
    if not abs(found - expected) <= tolerance * abs(expected):
        raise Complaint(f"{what} {found:.10g}, expected {expected:.10g}")


def require_equal(found, expected, what):
    if found != expected:
        raise Complaint(f"{found} {what}, expected {expected}")


def require_names(text, names):
    missing = [name for name in names if name not in text]
    if missing:
        raise Complaint("missing names: " + ", ".join(missing[:5]))


def volume_of_tets(points, tets):
    """By the vertices."""
    a, b, c, d = (points[tets[:, i]] for i in range(4))
    return numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a).sum() / 6


class Meshed:
    """A mesh of a model in one format."""

    def __init__(self, options, model, extension, order, more=()):
        self.order = order
        self.folder = options.folder / f"{model.stem}-{extension.replace('.', '_')}-{order}{'-parts' if '--parts' in more else ''}"
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        self.path = self.folder / f"mesh.{extension}"
        run([options.tetloom, "mesh", model.resolve(), "-o", self.path, "--order", order, "--relative-size", options.size, "--report",
             self.folder / "report.json", "--quiet", *more], self.folder, None)
        report = json.loads((self.folder / "report.json").read_text())
        self.points, self.tets = report["counts"]["points"], report["counts"]["tets"]
        self.volume = report["volume"]["mesh"]
        self.names = [name for value in report.get("names", {}).values()
                      for name in (value if isinstance(value, list) else [value])]


def by_meshio(mesh):
    import meshio
    read = meshio.read(mesh.path)
    kinds = ("tetra10",) if mesh.order == 2 else ("tetra", "tetra4")
    tets = numpy.concatenate([block.data for block in read.cells if block.type in kinds])
    require_equal(len(read.points), mesh.points, "points")
    require_equal(len(tets), mesh.tets, "tets")
    if mesh.order == 1:
        sign = -1 if mesh.path.suffix == ".med" else 1  # tets of MED turn the other way, and meshio leaves them so
        require_close(sign * volume_of_tets(numpy.asarray(read.points, float), tets), mesh.volume, "volume")


def by_vtk(mesh):
    import vtk
    readers = {".vtu": "vtkXMLUnstructuredGridReader", ".vtkhdf": "vtkHDFReader", ".exo": "vtkExodusIIReader", ".cgns": "vtkCGNSReader"}
    kind = getattr(vtk, readers[mesh.path.suffix], None)
    if kind is None:
        return "not in this VTK"
    reader = kind()
    reader.SetFileName(str(mesh.path))
    reader.Update()
    collect = vtk.vtkAppendFilter()
    output = reader.GetOutputDataObject(0)
    pieces = [output]
    if output.IsA("vtkCompositeDataSet"):
        walk = output.NewIterator()
        pieces = []
        while not walk.IsDoneWithTraversal():
            pieces.append(walk.GetCurrentDataObject())
            walk.GoToNextItem()
    for piece in pieces:
        collect.AddInputData(piece)
    collect.Update()
    grid = collect.GetOutput()
    kinds = [grid.GetCellType(i) for i in range(grid.GetNumberOfCells())]
    require_equal(sum(kind in (10, 24) for kind in kinds), mesh.tets, "tets")
    if mesh.order == 1:
        sizes = vtk.vtkCellSizeFilter()
        sizes.SetInputData(grid)
        sizes.Update()
        volumes = sizes.GetOutput().GetCellData().GetArray("Volume")
        require_close(sum(volumes.GetValue(i) for i, kind in enumerate(kinds) if kind == 10), mesh.volume, "volume")
    return None


def by_exodus(mesh):
    library = ctypes.CDLL(ctypes.util.find_library(EXODUS))
    library.ex_open_int.restype = ctypes.c_int
    library.ex_inquire_int.restype = ctypes.c_int64
    word, given, version = ctypes.c_int(8), ctypes.c_int(0), ctypes.c_float()
    file = library.ex_open_int(str(mesh.path).encode(), 0, ctypes.byref(word), ctypes.byref(given), ctypes.byref(version), 602)
    if file < 0:
        raise Complaint("ex_open fails")
    counts = {name: library.ex_inquire_int(file, number) for name, number in (("points", 6), ("elements", 7))}
    library.ex_close(file)
    require_equal(counts["points"], mesh.points, "points")
    require_equal(counts["elements"], mesh.tets, "elements")


def by_netcdf(mesh):
    import netCDF4
    with netCDF4.Dataset(mesh.path) as file:
        require_equal(len(file.dimensions["num_elem"]), mesh.tets, "elements")
        text = " ".join(b"".join(row.compressed()).decode() for kind in ("eb", "ss", "ns") for row in file[kind + "_names"][:])
        require_names(text, mesh.names)


def by_med(mesh):
    run(["medconforme", mesh.path.name], mesh.folder, "non conforme")
    dump = run(["mdump", mesh.path.name, "NODALE", "FULL_INTERLACE", "1"], mesh.folder, "ERREUR")
    require_names(dump, [*mesh.names, f"noeuds : {mesh.points} ", f"TETRA{10 if mesh.order == 2 else 4} : {mesh.tets} "])


def by_cgns(mesh):
    run(["cgnscheck", mesh.path.name], mesh.folder, r"\bwarning:|\berror:")


def by_code_saturne(mesh):
    text = run([CODE_SATURNE, "--out", "preprocessed", mesh.path.name], mesh.folder, r"\berror\b")
    warnings = re.findall(r"^ *warning\n=+\n(.*\n.*)", text, re.M | re.I)
    if any("seg2" not in warning for warning in warnings):  # it says that it has no use for edges
        raise Complaint(warnings[0])
    require_names(text, [name for name in mesh.names if not name.startswith("edge")] if mesh.path.suffix == ".med" else [])


def by_check_mesh(mesh, folder=None):
    text = run(["checkMesh"], folder or mesh.path, None)
    if "Mesh OK" not in text:
        raise Complaint(" ".join(line.strip() for line in text.splitlines() if "***" in line)[:200] or "checkMesh fails")
    require_equal(int(re.search(r"cells:\s+(\d+)", text)[1]), mesh.tets, "cells")
    require_close(float(re.search(r"Total volume = ([-+.e\d]+?)\.?\s", text)[1]), mesh.volume, "volume", 1e-5)


def by_parallel_foam(mesh):
    count = len(list(mesh.path.glob("processor*")))
    words = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-np", count, "checkMesh", "-parallel"]
    if "Mesh OK" not in run(words, mesh.path, None):
        raise Complaint("checkMesh -parallel fails")
    run(["reconstructParMesh", "-constant"], mesh.path, r"FOAM FATAL")
    by_check_mesh(mesh)


def by_gmsh_to_foam(mesh):
    case = mesh.folder / "case"
    (case / "system").mkdir(parents=True)
    (case / "system/controlDict").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }\napplication gmshToFoam; startFrom startTime;\n"
        "startTime 0; stopAt endTime; endTime 1; deltaT 1; writeControl timeStep; writeInterval 1;\n")
    for name, text in (("fvSchemes", SCHEMES), ("fvSolution", "solvers {}\n")):
        (case / "system" / name).write_text(f"FoamFile {{ version 2.0; format ascii; class dictionary; object {name}; }}\n{text}")
    run(["gmshToFoam", mesh.path], case, r"FOAM FATAL")
    by_check_mesh(mesh, case)
    require_names((case / "constant/polyMesh/boundary").read_text() + (case / "constant/polyMesh/cellZones").read_text(),
                  [name for name in mesh.names if not name.startswith("edge")])


def by_gmsh(mesh):
    text = run(["gmsh", "-check", "-v", "4", mesh.path.name], mesh.folder, r"\bwarning|\berror\b")
    require_names(text, [f"{mesh.points} nodes"])


def by_calculix(mesh):
    """The volume that CalculiX integrates."""
    sets = sorted(set(re.findall(r"ELSET=(\w+)", mesh.path.read_text())))
    lines = [f"*INCLUDE, INPUT={mesh.path.name}", "*MATERIAL, NAME=m", "*ELASTIC", "1,.3"]
    lines += [f"*SOLID SECTION, ELSET={name}, MATERIAL=m" for name in sets]
    lines += ["*BOUNDARY", "all_nodes,1,3", "*STEP", "*STATIC", *(line for name in sets for line in
              (f"*EL PRINT, ELSET={name}, TOTALS=ONLY", "EVOL")), "*END STEP", ""]
    (mesh.folder / "deck.inp").write_text("\n".join(lines))
    run(["ccx", "deck"], mesh.folder, r"\*ERROR|\*WARNING(?!: no degrees of freedom)")
    volumes = re.findall(r"total volume.*\n\s*\n?\s*(\S+)", (mesh.folder / "deck.dat").read_text())
    require_equal(len(volumes), len(sets), "volumes")
    if mesh.order == 1:
        require_close(sum(map(float, volumes)), mesh.volume, "volume")


def by_freefem(mesh):
    script = (f'mesh3 Th("{mesh.path.name}");\n'
              'cout << "found " << Th.nv << " " << Th.nt << endl;\ncout.precision(12);\n'
              'cout << "volume " << Th.measure << endl;\n'
              'cout << "flux " << int2d(Th)(x*N.x + y*N.y + z*N.z) / 3 << endl;\n')
    (mesh.folder / "read.edp").write_text(script)
    text = run(["FreeFem++", "-nw", "-ne", "read.edp"], mesh.folder, r"bad orientation|\berror\b.*:")
    require_equal([int(number) for number in re.search(r"found (\d+) (\d+)", text).groups()], [mesh.points, mesh.tets], "points and tets")
    for what in ("volume", "flux"):  # the flux of x/3 is the volume where boundary triangles point outwards
        require_close(float(re.search(rf"{what} (\S+)", text)[1]), mesh.volume, what)


def by_getfem(mesh):
    import getfem
    getfem.util("warning level", 0)  # that it has no use for edges
    read = getfem.Mesh("import", "gmsh", str(mesh.path))
    require_equal(read.nbpts() if mesh.order == 1 else mesh.points, mesh.points, "points")
    fem = getfem.MeshFem(read, 1)
    fem.set_fem(getfem.Fem("FEM_PK(3,1)"))
    integration = getfem.MeshIm(read, getfem.Integ("IM_TETRAHEDRON(5)"))
    volume = getfem.asm_generic(integration, 0, "1", -1)
    if mesh.order == 1:
        require_close(volume, mesh.volume, "volume")


def has_module(name):
    return importlib.util.find_spec(name) is not None


def has_exodus():
    return bool(ctypes.util.find_library(EXODUS))


READERS = {
    "meshio": (lambda: has_module("meshio"), by_meshio), "VTK": (lambda: has_module("vtk"), by_vtk),
    "libexodus": (has_exodus, by_exodus), "netCDF4": (lambda: has_module("netCDF4"), by_netcdf),
    "medconforme, mdump": (lambda: shutil.which("medconforme"), by_med), "cgnscheck": (lambda: shutil.which("cgnscheck"), by_cgns),
    "code_saturne": (lambda: pathlib.Path(CODE_SATURNE).exists(), by_code_saturne),
    "checkMesh": (lambda: shutil.which("checkMesh"), by_check_mesh),
    "checkMesh -parallel, reconstructParMesh": (lambda: shutil.which("reconstructParMesh"), by_parallel_foam),
    "gmshToFoam": (lambda: shutil.which("gmshToFoam"), by_gmsh_to_foam), "Gmsh": (lambda: shutil.which("gmsh"), by_gmsh),
    "CalculiX": (lambda: shutil.which("ccx"), by_calculix), "FreeFEM": (lambda: shutil.which("FreeFem++"), by_freefem),
    "GetFEM": (lambda: has_module("getfem"), by_getfem),
}
# Extension, orders, more words for tetloom, readers.
FORMATS = (
    ("vtu", (1, 2), (), ("meshio", "VTK")),
    ("vtkhdf", (1, 2), (), ("VTK",)),
    ("msh", (1, 2), (), ("Gmsh", "meshio")),
    ("msh", (1, 2), ("--msh-version", "2.2", "--ascii"), ("Gmsh", "meshio", "GetFEM")),
    ("msh", (1,), ("--msh-version", "2.2", "--ascii"), ("gmshToFoam",)),
    ("mesh", (1,), (), ("FreeFEM", "meshio")),
    ("inp", (1, 2), (), ("CalculiX", "meshio")),
    ("med", (1, 2), (), ("medconforme, mdump", "meshio")),
    ("med", (1,), (), ("code_saturne",)),
    ("cgns", (1, 2), (), ("cgnscheck", "VTK")),
    ("cgns", (1,), (), ("code_saturne",)),
    ("exo", (1, 2), (), ("netCDF4", "libexodus", "VTK", "meshio")),
    ("su2", (1,), (), ("meshio",)),
    ("lb8.ugrid", (1,), (), ("meshio",)),
    ("bdf", (1,), (), ("meshio",)),
    ("foam", (1,), (), ("checkMesh",)),
    ("foam", (1,), ("--parts", "3"), ("checkMesh -parallel, reconstructParMesh",)),
)


def verdict_of(reader, mesh):
    is_there, read = READERS[reader]
    if not is_there():
        return "not installed"
    try:
        return read(mesh) or "ok"
    except Complaint as complaint:
        return f"FAILED: {complaint}"


def verdicts(options, model):
    """For each format and order what each reader says."""
    for extension, orders, more, readers in FORMATS:
        for order in orders:
            place = f"{model.stem:16.16} .{extension:9} order {order}"
            try:
                mesh = Meshed(options, model, extension, order, more)
            except Complaint as complaint:
                yield f"{place}  tetloom            FAILED: {complaint}"
                continue
            for reader in readers:
                yield f"{place}  {reader:18} {verdict_of(reader, mesh)}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--tetloom", required=True)
    parser.add_argument("--folder", required=True)
    parser.add_argument("--size", default="0.05", help="edge length as a share of the diagonal")
    parser.add_argument("models", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    options.folder = pathlib.Path(options.folder).resolve()
    options.tetloom = str(pathlib.Path(options.tetloom).resolve())
    failures = 0
    for model in options.models:
        for line in verdicts(options, model):
            print(line, flush=True)
            failures += "FAILED" in line
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
