#include "adapt/input_checks.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

#include "adapt/kernel/surface_map.hpp"
#include "core/base/mix_bits.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/part_mesh.hpp"

namespace tetloom::adapt {

namespace {

// Measured are 117 and 29 in one process, and up to 73 in tiles on 8 ranks, of 2 to 6 million tets that stay about as
// many or become twice as many.
constexpr double kBytesPerTet = 130;          // of the result, on the rank that has it
constexpr double kBytesPerGiven = 35;         // of what is given, in one process
constexpr double kBytesPerGivenInTiles = 75;  // on the rank that has it: the tile at home, and copies elsewhere
constexpr double kBytesPerComponent = 100;    // of a field on what is given: values, gradients, and copies of both
// Indices of entities: as many again are left for corners and edges that the mesh does not name, below kTouching.
constexpr std::uint32_t kMostGiven = kTouching / 2;

std::string text_of(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", value);
  return text.data();
}

// Tables of corners and edges get places for those that the mesh does not name, so no tag may lie far behind them.
void require_in_tables(const Mesh& mesh) {
  const auto require = [&](ModelEntity entity, const char* what, std::size_t element) {
    const std::size_t known = mesh.entities[entity.dim].size();
    if (known == 0 || entity.index < known) return;
    throw Error(Diagnostic{ErrorCode::InputUnsuitable,
                           std::string(what) + " lies on the entity with tag " + std::to_string(entity.tag()) +
                               ", but the mesh's table of these ends at " + std::to_string(known),
                           {},
                           {},
                           {element}});
  };
  for (std::size_t v = 0; v < mesh.point_to_entity.size(); ++v)
    if (mesh.point_to_entity[v].valid() && mesh.point_to_entity[v].dim < 2)
      require(mesh.point_to_entity[v], "a point of the mesh", v);
  for (std::size_t e = 0; e < mesh.edge_to_entity.size(); ++e)
    if (mesh.edge_to_entity[e] != kNone) require({1, mesh.edge_to_entity[e]}, "an edge of the mesh", e);
}

class Fingerprint {
 public:
  explicit Fingerprint(const BlockLoop& loop) : loop_(loop) {}

  template <class T>
  void add(std::span<const T> values) {
    constexpr std::size_t kGrain = std::size_t{1} << 14;
    add(std::uint64_t{values.size()});
    for (const std::uint64_t block :
         map_blocks(loop_, values.size(), kGrain, std::uint64_t{0}, [&](std::size_t begin, std::size_t end, auto&hash) {
           for (const T& value : values.subspan(begin, end - begin)) hash = mixed(hash, value);
         }))
      add(block);
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(std::span<const T>(values));
  }
  template <class T>
  requires std::is_arithmetic_v<T>
  void add(T value) { hash_ = mixed(hash_, value); }

  std::uint64_t hash() const { return hash_; }

 private:
  template <class T>
  static std::uint64_t mixed(std::uint64_t hash, const T& value) {
    if constexpr (std::is_same_v<T, ModelEntity>) {
      return mixed(hash, std::uint64_t{value.dim} << 32 | value.index);
    } else {
      static_assert(std::is_trivially_copyable_v<T>);
      std::array<std::uint64_t, (sizeof(T) + 7) / 8> words{};
      std::memcpy(words.data(), &value, sizeof(T));
      for (const std::uint64_t word : words) hash = mix_bits((hash ^ word) + kOdd);
      return hash;
    }
  }

  static constexpr std::uint64_t kOdd = 0x9e3779b97f4a7c15u;

  const BlockLoop& loop_;
  std::uint64_t hash_ = 0;
};

}  // namespace

void check_mesh(const Mesh& mesh, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    if (!is_finite(mesh.points[v]))
      throw Error(Diagnostic{ErrorCode::InputUnsuitable, "the mesh has points that are not finite", {}, {}, {v}});
  require_entities_below(mesh, kMostGiven, loop);
  require_in_tables(mesh);
}

void check_metric(const MetricField& metric, const Mesh& mesh) {
  if (metric.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "the metric has " + std::to_string(metric.size()) + " values for " +
                                                std::to_string(mesh.points.size()) + " points");
  for (std::size_t v = 0; v < metric.size(); ++v)
    if (!is_finite(metric.logs[v]))
      throw Error(
          Diagnostic{ErrorCode::InputUnsuitable, "the metric is not finite at a point", {}, mesh.points[v], {v}});
}

void check_load(const AdaptLoad& load) { check_load(load, memory_limits()); }

void check_load(const AdaptLoad& load, const MemoryLimits& limits) {
  const double tets = expected_tets(load.complexity);
  if (!(tets / load.ranks < static_cast<double>(CellPlace::kMaxTets)))
    throw Error(ErrorCode::OutOfMemory, "the metric asks for about " + text_of(tets) +
                                            " tetrahedra, more than can be counted; ask for larger sizes");
  const std::uint64_t room = limits.for_each_of(load.ranks_on_machine);
  const auto bytes = [&](double per_given) {
    return kBytesPerTet * tets + (per_given + kBytesPerComponent * load.components) * load.given;
  };
  const double all = bytes(load.ranks > 1 ? kBytesPerGivenInTiles : kBytesPerGiven);
  if (room == MemoryLimits::kUnlimited || all / load.ranks <= static_cast<double>(room)) return;
  std::string message = "the mesh would hold about " + text_of(tets) + " tetrahedra and need " +
                        text_of(all / load.ranks / 1e9) + " GB of memory" +
                        (load.ranks > 1 ? " on each of " + std::to_string(load.ranks) + " ranks, but " : ", but ") +
                        text_of(static_cast<double>(room) / 1e9) + " GB are free" +
                        (load.ranks > 1 ? " for each" : "") + "; ask for larger sizes";
  if (room > 0)
    message += ", or for " + text_of(std::ceil(bytes(kBytesPerGivenInTiles) / static_cast<double>(room))) +
               " ranks that have as much each";
  throw Error(ErrorCode::OutOfMemory, message);
}

std::uint64_t fingerprint(const Mesh& mesh, const MetricField& metric, const SolutionMetric* solution,
                          const AdaptOptions& options, const BlockLoop& loop) {
  Fingerprint all(loop);
  all.add(mesh.points), all.add(mesh.point_to_entity);
  all.add(mesh.edge_to_vert), all.add(mesh.edge_to_entity);
  all.add(mesh.tri_to_vert), all.add(mesh.tri_to_entity);
  all.add(mesh.tet_to_vert), all.add(mesh.tet_to_entity);
  all.add(metric.logs);
  if (solution != nullptr) {
    const auto& [field, of] = *solution;
    all.add(std::span<const char>(field));
    for (const double value :
         {of.complexity, of.norm, of.gradation, of.bounds.h_min, of.bounds.h_max, of.bounds.max_aspect})
      all.add(value);
  }
  for (const double value : {options.quality_floor, options.gradation, options.tets_per_part}) all.add(value);
  if (options.curvature) all.add(options.curvature->edges_per_turn), all.add(options.curvature->h_min);
  all.add(options.parts), all.add(static_cast<int>(options.cell_reconstruction)), all.add(options.model != nullptr);
  for (const std::string& name : options.transfer) {
    all.add(std::span<const char>(name));
    for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
      for (const MeshField& field : *fields)
        if (field.name == name) all.add(field.components), all.add(field.values);
  }
  return all.hash();
}

}  // namespace tetloom::adapt
