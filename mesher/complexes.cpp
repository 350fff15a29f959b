#include "mesher/complexes.hpp"

#include "core/base/disjoint_sets.hpp"

namespace tetloom {

std::vector<std::uint32_t> find_complexes(const ModelTopology& topology) {
  DisjointSets sets(topology.face_count());
  std::vector<std::uint32_t> region_to_face(topology.region_count(), kNone);
  std::vector<std::uint32_t> edge_to_sheet(topology.edge_count(), kNone);
  const auto join_through = [&](std::uint32_t& first, std::uint32_t face) {
    if (first == kNone)
      first = face;
    else
      sets.join(first, face);
  };
  for (std::uint32_t f = 0; f < topology.face_count(); ++f) {
    const FaceSides& sides = topology.face_to_sides[f];
    if (sides.front.valid()) join_through(region_to_face[sides.front.value], f);
    if (sides.back.valid()) join_through(region_to_face[sides.back.value], f);
    if (sides.front.valid() || sides.back.valid()) continue;
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop) join_through(edge_to_sheet[use.edge.value], f);
  }
  std::vector<std::uint32_t> numbers(topology.face_count(), kNone), complexes(topology.face_count());
  std::uint32_t count = 0;
  for (std::uint32_t f = 0; f < topology.face_count(); ++f) {
    std::uint32_t& number = numbers[sets.find(f)];
    if (number == kNone) number = count++;
    complexes[f] = number;
  }
  return complexes;
}

}  // namespace tetloom
