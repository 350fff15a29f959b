#include "mesher/tets/delaunay.hpp"

#include <algorithm>
#include <array>
#include <new>

#include "core/base/local_numbers.hpp"
#include "core/predicates/predicates.hpp"
#include "mesher/tets/insertion_order.hpp"
#include "mesher/tets/locate.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

constexpr std::uint32_t kMostTets = std::uint32_t{1} << 29;
constexpr double kOuterDistance = 4;  // from the centre to the outer faces, in widths of the points' box
constexpr std::size_t kInsertionsBetweenChecks = 4096;
constexpr std::uint32_t kSmallCavity = 64;  // vertices; their edges are matched in a table

// The sign of insphere(a, b, c, d, e) after raising the vertices in the lifted space, the higher the id the more: never
// 0. Raising a vertex of the tet raises the sphere at `e` by e's barycentric coordinate for that vertex.
int raised_insphere(const GrowingArray<Vec3>& points, std::span<const std::uint64_t> keys, const std::uint32_t* tet,
                    std::uint32_t e) {
  std::array<std::uint32_t, 5> ids{tet[0], tet[1], tet[2], tet[3], e};
  // Outer points are the highest.
  const auto rank = [&](std::uint32_t id) { return id < keys.size() ? keys[id] : ~std::uint64_t{0}; };
  std::sort(ids.begin(), ids.end(), [&](std::uint32_t s, std::uint32_t t) {
    const std::uint64_t a = rank(s), b = rank(t);
    return a != b ? a > b : s > t;
  });
  for (const std::uint32_t id : ids) {
    if (id == e) return -1;
    std::array<const Vec3*, 4> corner;
    for (int i = 0; i < 4; ++i) corner[i] = &points[tet[i] == id ? e : tet[i]];
    if (const int side = orient3d(*corner[0], *corner[1], *corner[2], *corner[3]); side != 0) return side;
  }
  return -1;
}

class Insertion {
 public:
  Insertion(TetMesh& mesh, std::span<const std::uint64_t> keys, std::uint32_t vertex_count) : mesh_(mesh), keys_(keys) {
    locals_.set_item_count(vertex_count);
    in_cavity_.resize(mesh.size(), 0);
    verts_ = mesh_.to_vert.data(), neighbors_ = mesh_.to_neighbor.data();
  }

  void start(std::uint32_t first_outer) {
    add_tets(1);
    for (std::uint32_t i = 0; i < 4; ++i) verts_[i] = first_outer + i, neighbors_[i] = {};
  }

  /// The vertex that lies where `vert` does, or kNone after inserting it.
  std::uint32_t insert(std::uint32_t vert) {
    const Vec3 x = mesh_.points[vert];
    const std::uint32_t tet = walk_.locate(mesh_, x);
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t other = verts_[std::size_t{tet} * 4 + i];
      if (mesh_.points[other] == x) return other;
    }
    find_cavity(tet, vert, x);
    fill_cavity(vert);
    return kNone;
  }

 private:
  // A face of the cavity with the tet outside of it; counter-clockwise seen from there.
  struct Rim {
    FaceCode outside;
    std::array<std::uint32_t, 3> vert;
  };

  void add_tets(std::uint32_t count) {
    const std::size_t size = mesh_.size() + count;
    if (size > kMostTets) throw std::bad_alloc();
    mesh_.to_vert.resize_for_overwrite(size * 4);
    mesh_.to_neighbor.resize_for_overwrite(size * 4);
    mesh_.to_fixed.resize(size, 0);
    in_cavity_.resize(size, 0);
    verts_ = mesh_.to_vert.data(), neighbors_ = mesh_.to_neighbor.data();
  }

  bool conflicts(std::uint32_t tet, std::uint32_t vert, const Vec3& x) const {
    const std::uint32_t* v = verts_ + std::size_t{tet} * 4;
    const Vec3* points = mesh_.points.data();
    int side = insphere(points[v[0]], points[v[1]], points[v[2]], points[v[3]], x);
    if (side == 0) side = raised_insphere(mesh_.points, keys_, v, vert);
    return side > 0;
  }

  // The tets whose circumsphere holds x, and the faces around them.
  void find_cavity(std::uint32_t tet, std::uint32_t vert, const Vec3& x) {
    cavity_.assign(1, tet);
    rim_.clear();
    in_cavity_[tet] = 1;
    for (std::size_t k = 0; k < cavity_.size(); ++k) {
      const std::size_t first = std::size_t{cavity_[k]} * 4;
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode outside = neighbors_[first + i];
        if (outside.valid()) {
          const std::uint32_t next = outside.tet();
          if (in_cavity_[next] == 1) continue;
          if (in_cavity_[next] == 0) {
            if (conflicts(next, vert, x)) {
              in_cavity_[next] = 1;
              cavity_.push_back(next);
              continue;
            }
            in_cavity_[next] = 2;
            tested_.push_back(next);
          }
        }
        const auto& f = kFaceVerts[i];
        rim_.push_back({outside, {verts_[first + f[0]], verts_[first + f[1]], verts_[first + f[2]]}});
      }
    }
    for (const std::uint32_t t : tested_) in_cavity_[t] = 0;
    for (const std::uint32_t t : cavity_) in_cavity_[t] = 0;
    tested_.clear();
  }

  // Joins `vert` to every face of the cavity.
  void fill_cavity(std::uint32_t vert) {
    const auto removed = static_cast<std::uint32_t>(cavity_.size());
    if (rim_.size() > removed) {
      while (!free_.empty() && cavity_.size() < rim_.size()) {
        cavity_.push_back(free_.back());
        free_.pop_back();
      }
      const auto before = static_cast<std::uint32_t>(mesh_.size());
      const auto more = static_cast<std::uint32_t>(rim_.size() - cavity_.size());
      if (more > 0) add_tets(more);
      for (std::uint32_t i = 0; i < more; ++i) cavity_.push_back(before + i);
    }
    for (std::size_t k = 0; k < rim_.size(); ++k) {
      const Rim& rim = rim_[k];
      std::uint32_t* v = verts_ + std::size_t{cavity_[k]} * 4;
      v[0] = vert, v[1] = rim.vert[0], v[2] = rim.vert[1], v[3] = rim.vert[2];
      const FaceCode face(cavity_[k], 0);
      neighbors_[face.index()] = rim.outside;
      if (rim.outside.valid()) neighbors_[rim.outside.index()] = face;
    }
    number_rim();
    if (locals_.size() <= kSmallCavity) {
      match_in_table();
    } else {
      match_by_sorting();
    }
    walk_.restart(cavity_[0]);
    for (std::size_t k = rim_.size(); k < removed; ++k) {
      verts_[std::size_t{cavity_[k]} * 4] = kNone;
      free_.push_back(cavity_[k]);
    }
  }

  void number_rim() {
    locals_.clear();
    for (const Rim& rim : rim_)
      for (const std::uint32_t v : rim.vert) locals_.add(v);
  }

  // Two new tets meet in a face with `vert` for every edge of the rim, which they run through in opposite directions.
  void match_in_table() {
    for (std::size_t k = 0; k < rim_.size(); ++k) {
      std::array<std::uint32_t, 3> local;
      for (std::size_t i = 0; i < 3; ++i) local[i] = locals_[rim_[k].vert[i]];
      table_[local[1] * kSmallCavity + local[2]] = {cavity_[k], 1};
      table_[local[2] * kSmallCavity + local[0]] = {cavity_[k], 2};
      table_[local[0] * kSmallCavity + local[1]] = {cavity_[k], 3};
      rim_[k].vert = local;
    }
    for (std::size_t k = 0; k < rim_.size(); ++k) {
      const auto& local = rim_[k].vert;
      FaceCode* const behind = neighbors_ + std::size_t{cavity_[k]} * 4;
      behind[1] = table_[local[2] * kSmallCavity + local[1]];
      behind[2] = table_[local[0] * kSmallCavity + local[2]];
      behind[3] = table_[local[1] * kSmallCavity + local[0]];
    }
  }

  void match_by_sorting() {
    struct Edge {
      std::uint32_t low, high;
      FaceCode face;
    };
    std::vector<Edge> edges;
    edges.reserve(rim_.size() * 3);
    for (std::size_t k = 0; k < rim_.size(); ++k) {
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t a = rim_[k].vert[(i + 1) % 3], b = rim_[k].vert[(i + 2) % 3];
        edges.push_back({std::min(a, b), std::max(a, b), {cavity_[k], 1 + i}});
      }
    }
    std::sort(edges.begin(), edges.end(),
              [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
    for (std::size_t k = 0; k + 1 < edges.size(); k += 2) {
      neighbors_[edges[k].face.index()] = edges[k + 1].face;
      neighbors_[edges[k + 1].face.index()] = edges[k].face;
    }
  }

  TetMesh& mesh_;
  std::span<const std::uint64_t> keys_;
  std::uint32_t* verts_ = nullptr;
  FaceCode* neighbors_ = nullptr;
  GrowingArray<std::uint8_t> in_cavity_;  // 1: in it, 2: tested and not in it
  LocalNumbers locals_;                   // of the rim's vertices
  std::vector<std::uint32_t> cavity_, tested_;
  std::vector<Rim> rim_;
  std::vector<FaceCode> table_ = std::vector<FaceCode>(std::size_t{kSmallCavity} * kSmallCavity);
  std::vector<std::uint32_t> free_;  // dead tets
  Walk walk_;
};

// A regular tetrahedron, turned off the axes, around the points.
void add_outer_points(TetMesh& mesh, std::span<const std::uint32_t> verts, Box3 box) {
  if (box.empty())
    for (const std::uint32_t v : verts) box.add(mesh.points[v]);
  const Vec3 center = box.empty() ? Vec3{} : box.center(), extent = box.empty() ? Vec3{} : box.hi - box.lo;
  const double width = std::max({extent.x, extent.y, extent.z});
  const double r = 3 * kOuterDistance * (width > 0 ? width : 1);
  mesh.points.push_back(center + r * Vec3{-0.5084130, -0.8592707, -0.0563031});
  mesh.points.push_back(center + r * Vec3{-0.3645079, 0.6474520, -0.6692831});
  mesh.points.push_back(center + r * Vec3{-0.0931564, 0.3828204, 0.9191139});
  mesh.points.push_back(center + r * Vec3{0.9660773, -0.1710016, -0.1935278});
}

// What both ways have in common once the outer points stand behind all others.
DelaunayResult insert_all(TetMesh& mesh, std::uint32_t first_outer, std::span<const std::uint32_t> order,
                          const TaskRunner& runner, const DelaunayFrame& frame) {
  DelaunayResult result;
  result.first_outer = first_outer;
  Insertion insertion(mesh, frame.keys, static_cast<std::uint32_t>(mesh.points.size()));
  if (mesh.size() == 0) insertion.start(first_outer);
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i % kInsertionsBetweenChecks == 0) runner.check_cancelled();
    if (const std::uint32_t kept = insertion.insert(order[i]); kept != kNone)
      result.duplicates.push_back({order[i], kept});
  }
  mesh.to_region.resize(mesh.size(), kNone);
  compact(mesh);
  std::sort(result.duplicates.begin(), result.duplicates.end(),
            [](const Duplicate& a, const Duplicate& b) { return a.vert < b.vert; });
  return result;
}

}  // namespace

DelaunayResult make_delaunay(TetMesh& mesh, std::span<const std::uint32_t> verts, const TaskRunner& runner,
                             const DelaunayFrame& frame) {
  const auto first_outer = static_cast<std::uint32_t>(mesh.points.size());
  const std::vector<std::uint32_t> order = make_insertion_order(mesh.points.span(), verts);
  add_outer_points(mesh, verts, frame.box);
  mesh.to_vert.clear(), mesh.to_neighbor.clear(), mesh.to_region.clear(), mesh.to_fixed.clear();
  return insert_all(mesh, first_outer, order, runner, frame);
}

DelaunayResult extend_delaunay(TetMesh& mesh, std::uint32_t outer_before, std::span<const std::uint32_t> verts,
                               const TaskRunner& runner, const DelaunayFrame& frame) {
  TETLOOM_ASSERT(!frame.box.empty());
  const auto first_outer = static_cast<std::uint32_t>(mesh.points.size());
  const std::vector<std::uint32_t> order = make_insertion_order(mesh.points.span(), verts);
  add_outer_points(mesh, verts, frame.box);
  for (std::uint32_t& v : mesh.to_vert)
    if (v >= outer_before) v += first_outer - outer_before;
  std::fill(mesh.to_fixed.begin(), mesh.to_fixed.end(), std::uint8_t{0});
  return insert_all(mesh, first_outer, order, runner, frame);
}

}  // namespace tetloom::tets
