#include "adapt/parts/whole_mesh.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "core/tets/find_triangles.hpp"
#include "core/tets/link_tets.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"
#include "threading/runtime/parallel_sort.hpp"

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
  if (mesh.tet_to_vert.size() >= CellPlace::kMaxTets)
    throw Error(ErrorCode::InputUnsuitable, "the mesh has too many tetrahedra");
}

using EdgeVerts = std::array<std::uint32_t, 2>;
using EdgeNumbers = std::array<Number, 2>;
using Faces = std::vector<std::uint32_t>;  // of the model, ascending

// An edge of a triangle.
struct EdgeOfTriangle {
  EdgeVerts verts{};
  std::uint32_t face = kNone;
  auto operator<=>(const EdgeOfTriangle&) const = default;
};

// What all ranks have, each once, ascending.
std::vector<Number> gather_lists(const std::vector<Number>& own, const SharedWork& work) {
  std::vector<Number> all = tetloom::gather_lists<Number>(work.ranks(), own);
  sort_unique(all);
  return all;
}

class Builder {
 public:
  Builder(const Mesh& mesh, const MeshSlice* slice, const SharedWork& work)
      : mesh_(mesh), slice_(slice), work_(work), runner_(work.runner()) {}

  WholeMesh run() {
    check_cells(mesh_);
    link();
    find_triangles();
    find_edges();
    classify();
    WholeMesh whole;
    whole.to_hint.resize(tets_.points.size(), kNoTet);
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
    const tets::Fault fault = tets::link_tets(tets_, mesh_.tet_to_vert, mesh_.tri_to_vert, runner_);
    if (fault.any()) {
      Diagnostic diagnostic{ErrorCode::InputUnsuitable, fault.message, {}, fault.point, {}};
      // Triangles of a slice have no numbers that mean anything to others.
      if (!slice_) diagnostic.elements.assign(fault.triangles.begin(), fault.triangles.end());
      throw Error(std::move(diagnostic));
    }
    for (std::size_t tet = 0; tet < tets_.size(); ++tet) tets_.to_region[tet] = mesh_.tet_to_entity[tet];
  }

  Number number_of(std::uint32_t vert) const { return slice_ ? slice_->to_vert_number[vert] : vert; }
  Number number_of_tet(std::uint32_t tet) const { return slice_ ? slice_->to_tet_number[tet] : tet; }
  // Whether all tets with all of these vertices are here.
  template <class Verts>
  bool is_complete(const Verts& verts) const {
    return !slice_ || std::ranges::any_of(verts, [&](std::uint32_t v) { return slice_->is_own[v] != 0; });
  }

  // Every triangle with its tets; every face of the hull, and between regions, must be a triangle.
  void find_triangles() {
    const tets::TriangleIndex index(mesh_.tri_to_vert, tets_.points.size());
    triangles_.resize(mesh_.tri_to_vert.size());
    const auto unnamed = map_blocks(runner_, tets_.size(), kElementGrain, FaceCode(),
                                    [&](std::size_t begin, std::size_t end, auto& first) {
                                      for (const FaceCode face : tets::FaceRange(begin, end))
                                        if (!find_triangle(face, index)) first = std::min(first, face);
                                    });
    for (const FaceCode face : unnamed) {
      if (!face.valid()) continue;
      refuse(!tets_.behind(face).valid() ? "a face of the mesh's boundary has no triangle that names its model face"
                                         : "two regions meet in a face without a triangle that names its model face",
             tets_.points[tets::verts_of(tets_, face)[0]], number_of_tet(face.tet()));
    }
    std::erase_if(triangles_, [](const LinkedTriangle& t) { return t.tets[0] == kNone; });
  }

  // False: the face should be a triangle, and is none. No two faces have the same triangle.
  bool find_triangle(FaceCode face, const tets::TriangleIndex& index) {
    const FaceCode behind = tets_.behind(face);
    const std::uint32_t tet = face.tet();
    const bool between = !behind.valid() || tets_.to_region[tet] != tets_.to_region[behind.tet()];
    if ((!between && !tets_.is_fixed(face)) || (behind.valid() && behind < face)) return true;
    if (!is_complete(tets::verts_of(tets_, face))) return true;
    const auto* found = index.find(tets::sorted(tets::verts_of(tets_, face)));
    if (!found || mesh_.tri_to_entity[found->triangle] == kNone) return false;
    triangles_[found->triangle] = {{mesh_.tri_to_vert[found->triangle], mesh_.tri_to_entity[found->triangle]},
                                   {tet, !behind.valid() ? kNone : behind.tet()}};
    return true;
  }

  // Pieces of model edges: those that the mesh has, and edges where two model faces meet without one.
  void find_edges() {
    std::vector<ModelEdgePiece> given = given_pieces();
    std::uint32_t next = static_cast<std::uint32_t>(mesh_.entities[1].size());
    for (const std::uint32_t edge : mesh_.edge_to_entity)
      if (edge != kNone) next = std::max(next, edge + 1);
    std::vector<EdgeOfTriangle> uses = edges_of_triangles();
    std::vector<std::pair<std::size_t, Faces>> unnamed;  // pieces without a name
    for (std::size_t i = 0, end = 0; i < uses.size(); i = end) {
      Faces faces;
      for (end = i; end < uses.size() && uses[end].verts == uses[i].verts; ++end) faces.push_back(uses[end].face);
      if (!is_complete(uses[i].verts)) continue;
      const auto at = std::lower_bound(given.begin(), given.end(), ModelEdgePiece{uses[i].verts, 0});
      const bool known = at != given.end() && at->verts == uses[i].verts && at->edge != kNone;
      if (known) {
        edges_.push_back(*at);
      } else if (faces.size() != 2 || faces[0] != faces[1]) {
        unnamed.emplace_back(edges_.size(), std::move(faces));
        edges_.push_back({uses[i].verts, kNone});
      }
    }
    name_edges(unnamed, next_of_all(next));
  }

  std::vector<ModelEdgePiece> given_pieces() const {
    std::vector<ModelEdgePiece> pieces;
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      const auto [a, b] = mesh_.edge_to_vert[i];
      pieces.push_back({{std::min(a, b), std::max(a, b)}, mesh_.edge_to_entity[i]});
    }
    std::sort(pieces.begin(), pieces.end());
    return pieces;
  }

  std::vector<EdgeOfTriangle> edges_of_triangles() const {
    std::vector<EdgeOfTriangle> uses;
    uses.reserve(triangles_.size() * 3);
    for (const LinkedTriangle& t : triangles_) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = t.triangle.verts[i], b = t.triangle.verts[(i + 1) % 3];
        uses.push_back({{std::min(a, b), std::max(a, b)}, t.triangle.face});
      }
    }
    std::sort(uses.begin(), uses.end());
    return uses;
  }

  // After the faces that meet there, from `next` on: in the order of the lowest edge where they do.
  void name_edges(const std::vector<std::pair<std::size_t, Faces>>& unnamed, std::uint32_t next) {
    std::map<Faces, EdgeNumbers> lowest;
    for (const auto& [piece, faces] : unnamed) {
      const auto& [a, b] = edges_[piece].verts;
      lowest.emplace(faces, EdgeNumbers{number_of(a), number_of(b)});
    }
    if (slice_) gather_lowest(lowest);
    std::vector<std::pair<EdgeNumbers, const Faces*>> order;
    for (const auto& [faces, verts] : lowest) order.emplace_back(verts, &faces);
    std::sort(order.begin(), order.end());
    if (next + order.size() >= kTouching) throw Error(ErrorCode::InputUnsuitable, "the mesh has too many model edges");
    std::map<Faces, std::uint32_t> names;
    for (const auto& [verts, faces] : order) names[*faces] = next++;
    for (const auto& [piece, faces] : unnamed) edges_[piece].edge = names[faces];
  }

  // Of all ranks.
  void gather_lowest(std::map<Faces, EdgeNumbers>& lowest) const {
    const std::vector<Bytes> given = work_.all_gather([&](MessageWriter& writer) {
      for (const auto& [faces, verts] : lowest)
        writer.put(verts), writer.put_array(std::span<const std::uint32_t>(faces));
    });
    for (const Bytes& bytes : given) {
      for (MessageReader reader(bytes); !reader.at_end();) {
        const auto verts = reader.get<EdgeNumbers>();
        const auto at = lowest.emplace(reader.get_array<std::uint32_t>(), verts).first;
        at->second = std::min(at->second, verts);
      }
    }
  }

  // The highest of what the ranks give.
  std::uint32_t next_of_all(std::uint32_t next) const {
    std::array<double, 1> most{static_cast<double>(next)};
    if (slice_) work_.max(most);
    return static_cast<std::uint32_t>(most[0]);
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
    std::vector<std::uint32_t> unnamed;
    for (std::uint32_t v = 0; v < pieces.size(); ++v) {
      const ModelEntity given = v < mesh_.point_to_entity.size() ? mesh_.point_to_entity[v] : ModelEntity();
      if (slice_ && slice_->is_own[v] == 0) {
        to_entity_[v] = PackedEntity();  // not all of its triangles are known
      } else if (given.valid() && given.dim == 0) {
        to_entity_[v] = PackedEntity(given);
      } else if (corner[v] != 0 || pieces[v] == 1 || pieces[v] > 2) {
        unnamed.push_back(v);
      }
    }
    name_corners(unnamed, next_of_all(next));
  }

  // From `next` on, in the order of vertices.
  void name_corners(const std::vector<std::uint32_t>& unnamed, std::uint32_t next) {
    std::vector<Number> numbers;
    for (const std::uint32_t v : unnamed) numbers.push_back(number_of(v));
    if (slice_) numbers = gather_lists(numbers, work_);
    for (const std::uint32_t v : unnamed) {
      const auto at = std::ranges::lower_bound(numbers, number_of(v)) - numbers.begin();
      to_entity_[v] = PackedEntity(ModelEntity(0, next + static_cast<std::uint32_t>(at)));
    }
  }

  const Mesh& mesh_;
  const MeshSlice* slice_;  // null: all
  const SharedWork& work_;
  const TaskRunner& runner_;
  TetMesh tets_;
  std::vector<LinkedTriangle> triangles_;
  std::vector<ModelEdgePiece> edges_;
  GrowingArray<PackedEntity> to_entity_;
};

// Without those that a part before has as well.
std::vector<SurfaceTriangle> triangles_once(std::span<const LinkedTriangle> triangles, const TaskRunner& runner) {
  struct Place {
    Triangle verts;  // ascending
    std::uint32_t triangle;
    auto operator<=>(const Place&) const = default;
  };
  std::vector<Place> places(triangles.size());
  for (std::uint32_t t = 0; t < places.size(); ++t) places[t] = {tets::sorted(triangles[t].triangle.verts).verts, t};
  parallel_sort(places, runner);
  std::vector<std::uint8_t> is_repeated(triangles.size(), 0);
  for (std::size_t i = 1; i < places.size(); ++i)
    is_repeated[places[i].triangle] = places[i].verts == places[i - 1].verts;
  std::vector<SurfaceTriangle> once;
  for (std::size_t t = 0; t < triangles.size(); ++t)
    if (is_repeated[t] == 0) once.push_back(triangles[t].triangle);
  return once;
}

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
  runner.for_blocks(tets.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) std::copy_n(&whole.to_vert[tet * 4], 4, tets[tet].begin());
  });
  return tets;
}

WholeMesh make_whole_mesh(const Mesh& mesh, const TaskRunner& runner) {
  return Builder(mesh, nullptr, SharedWork(runner)).run();
}

WholeMesh make_slice_mesh(const MeshSlice& slice, const SharedWork& work) {
  return Builder(slice.mesh, &slice, work).run();
}

Mesh make_mesh_of(const WholeMesh& whole, const Mesh& source, const TaskRunner& runner) {
  Mesh mesh;
  mesh.points.resize(whole.points.size()), mesh.point_to_entity.resize(whole.points.size());
  runner.for_blocks(whole.points.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v)
      mesh.points[v] = whole.points[v], mesh.point_to_entity[v] = whole.to_entity[v].unpack();
  });
  for (const ModelEdgePiece& piece : whole.edges) {
    mesh.edge_to_vert.push_back(piece.verts);
    mesh.edge_to_entity.push_back(piece.edge);
  }
  for (const SurfaceTriangle& triangle : triangles_once(whole.triangles, runner)) {
    mesh.tri_to_vert.push_back(triangle.verts);
    mesh.tri_to_entity.push_back(triangle.face);
  }
  mesh.tet_to_vert = tets_of(whole, runner);
  mesh.tet_to_entity.assign(whole.to_region.begin(), whole.to_region.end());
  mesh.face_to_sides = source.face_to_sides;
  mesh.entities = source.entities;
  name_the_new(mesh);
  return mesh;
}

}  // namespace tetloom::adapt
