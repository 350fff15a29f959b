#include "mesher/tets/delaunay_flips.hpp"

#include <algorithm>
#include <array>

#include "core/tets/circumsphere.hpp"
#include "core/tets/ring_in_space.hpp"
#include "core/tets/ring_triangulation.hpp"
#include "core/tets/tet_quality.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

constexpr double kInside = 1e-2;  // of the squared distance from another vertex: what is nearly on a sphere stays
constexpr int kFlipsPerTet = 3;
constexpr std::uint32_t kFlipBlock = 4096;

// Two tets with a common face, and the line between their other vertices.
struct FacePair {
  std::uint32_t tet, face, behind;
  std::array<std::uint32_t, 3> verts;  // of the face, counter-clockwise seen from `beyond`
  std::uint32_t apex, beyond;
};

class Flipper {
 public:
  Flipper(WorkingMesh& mesh, std::uint32_t first, double floor) : mesh_(mesh), first_(first), floor_(floor) {}

  // Exchanges `tet` and one or two others, at the first face where that is possible. Each face is asked about by the
  // tet of lower id alone.
  bool flip_at(std::uint32_t tet) {
    const TetMesh& m = mesh_.mesh();
    const auto v = mesh_.verts(tet);
    const Circumsphere sphere(mesh_.point(v[0]), mesh_.point(v[1]), mesh_.point(v[2]), mesh_.point(v[3]));
    for (std::uint32_t face = 0; face < 4; ++face) {
      const FaceCode code(tet, face), behind = m.behind(code);
      if (!behind.valid() || behind < code || behind.tet() < first_) continue;
      if (!sphere.holds(mesh_.point(m.apex(behind)), kInside) || m.is_fixed(code)) continue;
      if (flip(pair_at(tet, face))) return true;
    }
    return false;
  }

 private:
  FacePair pair_at(std::uint32_t tet, std::uint32_t face) const {
    const FaceCode behind = mesh_.mesh().behind({tet, face});
    const auto v = mesh_.verts(tet);
    const auto& k = kFaceVerts[face];
    return {tet, face, behind.tet(), {v[k[0]], v[k[1]], v[k[2]]}, v[face], mesh_.mesh().apex(behind)};
  }

  double least_of(std::uint32_t a, std::uint32_t b) const {
    return std::min(floor_, double{std::min(mesh_.quality(a), mesh_.quality(b))});
  }

  bool flip(const FacePair& pair) {
    const Vec3& o = mesh_.point(pair.beyond);
    const Vec3 d = mesh_.point(pair.apex) - o;
    std::array<Vec3, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = mesh_.point(pair.verts[i]) - o;
    int reflex = 0;  // edges of the face that the line between the apices passes outside of
    std::size_t which = 0;
    for (std::size_t i = 0; i < 3; ++i)
      if (dot(cross(at[(i + 1) % 3], at[(i + 2) % 3]), d) >= 0) ++reflex, which = i;
    if (reflex == 0) return exchange_face(pair, at, d);
    return reflex == 1 && exchange_edge(pair, which);
  }

  // Two tets for three around the line between their apices.
  bool exchange_face(const FacePair& pair, const std::array<Vec3, 3>& at, const Vec3& d) {
    const double bearable = least_of(pair.tet, pair.behind);
    std::array<double, 3> quality;
    for (std::size_t i = 0; i < 3; ++i) {
      quality[i] = cubed_quality(at[(i + 1) % 3], at[(i + 2) % 3], d, {});
      if (!(quality[i] > kSurelyPositive) || quality[i] < bearable) return false;
    }
    mesh_.replace_face(pair.tet, pair.face, quality);
    return true;
  }

  // Three tets around the edge opposite to verts[which] for two.
  bool exchange_edge(const FacePair& pair, std::size_t which) {
    const TetMesh& m = mesh_.mesh();
    const std::uint32_t in_tet = mesh_.corner_of(pair.tet, pair.verts[which]);
    const std::uint32_t in_behind = mesh_.corner_of(pair.behind, pair.verts[which]);
    const FaceCode third = m.behind({pair.tet, in_tet}), same = m.behind({pair.behind, in_behind});
    if (!third.valid() || !same.valid() || third.tet() != same.tet() || third.tet() < first_) return false;
    if (m.is_fixed(third) || m.is_fixed(same)) return false;
    EdgeRing ring;
    ring.a = pair.verts[(which + 1) % 3], ring.b = pair.verts[(which + 2) % 3], ring.count = 3;
    ring.verts = {pair.verts[which], pair.beyond, pair.apex};
    ring.tets = {pair.behind, third.tet(), pair.tet};
    const double bearable = std::min(least_of(pair.tet, pair.behind), double{mesh_.quality(third.tet())});
    const double worse = RingInSpace(mesh_, ring).worse_over(0, 1, 2);
    if (!(worse > kSurelyPositive) || worse < bearable) return false;
    const RingTriangle triangle{0, 1, 2};
    mesh_.replace_ring(ring, std::span(&triangle, 1));
    return true;
  }

  WorkingMesh& mesh_;
  std::uint32_t first_;
  double floor_;
};

}  // namespace

std::size_t flip_to_delaunay(WorkingMesh& mesh, std::uint32_t first, double floor, const TaskRunner& runner) {
  Flipper flipper(mesh, first, floor);
  const auto count = static_cast<std::uint32_t>(mesh.qualities().size());
  std::size_t flips = 0;
  for (std::uint32_t tet = first; tet < count; ++tet) {
    if ((tet - first) % kFlipBlock == 0) runner.check_cancelled();
    for (int i = 0; i < kFlipsPerTet && !mesh.mesh().is_dead(tet) && flipper.flip_at(tet); ++i) ++flips;
  }
  return flips;
}

}  // namespace tetloom::tets
