#include "mesher/tets/recovery_cavity.hpp"

#include <algorithm>

#include "core/base/lists.hpp"

namespace tetloom::tets {

namespace {

constexpr std::size_t kGrowth = 3;  // tets at a time

std::vector<std::uint32_t> points_of(const LocalMesh& mesh, const TetList& tets) {
  std::vector<std::uint32_t> points;
  for (const std::uint32_t t : tets) {
    for (const std::uint32_t v : mesh.tet(t)) points.push_back(v);
  }
  sort_unique(points);
  return points;
}

void add_faces(const LocalMesh& mesh, RecoveryCavity& cavity) {
  TetList inside = cavity.tets;
  std::sort(inside.begin(), inside.end());
  for (const std::uint32_t t : inside) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const FaceCode code(t, i), back = mesh.mesh().behind(code);
      if (back.valid() && !mesh.mesh().is_fixed(code) && std::binary_search(inside.begin(), inside.end(), back.tet()))
        continue;
      const TriangleVerts f = mesh.face(code);
      cavity.shape.faces.push_back({cavity.local(f[0]), cavity.local(f[1]), cavity.local(f[2])});
      cavity.face_to_code.push_back(code);
    }
  }
}

void add_kept_edges(const LocalMesh& mesh, const EdgeSet& kept, RecoveryCavity& cavity) {
  for (const std::uint32_t t : cavity.tets) {
    const Tet v = mesh.tet(t);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        if (kept.contains(v[i], v[j])) demand(cavity, v[i], v[j]);
      }
    }
  }
}

}  // namespace

std::uint8_t RecoveryCavity::local(std::uint32_t vert) const {
  return static_cast<std::uint8_t>(std::lower_bound(to_vert.begin(), to_vert.end(), vert) - to_vert.begin());
}

std::optional<RecoveryCavity> make_cavity(const LocalMesh& mesh, const EdgeSet& kept, const TetList& tets,
                                          std::size_t points_at_most) {
  if (tets.empty() || tets.size() > points_at_most * 8) return std::nullopt;
  RecoveryCavity cavity{tets, points_of(mesh, tets), {}, {}};
  if (cavity.to_vert.size() > points_at_most) return std::nullopt;
  for (const std::uint32_t v : cavity.to_vert) cavity.shape.points.push_back(mesh.point(v));
  add_faces(mesh, cavity);
  add_kept_edges(mesh, kept, cavity);
  return cavity;
}

void demand(RecoveryCavity& cavity, std::uint32_t a, std::uint32_t b) {
  const std::array<std::uint8_t, 2> edge{std::min(cavity.local(a), cavity.local(b)),
                                         std::max(cavity.local(a), cavity.local(b))};
  for (const auto& f : cavity.shape.faces) {
    if (std::find(f.begin(), f.end(), edge[0]) != f.end() && std::find(f.begin(), f.end(), edge[1]) != f.end()) return;
  }
  auto& edges = cavity.shape.edges;
  if (std::find(edges.begin(), edges.end(), edge) == edges.end()) edges.push_back(edge);
}

void demand(RecoveryCavity& cavity, const TriangleVerts& triangle) {
  const auto a = cavity.local(triangle[0]), b = cavity.local(triangle[1]), c = cavity.local(triangle[2]);
  cavity.shape.faces.push_back({a, b, c});
  cavity.shape.faces.push_back({a, c, b});
  cavity.face_to_code.insert(cavity.face_to_code.end(), 2, FaceCode());
  std::erase_if(cavity.shape.edges, [&](const std::array<std::uint8_t, 2>& e) {
    return (e[0] == a || e[0] == b || e[0] == c) && (e[1] == a || e[1] == b || e[1] == c);
  });
}

void leave_out(RecoveryCavity& cavity, std::uint32_t vert) {
  const std::uint8_t gone = cavity.local(vert);
  SmallPolyhedron& shape = cavity.shape;
  const auto has_it = [&](const auto& simplex) {
    return std::find(simplex.begin(), simplex.end(), gone) != simplex.end();
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < shape.faces.size(); ++i) {
    if (has_it(shape.faces[i])) continue;
    cavity.face_to_code[kept] = cavity.face_to_code[i];
    shape.faces[kept++] = shape.faces[i];
  }
  shape.faces.resize(kept);
  cavity.face_to_code.resize(kept);
  std::erase_if(shape.edges, has_it);
  const auto renumber = [&](auto& simplices) {
    for (auto& simplex : simplices) {
      for (std::uint8_t& v : simplex) v = static_cast<std::uint8_t>(v - (v > gone ? 1 : 0));
    }
  };
  renumber(shape.faces), renumber(shape.edges);
  shape.points.erase(shape.points.begin() + gone);
  cavity.to_vert.erase(cavity.to_vert.begin() + gone);
}

void refill(LocalMesh& mesh, const RecoveryCavity& cavity, const SmallFilling& filling) {
  std::vector<Tet> fresh;
  for (const auto& t : filling.tets)
    fresh.push_back({cavity.to_vert[t[0]], cavity.to_vert[t[1]], cavity.to_vert[t[2]], cavity.to_vert[t[3]]});
  mesh.replace(cavity.tets, fresh);
}

TetList grown(const LocalMesh& mesh, const RecoveryCavity& cavity, const SmallFilling& filling) {
  TetList tets = cavity.tets;
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < cavity.face_to_code.size(); ++i) {
    const FaceCode code = cavity.face_to_code[i];
    if (code.valid() && !mesh.mesh().is_fixed(code) && mesh.mesh().behind(code).valid()) order.push_back(i);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return filling.face_to_dead_ends[a] > filling.face_to_dead_ends[b];
  });
  std::size_t added = 0;
  for (const std::uint32_t i : order) {
    const std::uint32_t behind = mesh.mesh().behind(cavity.face_to_code[i]).tet();
    if (std::find(tets.begin(), tets.end(), behind) != tets.end()) continue;
    const Tet v = mesh.tet(behind);
    const bool adds_no_point = std::all_of(v.begin(), v.end(), [&](std::uint32_t x) {
      return std::binary_search(cavity.to_vert.begin(), cavity.to_vert.end(), x);
    });
    if (!adds_no_point && added >= kGrowth) continue;
    added += adds_no_point ? 0 : 1;
    tets.push_back(behind);
  }
  return tets;
}

}  // namespace tetloom::tets
