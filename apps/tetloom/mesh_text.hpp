#pragma once
// A mesh as `info` and `check` describe it.
#include <string>

#include "apps/tetloom/report.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::app {

/// Counts of all kinds of elements, bounding box, names of fields, regions, faces and quality, with `report.quality`
/// where that is known.
std::string render_mesh(const Mesh& mesh, const RunReport& report);

/// The same as JSON: {"bounding_box", "regions": [{"id", "name", "tets", "cells", "volume"}], "faces": [{"id", "name",
/// "triangles", "area", "min_angle_deg"}], "edges", "quadrilaterals", "pyramids", "prisms", "hexahedra",
/// "point_fields": [{"name", "components"}], "cell_fields": […]}.
nlohmann::ordered_json mesh_json(const Mesh& mesh, const RunReport& report);

}  // namespace tetloom::app
