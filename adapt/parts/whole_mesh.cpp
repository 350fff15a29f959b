#include "adapt/parts/whole_mesh.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "core/tets/find_triangles.hpp"
#include "core/tets/link_tets.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

namespace {

[[noreturn]] void refuse(const std::string& message, const Vec3& point, std::uint64_t element) {
  throw Error(Diagnostic{ErrorCode::InputUnsuitable, message, {}, point, {element}});
}

void check_cells(const Mesh& mesh) {
  if (!mesh.pyramid_to_vert.empty() || !mesh.prism_to_vert.empty() || !mesh.hex_to_vert.empty())
    throw Error(ErrorCode::InputUnsuitable, "only meshes of tetrahedra are adapted; this one has other cells as well");
  if (!mesh.quad_to_vert.empty())
    throw Error(ErrorCode::InputUnsuitable,
                "only triangles may bound a mesh that is adapted; this one has quadrilaterals");
  if (mesh.tet_to_vert.empty()) throw Error(ErrorCode::InputUnsuitable, "the mesh has no tetrahedra");
  if (mesh.tet_to_vert.size() >= CellPlace::kMaxTets)
    throw Error(ErrorCode::InputUnsuitable, "the mesh has too many tetrahedra");
}

constexpr std::size_t kGrain = std::size_t{1} << 12;

class Builder {
 public:
  Builder(const Mesh& mesh, const TetSlice* slice, const TaskRunner& runner)
      : mesh_(mesh), slice_(slice), runner_(runner) {}

  WholeMesh run() {
    check_cells(mesh_);
    link();
    find_triangles();
    find_edges();
    classify();
    WholeMesh whole;
    whole.to_hint.resize(tets_.points.size(), kNone);
    whole.to_state.resize(tets_.points.size(), kHasChanged | kUnsettled);
    if (!slice_) whole.to_metric.resize(tets_.points.size());
    whole.points = std::move(tets_.points);
    whole.to_entity = std::move(to_entity_);
    whole.to_vert = std::move(tets_.to_vert), whole.to_neighbor = std::move(tets_.to_neighbor);
    whole.to_region = std::move(tets_.to_region);
    whole.triangles = std::move(triangles_), whole.edges = std::move(edges_);
    return whole;
  }

 private:
  void link() {
    tets_.points = GrowingArray<Vec3>(std::span<const Vec3>(mesh_.points));
    const tets::Fault fault = slice_ ? link_slice() : tets::link_tets(tets_, mesh_.tet_to_vert, tris(), runner_);
    if (fault.any()) {
      Diagnostic diagnostic{ErrorCode::InputUnsuitable, fault.message, {}, fault.point, {}};
      diagnostic.elements.assign(fault.triangles.begin(), fault.triangles.end());
      throw Error(std::move(diagnostic));
    }
    for (std::size_t tet = 0; tet < tets_.size(); ++tet)
      tets_.to_region[tet] = mesh_.tet_to_entity[slice_ ? slice_->to_number[tet] : tet];
  }

  tets::Fault link_slice() {
    std::vector<std::array<std::uint32_t, 4>> tets;
    tets.reserve(slice_->to_number.size()), tris_.reserve(slice_->triangles.size());
    for (const std::uint32_t tet : slice_->to_number) tets.push_back(mesh_.tet_to_vert[tet]);
    for (const std::uint32_t triangle : slice_->triangles) tris_.push_back(mesh_.tri_to_vert[triangle]);
    return tets::link_tets(tets_, tets, tris(), runner_);
  }

  // Those that are looked at.
  const std::vector<Triangle>& tris() const { return slice_ ? tris_ : mesh_.tri_to_vert; }
  std::uint32_t entity_of_tri(std::size_t t) const { return mesh_.tri_to_entity[slice_ ? slice_->triangles[t] : t]; }
  bool is_complete(FaceCode face) const {
    return !slice_ || std::ranges::any_of(tets::verts_of(tets_, face), [&](auto v) { return slice_->is_own[v] != 0; });
  }

  // Every triangle with its tets; every face of the hull, and between regions, must be a triangle.
  void find_triangles() {
    const tets::TriangleIndex index(tris(), tets_.points.size());
    triangles_.resize(tris().size());
    const auto unnamed =
        map_blocks(runner_, tets_.size(), kGrain, kNone, [&](std::size_t begin, std::size_t end, auto& first) {
          for (auto face = static_cast<FaceCode>(4 * begin); face < 4 * end; ++face)
            if (!find_triangle(face, index)) first = std::min(first, face);
        });
    for (const FaceCode face : unnamed) {
      if (face == kNone) continue;
      refuse(tets_.to_neighbor[face] == kNone
                 ? "a face of the mesh's boundary has no triangle that names its model face"
                 : "two regions meet in a face without a triangle that names its model face",
             tets_.points[tets::verts_of(tets_, face)[0]], face / 4);
    }
    std::erase_if(triangles_, [](const LinkedTriangle& t) { return t.tets[0] == kNone; });
  }

  // False: the face should be a triangle, and is none. No two faces have the same triangle.
  bool find_triangle(FaceCode face, const tets::TriangleIndex& index) {
    const FaceCode behind = tets_.to_neighbor[face];
    const std::uint32_t tet = face / 4;
    const bool between = behind == kNone || tets_.to_region[tet] != tets_.to_region[behind / 4];
    if ((!between && !tets_.is_fixed(face)) || (behind != kNone && behind < face)) return true;
    if (!is_complete(face)) return true;
    const auto* found = index.find(tets::sorted(tets::verts_of(tets_, face)));
    if (!found || entity_of_tri(found->triangle) == kNone) return false;
    triangles_[found->triangle] = {{tris()[found->triangle], entity_of_tri(found->triangle)},
                                   {tet, behind == kNone ? kNone : behind / 4}};
    return true;
  }

  // The triangles of the whole mesh, of repeated ones the first.
  template <class Visit>
  void for_each_on_surface(const Visit& visit) const {
    if (!slice_) {
      for (const LinkedTriangle& t : triangles_) visit(t.triangle.verts, t.triangle.face);
      return;
    }
    const tets::TriangleIndex index(mesh_.tri_to_vert, tets_.points.size());
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t)
      if (index.find(tets::sorted(mesh_.tri_to_vert[t]))->triangle == t)
        visit(mesh_.tri_to_vert[t], mesh_.tri_to_entity[t]);
  }

  // Pieces of model edges: those that the mesh has, and edges where two model faces meet without one.
  void find_edges() {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      edges_.push_back({{std::min(a, b), std::max(a, b)}, mesh_.edge_to_entity[i]});
      if (edges_.back().edge != kNone) next = std::max(next, edges_.back().edge + 1);
    }
    next = std::max<std::uint32_t>(next, static_cast<std::uint32_t>(mesh_.entities[1].size()));
    std::sort(edges_.begin(), edges_.end());
    struct Use {
      std::array<std::uint32_t, 2> verts;
      std::uint32_t face;
      auto operator<=>(const Use&) const = default;
    };
    std::vector<Use> uses;
    for_each_on_surface([&](const Triangle& verts, std::uint32_t face) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = verts[i], b = verts[(i + 1) % 3];
        uses.push_back({{std::min(a, b), std::max(a, b)}, face});
      }
    });
    std::sort(uses.begin(), uses.end());
    std::map<std::vector<std::uint32_t>, std::uint32_t> names;  // of edges by the faces that meet there
    std::vector<ModelEdgePiece> found;
    for (std::size_t i = 0; i < uses.size();) {
      std::size_t end = i;
      std::vector<std::uint32_t> faces;
      for (; end < uses.size() && uses[end].verts == uses[i].verts; ++end) faces.push_back(uses[end].face);
      const bool is_edge = faces.size() != 2 || faces[0] != faces[1];
      const auto at = std::lower_bound(edges_.begin(), edges_.end(), ModelEdgePiece{uses[i].verts, 0});
      const bool known = at != edges_.end() && at->verts == uses[i].verts && at->edge != kNone;
      if (next >= kTouching) throw Error(ErrorCode::InputUnsuitable, "the mesh has too many model edges");
      if (known) {
        found.push_back(*at);
      } else if (is_edge) {
        const auto [name, is_new] = names.emplace(faces, next);
        next += is_new;
        found.push_back({uses[i].verts, name->second});
      }
      i = end;
    }
    edges_ = std::move(found);
  }

  // What every point lies on: corners where model edges end or meet, then edges, faces and regions.
  void classify() {
    to_entity_.resize(tets_.points.size());
    for (std::size_t tet = 0; tet < tets_.size(); ++tet)
      for (std::size_t i = 0; i < 4; ++i)
        to_entity_[tets_.to_vert[tet * 4 + i]] = PackedEntity(ModelEntity(3, tets_.to_region[tet]));
    for (const LinkedTriangle& t : triangles_)
      for (const std::uint32_t v : t.triangle.verts) to_entity_[v] = PackedEntity(ModelEntity(2, t.triangle.face));
    std::vector<std::uint8_t> pieces(tets_.points.size(), 0);
    std::vector<std::uint8_t> corner(tets_.points.size(), 0);
    for (const ModelEdgePiece& piece : edges_) {
      for (const std::uint32_t v : piece.verts) {
        const PackedEntity edge(ModelEntity(1, piece.edge));
        if (pieces[v] > 0 && to_entity_[v] != edge) corner[v] = 1;
        pieces[v] = static_cast<std::uint8_t>(std::min(3, pieces[v] + 1));
        to_entity_[v] = edge;
      }
    }
    std::uint32_t next = static_cast<std::uint32_t>(mesh_.entities[0].size());
    for (const ModelEntity& entity : mesh_.point_to_entity)
      if (entity.valid() && entity.dim == 0) next = std::max(next, entity.index + 1);
    for (std::uint32_t v = 0; v < pieces.size(); ++v) {
      const ModelEntity given = v < mesh_.point_to_entity.size() ? mesh_.point_to_entity[v] : ModelEntity();
      if (given.valid() && given.dim == 0) {
        to_entity_[v] = PackedEntity(given);
      } else if (corner[v] != 0 || pieces[v] == 1 || pieces[v] > 2) {
        to_entity_[v] = PackedEntity(ModelEntity(0, next++));
      }
    }
    // Of others not all triangles are known.
    for (std::uint32_t v = 0; slice_ && v < pieces.size(); ++v)
      if (slice_->is_own[v] == 0) to_entity_[v] = PackedEntity();
  }

  const Mesh& mesh_;
  const TetSlice* slice_;  // null: all
  const TaskRunner& runner_;
  std::vector<Triangle> tris_;  // of the slice
  TetMesh tets_;
  std::vector<LinkedTriangle> triangles_;
  std::vector<ModelEdgePiece> edges_;
  GrowingArray<PackedEntity> to_entity_;
};

// Corners and edges that the source did not name are beyond its tables, where it has some.
void name_the_new(Mesh& mesh) {
  std::array<std::size_t, 2> counts{};
  for (const ModelEntity& entity : mesh.point_to_entity)
    if (entity.dim == 0) counts[0] = std::max(counts[0], std::size_t{entity.index} + 1);
  for (const std::uint32_t edge : mesh.edge_to_entity) counts[1] = std::max(counts[1], std::size_t{edge} + 1);
  for (std::size_t dim = 0; dim < 2; ++dim)
    if (!mesh.entities[dim].empty() && mesh.entities[dim].size() < counts[dim]) mesh.entities[dim].resize(counts[dim]);
}

}  // namespace

std::vector<std::array<std::uint32_t, 4>> tets_of(const WholeMesh& whole, const TaskRunner& runner) {
  std::vector<std::array<std::uint32_t, 4>> tets(whole.size());
  runner.for_blocks(tets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) std::copy_n(&whole.to_vert[tet * 4], 4, tets[tet].begin());
  });
  return tets;
}

WholeMesh make_whole_mesh(const Mesh& mesh, const TaskRunner& runner) { return Builder(mesh, nullptr, runner).run(); }

TetSlice slice_around(const Mesh& mesh, std::size_t first, std::size_t count) {
  TetSlice slice;
  slice.is_own.resize(mesh.points.size(), 0);
  for (std::size_t tet = first; tet < first + count; ++tet)
    for (const std::uint32_t v : mesh.tet_to_vert[tet]) slice.is_own[v] = 1;
  const auto is_near = [&](const auto& verts) {
    return std::ranges::any_of(verts, [&](std::uint32_t v) { return slice.is_own[v] != 0; });
  };
  std::vector<std::uint8_t> is_used(mesh.points.size(), 0);
  for (std::uint32_t tet = 0; tet < mesh.tet_to_vert.size(); ++tet) {
    if (tet == first) slice.begin = slice.to_number.size();
    if (is_near(mesh.tet_to_vert[tet])) slice.to_number.push_back(tet);
    for (const std::uint32_t v : mesh.tet_to_vert[tet]) is_used[v] = 1;
  }
  if (count == 0) slice.begin = slice.to_number.size();
  slice.end = slice.begin + count;
  const auto is_lost = [&](const Triangle& verts) {
    return std::ranges::none_of(verts, [&](std::uint32_t v) { return is_used[v] != 0; });
  };
  for (std::uint32_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    if (is_near(mesh.tri_to_vert[t]) || is_lost(mesh.tri_to_vert[t])) slice.triangles.push_back(t);
  return slice;
}

WholeMesh make_slice_mesh(const Mesh& mesh, const TetSlice& slice, const TaskRunner& runner) {
  return Builder(mesh, &slice, runner).run();
}

Mesh make_mesh_of(const WholeMesh& whole, const Mesh& source, const TaskRunner& runner) {
  Mesh mesh;
  mesh.points.resize(whole.points.size()), mesh.point_to_entity.resize(whole.points.size());
  runner.for_blocks(whole.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      mesh.points[v] = whole.points[v], mesh.point_to_entity[v] = whole.to_entity[v].unpack();
  });
  for (const ModelEdgePiece& piece : whole.edges) {
    mesh.edge_to_vert.push_back(piece.verts);
    mesh.edge_to_entity.push_back(piece.edge);
  }
  for (const LinkedTriangle& t : whole.triangles) {
    mesh.tri_to_vert.push_back(t.triangle.verts);
    mesh.tri_to_entity.push_back(t.triangle.face);
  }
  mesh.tet_to_vert = tets_of(whole, runner);
  mesh.tet_to_entity.assign(whole.to_region.begin(), whole.to_region.end());
  mesh.face_to_sides = source.face_to_sides;
  mesh.entities = source.entities;
  name_the_new(mesh);
  return mesh;
}

}  // namespace tetloom::adapt
