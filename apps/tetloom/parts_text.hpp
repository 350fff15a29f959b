#pragma once
// The parts of a mesh as `partition` and `check` describe them.
#include <string>

#include <nlohmann/json.hpp>

#include "tetloom/partition.hpp"

namespace tetloom::app {

/// A row for each part; for more than 32, the range of each column and the parts with the most elements. Then imbalance
/// and cut faces.
std::string render_parts(const PartsFigures& figures);

/// {"elements", "vertices", "cut_faces", "edges", "imbalance": {"elements", "vertices", "weights"}, "table": [{"part",
/// "elements", "vertices", "boundary_share", "neighbours", "weight"}]}. Parts count from 0; boundary_share is that of
/// the vertices that other parts have too; edges are pairs of parts that share a face.
nlohmann::ordered_json parts_json(const PartsFigures& figures);

}  // namespace tetloom::app
