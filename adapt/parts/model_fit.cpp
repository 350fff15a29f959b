#include "adapt/parts/model_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "core/geometry/model_projector.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

namespace {

constexpr double kTolerance = 1e-6;  // of the model's diagonal
constexpr double kUnledShare = 0.1;  // of the shortest edge at a vertex
constexpr std::array<const char*, 4> kKinds{"vertex", "edge", "face", "region"};

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

class FitCheck {
 public:
  FitCheck(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model, const TaskRunner& runner,
           std::span<const std::uint32_t> numbers)
      : whole_(whole), mesh_(mesh), model_(model), runner_(runner), numbers_(numbers) {}

  void run() {
    check_names();
    check_edges_are_named();
    find_allowances();
    check_corners();
    check_places();
  }

 private:
  void check_name(int dim, std::uint32_t index) const {
    const std::size_t count = model_.topology().count(dim);
    if (index == kNone || index < count) return;
    throw Error(ErrorCode::InputUnsuitable, std::string("the mesh has a ") + kKinds[static_cast<std::size_t>(dim)] +
                                                " " + std::to_string(std::uint64_t{index} + 1) +
                                                ", but the model has only " + std::to_string(count));
  }

  // Vertices beyond the model's are corners of the mesh alone: where edges of the model were merged, or unnamed ones
  // meet. They stay where they are.
  void check_names() const {
    for (const LinkedTriangle& t : whole_.triangles) check_name(2, t.triangle.face);
    for (const std::uint32_t edge : mesh_.edge_to_entity) check_name(1, edge);
    for (const std::uint32_t region : mesh_.tet_to_entity) check_name(3, region);
    for (const ModelEntity& entity : mesh_.point_to_entity)
      if (entity.valid() && entity.dim > 0) check_name(entity.dim, entity.index);
  }

  // Those that the mesh does not name have names of their own in `whole_`, which mean nothing to the model.
  void check_edges_are_named() const {
    std::vector<ModelEdgePiece> named;
    named.reserve(mesh_.edge_to_vert.size());
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      named.push_back({{std::min(a, b), std::max(a, b)}, mesh_.edge_to_entity[i]});
    }
    std::sort(named.begin(), named.end());
    for (const ModelEdgePiece& piece : whole_.edges) {
      if (std::binary_search(named.begin(), named.end(), piece)) continue;
      throw Error(Diagnostic{ErrorCode::InputUnsuitable,
                             "faces of the mesh meet in an edge that it names no edge of the model for",
                             {},
                             whole_.points[piece.verts[0]],
                             {}});
    }
  }

  // How far a vertex may lie from its entity, whatever that is.
  void find_allowances() {
    shortest_.assign(whole_.points.size(), HUGE_VAL);
    for (const LinkedTriangle& t : whole_.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = t.triangle.verts[i], b = t.triangle.verts[(i + 1) % 3];
        const double length = distance(whole_.points[a], whole_.points[b]);
        shortest_[a] = std::min(shortest_[a], length), shortest_[b] = std::min(shortest_[b], length);
      }
    }
  }

  std::optional<Diagnostic> judge(ModelEntity entity, std::uint32_t vert, const Vec3& place) const {
    const double off = distance(place, whole_.points[vert]);
    const double allowed =
        std::max({model_.attributes(entity).tolerance, kTolerance * model_.bounding_box().diagonal(),
                  std::isfinite(shortest_[vert]) && entity.dim > 0 ? kUnledShare * shortest_[vert] : 0.0});
    if (off <= allowed) return {};
    return Diagnostic{
        ErrorCode::InputUnsuitable,
        "the model does not match the mesh: a vertex lies " + number(off) + " away from what it is classified on",
        {model_.named(entity)},
        whole_.points[vert],
        {numbers_.empty() ? vert : numbers_[vert]}};
  }

  void check_corners() const {
    for (std::uint32_t v = 0; v < mesh_.point_to_entity.size(); ++v) {
      const ModelEntity entity = mesh_.point_to_entity[v];
      if (!entity.valid() || entity.dim != 0 || entity.index >= model_.topology().vertex_count) continue;
      if (const auto fault = judge(entity, v, model_.vertex_point(ModelVertexId(entity.index)))) throw Error(*fault);
    }
  }

  void check_places() const {
    const std::size_t edges = model_.topology().edge_count(), faces = model_.topology().face_count();
    std::vector<std::vector<std::uint32_t>> verts(edges + faces);
    for (std::uint32_t v = 0; v < whole_.to_entity.size(); ++v) {
      const ModelEntity entity = whole_.to_entity[v].unpack();
      if (!entity.valid() || (entity.dim != 1 && entity.dim != 2)) continue;
      verts[entity.dim == 1 ? entity.index : edges + entity.index].push_back(v);
    }
    std::vector<std::optional<Diagnostic>> faults(verts.size());
    std::vector<double> work;
    for (const auto& each : verts) work.push_back(static_cast<double>(each.size()));
    runner_.for_each_largest_first(work, [&](std::size_t i) {
      if (verts[i].empty()) return;
      const bool is_edge = i < edges;
      faults[i] =
          first_off(ModelEntity(is_edge ? 1 : 2, static_cast<std::uint32_t>(is_edge ? i : i - edges)), verts[i]);
    });
    for (const auto& fault : faults)
      if (fault) throw Error(*fault);
  }

  // Where the model cannot tell the nearest place there is nothing to compare with.
  std::optional<Diagnostic> first_off(ModelEntity entity, const std::vector<std::uint32_t>& verts) const {
    const SurfaceProjector project = make_projector(model_);
    for (std::size_t i = 0; i < verts.size(); ++i) {
      if (i % 256 == 0) runner_.check_cancelled();
      const auto spot = project(entity, whole_.points[verts[i]]);
      if (!spot) continue;
      if (auto fault = judge(entity, verts[i], spot->point)) return fault;
    }
    return {};
  }

  const WholeMesh& whole_;
  const Mesh& mesh_;
  const GeometricModel& model_;
  const TaskRunner& runner_;
  std::span<const std::uint32_t> numbers_;
  std::vector<double> shortest_;
};

}  // namespace

void require_model_fits(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model, const TaskRunner& runner,
                        std::span<const std::uint32_t> numbers) {
  FitCheck(whole, mesh, model, runner, numbers).run();
}

}  // namespace tetloom::adapt
