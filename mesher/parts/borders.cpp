#include "mesher/parts/borders.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "core/base/lists.hpp"
#include "core/base/mix_bits.hpp"
#include "core/tets/many_values.hpp"
#include "core/tets/triangle_verts.hpp"
#include "mesher/parts/improve_part.hpp"
#include "mesher/parts/near_box.hpp"
#include "mesher/tets/acute_tets.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

constexpr double kReachInEdges = 6;  // of the open face

std::uint64_t name_of(std::array<VertKey, 3> keys) {
  std::sort(keys.begin(), keys.end());
  std::uint64_t name = 0;
  for (const VertKey key : keys) name = mix_bits(name * 0x9e3779b97f4a7c15u + key);
  return name;
}

std::vector<Placed<std::uint64_t>> name_open_faces(const KeyedTets& part, std::span<const FaceCode> open_faces) {
  const TetMesh& mesh = part.mesh;
  std::vector<Placed<std::uint64_t>> names;
  names.reserve(open_faces.size());
  for (const FaceCode face : open_faces) {
    const auto [a, b, c] = verts_of(mesh, face);
    names.push_back({mesh.points[a], reach_of(mesh, face), name_of({part.keys[a], part.keys[b], part.keys[c]})});
  }
  return names;
}

// Where names stand in a sorted list. Names are hashes: about one of them begins with each number of bits.
class NamePlaces {
 public:
  explicit NamePlaces(const std::vector<std::uint64_t>& names)
      : names_(names),
        shift_(static_cast<int>(64 - std::bit_width(names.size() | 1))),
        first_((std::size_t{2} << (63 - shift_)) + 1, 0) {
    for (const std::uint64_t name : names) ++first_[(name >> shift_) + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
  }

  // The first place of the name; the number of names where it is not there.
  std::size_t find(std::uint64_t name) const {
    const auto begin = names_.begin() + first_[name >> shift_], end = names_.begin() + first_[(name >> shift_) + 1];
    const auto at = std::find(begin, end, name);
    return at == end ? names_.size() : static_cast<std::size_t>(at - names_.begin());
  }

 private:
  const std::vector<std::uint64_t>& names_;
  int shift_;
  std::vector<std::uint32_t> first_;  // of those that begin with so many bits
};

tets::Fault check_open_faces(BorderCheck& check, std::span<const std::span<const std::uint64_t>> told) {
  std::sort(check.open_names.begin(), check.open_names.end());
  const NamePlaces places(check.open_names);
  std::vector<std::uint8_t> met(check.open_names.size(), 0);
  for (const auto& names : told) {
    for (const std::uint64_t name : names) {
      const std::size_t at = places.find(name);
      if (at < met.size()) met[at] = static_cast<std::uint8_t>(std::min(2, met[at] + 1));
    }
  }
  tets::Fault fault;
  for (std::size_t i = 0; i < met.size(); ++i) {
    if (met[i] == 0) check.unmet_names.push_back(check.open_names[i]);
    if (met[i] > 1) fault.message = "three parts have the same face";
  }
  return fault;
}

}  // namespace

double reach_of(const TetMesh& mesh, FaceCode open_face) {
  const auto [a, b, c] = verts_of(mesh, open_face);
  return kReachInEdges * std::max({distance(mesh.points[a], mesh.points[b]), distance(mesh.points[b], mesh.points[c]),
                                   distance(mesh.points[c], mesh.points[a])});
}

double least_reach_of(const TetMesh& mesh, FaceCode open_face) {
  const auto [a, b, c] = verts_of(mesh, open_face);
  return kReachInEdges * distance(mesh.points[a], mesh.points[b]);
}

BorderCheck send_borders(const SharedInput& input, const PartTets& part, std::span<const FaceCode> open_faces,
                         PartTask& task) {
  BorderCheck check;
  const std::vector<Placed<std::uint64_t>> names = name_open_faces(part, open_faces);
  for (const auto& name : names) check.open_names.push_back(name.what);
  const std::vector<Placed<std::uint32_t>> points = find_border_points(input, part, task.part());
  const std::span<const float> qualities = part.qualities.span();
  check.least_angle = tets::dihedral_of_worst(part.mesh, qualities);
  const bool stays = qualities.empty() || !wants_improvement(input, tets::least_of(qualities));
  const double told_angle = stays ? check.least_angle : HUGE_VAL;
  const auto neighbors = input.decomposition.neighbors(task.part());
  const auto near_names = near_neighbors(names, input.decomposition, task.part());
  const auto near_points = near_neighbors(points, input.decomposition, task.part());
  for (std::size_t n = 0; n < neighbors.size(); ++n) {
    MessageWriter writer;
    writer.put(told_angle);
    writer.put_array<std::uint64_t>(near_names[n]);
    writer.put_array<std::uint32_t>(near_points[n]);
    task.send(neighbors[n], writer.take());
  }
  return check;
}

tets::Fault take_borders(BorderCheck& check, PartTask& task) {
  std::vector<std::span<const std::uint64_t>> names;
  for (const Message& message : task.inbox()) {
    MessageReader reader(message.bytes);
    check.least_angle = std::min(check.least_angle, reader.get<double>());
    names.push_back(reader.get_view<std::uint64_t>());
    const auto points = reader.get_view<std::uint32_t>();
    check.surface_elsewhere.insert(check.surface_elsewhere.end(), points.begin(), points.end());
  }
  return check_open_faces(check, names);
}

bool all_faces_met(const AllParts& parts) {
  std::vector<std::uint64_t> names;
  for (const PartId part : parts.states.local()) {
    const auto& unmet = parts.states.at(part).check.unmet_names;
    names.insert(names.end(), unmet.begin(), unmet.end());
  }
  names = gather_lists<std::uint64_t>(parts.communicator, names);
  sort_unique(names);
  std::vector<std::int64_t> counts(names.size(), 0);
  for (const PartId part : parts.states.local()) {
    const auto& open = parts.states.at(part).check.open_names;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto [begin, end] = std::equal_range(open.begin(), open.end(), names[i]);
      counts[i] += end - begin;
    }
  }
  parts.communicator.sum(counts);
  return std::all_of(counts.begin(), counts.end(), [](std::int64_t count) { return count == 2; });
}

}  // namespace tetloom::parts
