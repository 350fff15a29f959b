#pragma once
// What is wrong with a shape, in the words of its entities. Private to core/cad.
#include <BRepCheck_Analyzer.hxx>
#include <memory>

#include "core/cad/detail/topology.hpp"
#include "tetloom/host.hpp"

namespace tetloom::cad {

/// Checks `shape` and everything inside, on the threads of `loop`.
std::unique_ptr<BRepCheck_Analyzer> analyze(const TopoDS_Shape& shape, const BlockLoop& loop);

/// How many faults the analyser found in `shape` and everything inside.
std::size_t count_faults(const BRepCheck_Analyzer& analyzer, const TopoDS_Shape& shape);

/// Edges with only one face beside them, in the shells of a shape. Seams and degenerate edges are not open.
std::vector<TopoDS_Edge> find_open_edges(const TopoDS_Shape& shape);

/// A warning for every invalid face, edge and vertex of these bodies, with a point.
std::vector<Diagnostic> describe_faults(const std::vector<TopoDS_Shape>& bodies, const ShapeTables& shapes,
                                        const BlockLoop& loop);

/// A warning for every region and every shell outside regions that has open edges, with a point.
std::vector<Diagnostic> describe_open_shells(const TopoDS_Shape& root, const ShapeTables& shapes);

}  // namespace tetloom::cad
