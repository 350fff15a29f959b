#!/usr/bin/env python3
"""Draws the three figures of docs/architecture.md: the floors, what happens to a model, what happens to one tet.

usage: scripts/draw_architecture.py [FOLDER]      default: docs/images
Writes architecture_floors.svg, architecture_model.svg and architecture_tet.svg. A text that does not fit its box, and an
import that scripts/check_imports.py does not allow, end it with an error.
"""
import sys
from html import escape
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from check_imports import MAY_INCLUDE  # noqa: E402

INK, GREY, PAPER = "#1f2933", "#5b6770", "#ffffff"
BLUE, GREEN, ORANGE, VIOLET, PLAIN = "#dcebf7", "#dff1e4", "#fbe9d3", "#ece3f4", "#f1f3f5"
TITLE_WIDTH, LINE_WIDTH = 7.9, 6.5  # of a letter, at most on average; pixels


class Drawing:
    """An SVG in pixels; y points downwards."""

    def __init__(self, width, height, title):
        self.width, self.height, self.title = width, height, title
        self.parts = []

    def text(self, x, y, text, size=12, anchor="middle", weight="normal", colour=INK):
        self.parts.append(f'<text x="{x:g}" y="{y:g}" font-size="{size}" text-anchor="{anchor}" font-weight="{weight}" '
                          f'fill="{colour}">{escape(text)}</text>')

    def box(self, x, y, width, title, lines=(), fill=PLAIN, height=None, dashed=False):
        """A box with a bold title and lines below; returns (x, y, width, height)."""
        height = height or 28 + 16 * len(lines) + (4 if lines else 0)
        for text, letter in [(title, TITLE_WIDTH)] + [(line, LINE_WIDTH) for line in lines]:
            if len(text) * letter > width - 8:
                sys.exit(f"draw_architecture.py: '{text}' does not fit its box in '{self.title}'")
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        self.parts.append(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="6" fill="{fill}" '
                          f'stroke="{GREY}"{dash}/>')
        first = y + (height - 16 * len(lines)) / 2 + 5
        self.text(x + width / 2, first, title, 14, weight="bold")
        for i, line in enumerate(lines):
            self.text(x + width / 2, first + 16 * (i + 1), line, colour=GREY)
        return x, y, width, height

    def arrow(self, points, label="", at=None, anchor="start", dashed=False):
        path = "M" + " L".join(f"{x:g},{y:g}" for x, y in points)
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        self.parts.append(f'<path d="{path}" fill="none" stroke="{INK}" stroke-width="1.4"{dash} '
                          f'marker-end="url(#head)"/>')
        for i, line in enumerate(label.split("\n") if label else []):
            self.text(at[0], at[1] + 15 * i, line, anchor=anchor)

    def svg(self):
        return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{self.width}" height="{self.height}" '
                f'viewBox="0 0 {self.width} {self.height}" font-family="DejaVu Sans, Helvetica, Arial, sans-serif">\n'
                f'<title>{escape(self.title)}</title>\n'
                '<defs><marker id="head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" '
                f'orient="auto-start-reverse"><path d="M0,0 L10,5 L0,10 z" fill="{INK}"/></marker></defs>\n'
                f'<rect width="{self.width}" height="{self.height}" fill="{PAPER}"/>\n'
                + "\n".join(self.parts) + "\n</svg>\n")


def below(upper, lower, shift=0.0):
    """The end points of an arrow from the lower edge of one box to the upper edge of another, straight down."""
    x = max(upper[0], lower[0]) + min(upper[0] + upper[2], lower[0] + lower[2])
    x = x / 2 + shift
    return [(x, upper[1] + upper[3]), (x, lower[1])]


def draw_floors():
    d = Drawing(900, 560, "The floors of tetloom and their imports")
    floors = {
        "apps": d.box(20, 20, 310, "apps", ["tetloom, the command", "tetgen_worker, a process of its own (TetGen)"], ORANGE),
        "bench": d.box(350, 20, 160, "bench", ["one executable", "per claim"], ORANGE),
        "examples": d.box(530, 20, 160, "examples", ["host program,", "demo models, loop"], ORANGE),
        "tests": d.box(710, 20, 170, "tests", ["beside each concern;", "see every floor"], ORANGE),
        "mesher": d.box(20, 150, 420, "mesher", ["sizing · surface · features · intersection", "lattice · tets · parts · volume"], GREEN),
        "adapt": d.box(460, 150, 420, "adapt", ["metric · kernel · parts · transfer", "in stages and rounds"], GREEN),
        "threading": d.box(20, 280, 860, "threading", [
            "runtime (loops, traces) · comm (ranks, messages, task graph) · parts (migration, links, part files) · balance",
            "only here: oneTBB, MPI, Scotch, Zoltan"], BLUE),
        "core": d.box(20, 400, 860, "core", [
            "base · spatial · predicates · geometry (the interface to a model) · cad · discrete (its implementations)",
            "mesh · part · tets · sizing · io",
            "only here: OpenCASCADE in cad, OpenMesh in discrete, zlib in io"], VIOLET),
    }
    imports = [("mesher", "threading"), ("adapt", "threading"), ("threading", "core"), ("apps", "mesher"),
               ("bench", "mesher"), ("examples", "adapt"), ("tests", "adapt")]
    for room, target in imports:
        if target not in MAY_INCLUDE[room]:
            sys.exit(f"draw_architecture.py: {room} may not include {target}")
        d.arrow(below(floors[room], floors[target]))
    d.text(450, 515, "An arrow says: may include, and so may include everything that lies lower.", colour=GREY)
    d.text(450, 535, "mesher and adapt stand side by side; neither includes the other. Checked by scripts/check_imports.py.",
           colour=GREY)
    return d


def draw_model():
    d = Drawing(900, 880, "What happens to a model")
    x, width = 250, 400
    steps = [
        ("STEP, IGES, BREP, STL or OBJ file", [], PLAIN),
        ("1 Read", ["core/cad, core/discrete", "→ GeometricModel: topology as tables, shape by questions"], VIOLET),
        ("2 Size field", ["mesher/sizing, core/sizing", "→ SizeField: one immutable octree"], GREEN),
        ("3 Surface", ["mesher/surface: edges once each, then faces", "→ Mesh of triangles that fit along edges"], GREEN),
        ("4 Small features", ["mesher/features: merged away in the surface mesh"], GREEN),
        ("5 Self-intersections", ["mesher/intersection: exact, within each complex"], GREEN),
        ("6 Check of solids", ["mesher/check_solids: volume, orientation, overlaps"], GREEN),
        ("7 Volume", ["mesher/volume: every closed complex of faces", "→ tets, in parts where there are many"], GREEN),
        ("8 Second order", ["mesher/second_order: mid nodes on the model, where wanted"], GREEN),
        ("9 Measure", ["core/mesh: quality, edges against sizes, digest"], VIOLET),
        ("10 Write", ["core/io; parts: threading", "→ .vtu .msh .mesh .meshb .stl · .pvtu and .msh in parts"], BLUE),
    ]
    y, boxes = 20, []
    for title, lines, fill in steps:
        boxes.append(d.box(x, y, width, title, lines, fill))
        y = boxes[-1][1] + boxes[-1][3] + 26
    for upper, lower in zip(boxes, boxes[1:]):
        d.arrow(below(upper, lower))
    size, crossing = boxes[2], boxes[5]
    right = x + width
    d.arrow([(right, crossing[1] + 20), (right + 30, crossing[1] + 20), (right + 30, size[1] + 30), (right, size[1] + 30)])
    for i, line in enumerate(["surface crosses itself,", "or a wall is narrower", "than .4 of its size:", "smaller sizes there,", "at most 6 rounds"]):
        d.text(right + 40, size[1] + 110 + 16 * i, line, anchor="start")
    volume = boxes[7]
    worker = d.box(20, volume[1] - 4, 170, "tetloom-tetgen", ["last resort, where", "recovery fails"], ORANGE, dashed=True)
    d.arrow([(x, volume[1] + 32), (worker[0] + worker[2], volume[1] + 32)], dashed=True)
    for i, line in enumerate(["Under mpirun every rank reads", "the model and holds the surface.", "Sizes, faces and volume are", "shared out among the ranks."]):
        d.text(20, boxes[1][1] + 18 + 16 * i, line, anchor="start", colour=GREY)
    return d


def draw_tet():
    d = Drawing(900, 870, "What happens to one tet")
    core = d.box(40, 50, 390, "Lattice core", ["mesher/lattice: at an undisturbed site, written", "in closed form with its neighbours"], GREEN)
    shell = d.box(470, 50, 390, "Delaunay shell", ["mesher/tets: near the surface and between lattices,", "points inserted one by one"], GREEN)
    d.text(450, 30, "A tet begins in one of two places. In parts: the part of its lowest vertex makes it.", 13)
    recovery = d.box(470, 155, 390, "Recovery", ["a surface triangle is no face: the tets it crosses", "are replaced by others that have it"], GREEN)
    d.arrow(below(shell, recovery))
    join = d.box(245, 250, 410, "Join", ["core and shell linked, face to face; outside dropped,", "region named from the surface"], GREEN)
    d.arrow([(235, core[1] + core[3]), (235, 275), (245, 275)])
    d.arrow(below(recovery, join))
    relax = d.box(245, 345, 410, "Relaxation, where sizes vary", ["vertices spread, tets exchanged 2-3 and 3-2"], GREEN)
    optimise = d.box(245, 425, 410, "Optimiser", ["edge removal, Newton steps of vertices;", "for the poorest: vertices removed, points inserted"], GREEN)
    strips = d.box(245, 520, 410, "Strips, where there are parts", ["poor tets at part sides migrate to one part", "and are optimised there, three rounds"], BLUE)
    surface = d.box(245, 615, 410, "Surface improvement", ["where allowed: surface edges swapped, points slid"], GREEN)
    for upper, lower in [(join, relax), (relax, optimise), (optimise, strips), (strips, surface)]:
        d.arrow(below(upper, lower))
    mesh = d.box(245, 695, 410, "In the mesh", ["orientation checked exactly; region, global ids kept;", "dealt to parts by threading/balance, then migrated"], VIOLET)
    d.arrow(below(surface, mesh))
    adapt = d.box(245, 790, 410, "Adaptation", ["dealt along another Hilbert curve in every round;", "split, collapse, swap, move: positive by exact sign"], ORANGE)
    d.arrow(below(mesh, adapt))
    right = 655
    d.arrow([(right, 832), (right + 40, 832), (right + 40, 806), (right, 806)])
    d.text(right + 50, 800, "rounds, until edges", anchor="start")
    d.text(right + 50, 816, "have length 1", anchor="start")
    d.text(right + 50, 832, "in the metric", anchor="start")
    for i, line in enumerate(["A tet in a cavity that", "is refilled ends. The tets", "in its place are positive", "and fill the same space."]):
        d.text(30, 440 + 16 * i, line, anchor="start", colour=GREY)
    for i, line in enumerate(["A tet that no operation", "touches stays as it was", "made: most of the core."]):
        d.text(680, 440 + 16 * i, line, anchor="start", colour=GREY)
    return d


def drawings():
    """The text of each file by its name."""
    return {"architecture_floors.svg": draw_floors().svg(), "architecture_model.svg": draw_model().svg(),
            "architecture_tet.svg": draw_tet().svg()}


def main():
    root = Path(__file__).resolve().parent.parent
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else root / "docs" / "images"
    for name, text in drawings().items():
        (folder / name).write_text(text, encoding="utf-8")
        print(folder / name)


if __name__ == "__main__":
    main()
