#include "tetloom/host.hpp"

namespace tetloom {

std::string_view to_string(Stage stage) {
  switch (stage) {
    case Stage::Read: return "read";
    case Stage::SizeField: return "size field";
    case Stage::Edges: return "edges";
    case Stage::Faces: return "faces";
    case Stage::Intersections: return "intersections";
    case Stage::Layers: return "layers";
    case Stage::Volume: return "volume";
    case Stage::SecondOrder: return "second order";
    case Stage::Partition: return "partition";
    case Stage::Adapt: return "adapt";
    case Stage::Check: return "check";
    case Stage::Write: return "write";
  }
  return "";
}

}  // namespace tetloom
