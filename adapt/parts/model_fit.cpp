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

constexpr double kPlaceTolerance = 1e-6;  // of the model's diagonal
constexpr double kUnledShare = 0.1;       // of the shortest edge at a vertex
constexpr double kBesideShare = 1;        // of the longest edge at a vertex: what is smaller may have been eliminated
constexpr double kMostBeside = 0.125;     // of the vertices on the model

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

class FitCheck {
 public:
  FitCheck(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model, const TaskRunner& runner,
           std::span<const Number> numbers)
      : whole_(whole), mesh_(mesh), model_(model), runner_(runner), numbers_(numbers) {}

  VerticesBesideModel run() {
    check_names();
    check_edges_are_named();
    find_allowances();
    check_corners();
    check_places();
    beside_.vertices = std::ranges::count_if(whole_.to_entity, [](const auto& packed) {
      const ModelEntity entity = packed.unpack();
      return entity.valid() && entity.dim < 3;
    });
    return std::move(beside_);
  }

 private:
  void check_name(int dim, std::uint32_t index) const {
    const std::size_t count = model_.topology().count(dim);
    if (index == kNone || index < count) return;
    throw Error(ErrorCode::InputUnsuitable,
                "the mesh has a " + std::string(kEntityKinds[static_cast<std::size_t>(dim)]) + " " +
                    std::to_string(std::uint64_t{index} + 1) + ", but the model has only " + std::to_string(count));
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
    longest_.assign(whole_.points.size(), 0);
    for (const LinkedTriangle& t : whole_.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = t.triangle.verts[i], b = t.triangle.verts[(i + 1) % 3];
        const double length = distance(whole_.points[a], whole_.points[b]);
        shortest_[a] = std::min(shortest_[a], length), shortest_[b] = std::min(shortest_[b], length);
        longest_[a] = std::max(longest_[a], length), longest_[b] = std::max(longest_[b], length);
      }
    }
  }

  enum class Fit : std::uint8_t { On, Beside, Elsewhere };

  // Beside the model lie vertices at which a small feature of it was eliminated.
  Fit fit_of(ModelEntity entity, std::uint32_t vert, const Vec3& place) const {
    const double off = distance(place, whole_.points[vert]);
    const double on =
        std::max({model_.attributes(entity).tolerance, kPlaceTolerance * model_.bounding_box().diagonal(),
                  std::isfinite(shortest_[vert]) && entity.dim > 0 ? kUnledShare * shortest_[vert] : 0.0});
    if (off <= on) return Fit::On;
    return off <= kBesideShare * longest_[vert] ? Fit::Beside : Fit::Elsewhere;
  }

  Diagnostic fault_at(ModelEntity entity, std::uint32_t vert, const Vec3& place) const {
    return {ErrorCode::InputUnsuitable,
            "the model does not match the mesh: a vertex lies " + number(distance(place, whole_.points[vert])) +
                " away from what it is classified on",
            {model_.named(entity)},
            whole_.points[vert],
            {numbers_.empty() ? vert : numbers_[vert]}};
  }

  void note_beside(std::int64_t count, std::optional<Diagnostic> first) {
    beside_.count += count;
    if (!beside_.first) beside_.first = std::move(first);
  }

  void check_corners() {
    for (std::uint32_t v = 0; v < mesh_.point_to_entity.size(); ++v) {
      const ModelEntity entity = mesh_.point_to_entity[v];
      if (!entity.valid() || entity.dim != 0 || entity.index >= model_.topology().vertex_count) continue;
      const Vec3 place = model_.vertex_point(ModelVertexId(entity.index));
      const Fit fit = fit_of(entity, v, place);
      if (fit == Fit::Elsewhere) throw Error(fault_at(entity, v, place));
      if (fit == Fit::Beside) note_beside(1, fault_at(entity, v, place));
    }
  }

  void check_places() {
    const std::size_t edges = model_.topology().edge_count(), faces = model_.topology().face_count();
    std::vector<std::vector<std::uint32_t>> verts(edges + faces);
    for (std::uint32_t v = 0; v < whole_.to_entity.size(); ++v) {
      const ModelEntity entity = whole_.to_entity[v].unpack();
      if (!entity.valid() || (entity.dim != 1 && entity.dim != 2)) continue;
      verts[entity.dim == 1 ? entity.index : edges + entity.index].push_back(v);
    }
    std::vector<Places> places(verts.size());
    std::vector<double> work;
    for (const auto& each : verts) work.push_back(static_cast<double>(each.size()));
    runner_.for_each_largest_first(work, [&](std::size_t i) {
      if (verts[i].empty()) return;
      const bool is_edge = i < edges;
      places[i] = look_at(ModelEntity(is_edge ? 1 : 2, static_cast<std::uint32_t>(is_edge ? i : i - edges)), verts[i]);
    });
    for (Places& found : places) {
      if (found.fault) throw Error(*found.fault);
      note_beside(found.beside, std::move(found.first_beside));
    }
  }

  // The vertices on one entity.
  struct Places {
    std::optional<Diagnostic> fault;  // the first that lies elsewhere
    std::int64_t beside = 0;
    std::optional<Diagnostic> first_beside;
  };

  // Where the model cannot tell the nearest place there is nothing to compare with.
  Places look_at(ModelEntity entity, const std::vector<std::uint32_t>& verts) const {
    Places found;
    const SurfaceProjector project = make_projector(model_);
    for (std::size_t i = 0; i < verts.size(); ++i) {
      if (i % 256 == 0) runner_.check_cancelled();
      const Vec3& x = whole_.points[verts[i]];
      auto spot = project(entity, x);
      if (spot && fit_of(entity, verts[i], spot->point) != Fit::On)
        spot = make_projector(model_)(entity, x);  // which has no other place to start from
      if (!spot) continue;
      const Fit fit = fit_of(entity, verts[i], spot->point);
      if (fit == Fit::On) continue;
      Diagnostic fault = fault_at(entity, verts[i], spot->point);
      if (fit == Fit::Elsewhere) {
        found.fault = std::move(fault);
        return found;
      }
      if (found.beside++ == 0) found.first_beside = std::move(fault);
    }
    return found;
  }

  const WholeMesh& whole_;
  const Mesh& mesh_;
  const GeometricModel& model_;
  const TaskRunner& runner_;
  std::span<const Number> numbers_;
  std::vector<double> shortest_, longest_;  // edge of the surface at each vertex
  VerticesBesideModel beside_;
};

}  // namespace

VerticesBesideModel require_model_fits(const WholeMesh& whole, const Mesh& mesh, const GeometricModel& model,
                                       const TaskRunner& runner, std::span<const Number> numbers) {
  return FitCheck(whole, mesh, model, runner, numbers).run();
}

void require_few(const VerticesBesideModel& beside) {
  const bool are_few = static_cast<double>(beside.count) <= kMostBeside * static_cast<double>(beside.vertices);
  if (!are_few && beside.first) throw Error(*beside.first);
}

}  // namespace tetloom::adapt
