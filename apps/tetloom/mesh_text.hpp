#pragma once
// A mesh as `info` and `check` describe it.
#include <string>

#include "apps/tetloom/report.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom::app {

/// Counts, bounding box, regions, faces and quality, with `report.quality` where that is known.
std::string render_mesh(const Mesh& mesh, const RunReport& report);

/// The same as JSON: {"bounding_box", "regions": [{"id", "name", "tets", "volume"}], "faces": [{"id", "name",
/// "triangles", "area", "min_angle_deg"}], "edges", …}.
nlohmann::ordered_json mesh_json(const Mesh& mesh, const RunReport& report);

}  // namespace tetloom::app
