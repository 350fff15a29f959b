#include "mesher/surface/coincident_faces.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/spatial/distances.hpp"

namespace tetloom {
namespace {

using Piece = std::array<std::uint32_t, 2>;

/// The pieces of a face's rim in the direction of its loops, sorted; pieces run through up and down are left out.
std::vector<Piece> directed_rim(const ModelTopology& topology, std::size_t face, const RimNodes& rim) {
  std::vector<Piece> pieces;
  for (const ModelLoop& loop : topology.face_to_loops[face])
    for (const EdgeUse& use : loop) {
      if (topology.edges[use.edge.value].degenerate) continue;
      for (std::size_t i = 0; i + 1 < rim.mesh(use.edge).points.size(); ++i) {
        const std::uint32_t a = rim.node(use.edge, i), b = rim.node(use.edge, i + 1);
        pieces.push_back(use.forward ? Piece{a, b} : Piece{b, a});
      }
    }
  std::sort(pieces.begin(), pieces.end());
  std::vector<Piece> kept;
  for (const Piece& piece : pieces)
    if (!std::binary_search(pieces.begin(), pieces.end(), Piece{piece[1], piece[0]})) kept.push_back(piece);
  return kept;
}

std::vector<Piece> reversed(std::vector<Piece> pieces) {
  for (Piece& piece : pieces) std::swap(piece[0], piece[1]);
  std::sort(pieces.begin(), pieces.end());
  return pieces;
}

class CancellingFinder {
 public:
  CancellingFinder(const GeometricModel& model, const RimNodes& rim, const std::vector<FaceMesh>& faces)
      : model_(model), topology_(model.topology()), rim_(rim), faces_(faces) {}

  // Faces are first told apart by the smallest node of their rim and the number of its pieces.
  std::vector<CoincidentFaces> run() {
    std::map<std::pair<std::uint32_t, std::size_t>, std::vector<std::size_t>> groups;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      if (faces_[f].verdict == FaceVerdict::Ok) groups[key_of(f)].push_back(f);
    std::vector<CoincidentFaces> result;
    std::vector<bool> taken(faces_.size(), false);
    for (const auto& [key, group] : groups)
      for (std::size_t j = 1; j < group.size(); ++j)
        for (std::size_t i = 0; i < j && !taken[group[j]]; ++i) {
          if (taken[group[i]] || !cancel(group[i], group[j])) continue;
          taken[group[i]] = taken[group[j]] = true;
          result.push_back({ModelFaceId(group[i]), ModelFaceId(group[j])});
        }
    return result;
  }

 private:
  std::pair<std::uint32_t, std::size_t> key_of(std::size_t face) const {
    std::uint32_t smallest = kNone;
    std::size_t count = 0;
    for (const ModelLoop& loop : topology_.face_to_loops[face])
      for (const EdgeUse& use : loop) {
        if (topology_.edges[use.edge.value].degenerate) continue;
        for (std::size_t i = 0; i < rim_.mesh(use.edge).points.size(); ++i)
          smallest = std::min(smallest, rim_.node(use.edge, i));
        count += rim_.mesh(use.edge).points.size() - 1;
      }
    return {smallest, count};
  }

  bool cancel(std::size_t a, std::size_t b) const {
    const std::vector<Piece> first = directed_rim(topology_, a, rim_), second = directed_rim(topology_, b, rim_);
    if (first.empty()) return false;
    FaceSides sides = topology_.face_to_sides[b];
    if (first != second) {
      if (reversed(second) != first) return false;
      std::swap(sides.front, sides.back);
    }
    const FaceSides& own = topology_.face_to_sides[a];
    const bool divides = own.front != own.back;
    return divides && own.front == sides.back && own.back == sides.front && lies_on(b, a) && lies_on(a, b);
  }

  // On its surface and near its mesh: both halves of a sphere have the same surface, and the same rim.
  bool lies_on(std::size_t upper, std::size_t lower) const {
    constexpr double kShare = 1e-3, kNearMesh = 0.5;
    constexpr std::size_t kSamples = 32;
    const FaceMesh& mesh = faces_[upper];
    const double tolerance =
        std::max(model_.attributes(ModelFaceId(upper)).tolerance, model_.attributes(ModelFaceId(lower)).tolerance);
    const auto geometry = model_.face_geometry(ModelFaceId(lower));
    const auto own = model_.face_geometry(ModelFaceId(upper));
    const std::size_t step = std::max<std::size_t>(1, mesh.tri_to_vert.size() / kSamples);
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); t += step) {
      const Vec3 a = point(mesh, t, 0), b = point(mesh, t, 1), c = point(mesh, t, 2);
      const double length = std::max({distance(a, b), distance(b, c), distance(c, a)});
      const Vec3 middle = own->closest_point((a + b + c) / 3, {}).point;
      if (geometry->closest_point(middle, {}).distance > std::max(tolerance, kShare * length)) return false;
      if (distance_to_mesh(faces_[lower], middle) > kNearMesh * length) return false;
    }
    return true;
  }

  double distance_to_mesh(const FaceMesh& mesh, const Vec3& x) const {
    double nearest = HUGE_VAL;
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
      nearest = std::min(nearest, distance_to_triangle(x, point(mesh, t, 0), point(mesh, t, 1), point(mesh, t, 2)));
    return nearest;
  }

  const Vec3& point(const FaceMesh& mesh, std::size_t triangle, std::size_t corner) const {
    const std::uint32_t v = mesh.tri_to_vert[triangle][corner];
    return v & FaceMesh::kInner ? mesh.points[v & ~FaceMesh::kInner] : rim_.point(v);
  }

  const GeometricModel& model_;
  const ModelTopology& topology_;
  const RimNodes& rim_;
  const std::vector<FaceMesh>& faces_;
};

}  // namespace

std::vector<CoincidentFaces> find_cancelling_faces(const GeometricModel& model, const RimNodes& rim,
                                                   const std::vector<FaceMesh>& faces) {
  return CancellingFinder(model, rim, faces).run();
}

}  // namespace tetloom
