#pragma once
// The triangles of an STL or OBJ file as they are, to judge a model apart from the library's own reading.
#include <filesystem>

#include "tetloom/mesh_data.hpp"

namespace tetloom::bench {

/// Whether a model of this extension is made of facets.
bool is_facet_file(const std::filesystem::path& path);

/// The points and triangles of a file, equal points merged; polygons are cut into fans. Lenient: what it does not
/// know it passes over. Throws std::runtime_error where there is no triangle.
Mesh read_facet_file(const std::filesystem::path& path);

/// Whether every edge has exactly two triangles, those with a repeated point left out, and there are some.
bool is_closed_manifold(const Mesh& facets);

/// The signed volume that closed facets enclose; positive where they face outwards.
double enclosed_volume(const Mesh& facets);

/// The volume around which closed facets wind at least once, however often they pass through themselves; by 512 × 512
/// columns, to some thousandths.
double wound_volume(const Mesh& facets);

}  // namespace tetloom::bench
