#pragma once
// The file of --sizes: sizes of single model entities and points.
//
//   {"entities": [{"dim": 2, "tag": 17, "size": 0.5}, {"name": "flange", "size": 1}],
//    "points":   [{"point": [0, 0, 10], "size": 0.1}]}
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

namespace tetloom::app {

/// One entry of "entities": by tag, or by name. A name stands for every entity that bears it, of the given dimension
/// if there is one.
struct EntitySizeWish {
  std::optional<int> dim;
  std::optional<std::uint32_t> tag;
  std::string name;
  double size = 0;
};

/// The wishes of one file, as they are written there.
struct SizesFile {
  std::vector<EntitySizeWish> entities;
  std::vector<PointSize> points;
};

/// Reads the file without looking at a model. `path` is for messages.
/// Errors: InvalidArgument with the line, or with the entry that is wrong, such as "entities[3]".
SizesFile parse_sizes(const std::string& text, const std::string& path);
SizesFile read_sizes(const std::filesystem::path& path);

/// Finds the entities in `model` and adds all sizes to `options`.
/// Errors: InvalidArgument that lists all tags and names that the model does not have.
void apply_sizes(const SizesFile& file, const GeometricModel& model, SizeOptions& options);

}  // namespace tetloom::app
