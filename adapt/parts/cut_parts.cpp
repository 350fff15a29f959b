#include "adapt/parts/cut_parts.hpp"

#include <algorithm>
#include <unordered_map>

namespace tetloom::adapt {

using tets::TetMesh;

Cutter::Cutter(const RoundShare& share, std::uint32_t first, std::uint32_t count)
    : share_(share),
      first_(first),
      owner_(share.mesh.points.size(), kNone),
      local_tet_(share.mesh.size()),
      local_vert_(share.mesh.points.size()),
      part_to_tets_(count),
      part_to_triangles_(count) {
  const WholeMesh& mesh = share.mesh;
  for (std::uint32_t tet = 0; tet < mesh.size(); ++tet) {
    const std::uint32_t part = part_of(tet);
    local_tet_[tet] = static_cast<std::uint32_t>(part_to_tets_[part].size());
    part_to_tets_[part].push_back(tet);
    for (std::size_t i = 0; i < 4; ++i) {
      std::uint32_t& owner = owner_[mesh.to_vert[std::size_t{tet} * 4 + i]];
      owner = owner == kNone || owner == part ? part : kShared;
    }
  }
  for (const std::uint32_t v : share.outside_verts) owner_[v] = kShared;
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& tets = mesh.triangles[i].tets;
    part_to_triangles_[part_of(tets[0])].push_back(i);
    if (tets[1] != kNone && part_of(tets[1]) != part_of(tets[0])) part_to_triangles_[part_of(tets[1])].push_back(i);
  }
}

class Cutter::Builder {
 public:
  Builder(Cutter& cutter, std::uint32_t number, PartOfWhole& part)
      : cutter_(cutter), mesh_(cutter.share_.mesh), number_(number), part_(part), m_(part.mesh.mesh) {}

  void run() {
    add_tets();
    add_verts();
    add_triangles();
    add_edges();
    part_.mesh.start();
  }

 private:
  bool has(std::uint32_t tet) const { return tet != kNone && cutter_.part_of(tet) == number_; }

  // Of a vertex that is in the part.
  std::uint32_t known(std::uint32_t v) const { return cutter_.is_shared(v) ? shared_.at(v) : cutter_.local_vert_[v]; }

  std::uint32_t local_of(std::uint32_t v) {
    const auto next = static_cast<std::uint32_t>(part_.to_whole.size());
    if (cutter_.is_shared(v)) {
      const auto [at, is_new] = shared_.emplace(v, next);
      if (is_new) part_.to_whole.push_back(v);
      return at->second;
    }
    std::uint32_t& local = cutter_.local_vert_[v];
    if (local >= next || part_.to_whole[local] != v) {
      local = next;
      part_.to_whole.push_back(v);
    }
    return local;
  }

  void add_tets() {
    const auto& tets = cutter_.part_to_tets_[number_];
    m_.to_vert.reserve(tets.size() * 5), m_.to_neighbor.reserve(tets.size() * 5);
    for (const std::uint32_t tet : tets) {
      std::uint8_t fixed = 0;
      for (std::uint32_t i = 0; i < 4; ++i) {
        m_.to_vert.push_back(local_of(mesh_.to_vert[std::size_t{tet} * 4 + i]));
        const FaceCode behind = mesh_.to_neighbor[std::size_t{tet} * 4 + i];
        const bool open = behind == kNone || !has(behind / 4);
        m_.to_neighbor.push_back(open ? kNone : cutter_.local_tet_[behind / 4] * 4 + behind % 4);
        fixed |= static_cast<std::uint8_t>(unsigned{open} << i);
      }
      m_.to_fixed.push_back(fixed);
      m_.to_region.push_back(mesh_.to_region[tet]);
    }
  }

  void add_verts() {
    CavityMesh& mesh = part_.mesh;
    for (const std::uint32_t v : part_.to_whole) {
      m_.points.push_back(mesh_.points[v]);
      mesh.to_metric.push_back(mesh_.to_metric[v]);
      mesh.to_entity.push_back(mesh_.to_entity[v]);
      mesh.to_hint.push_back(mesh_.to_hint[v]);
      mesh.to_frozen.push_back(static_cast<std::uint8_t>(cutter_.is_shared(v)));
      mesh.to_state.push_back(mesh_.to_state[v]);
    }
    part_.given = static_cast<std::uint32_t>(part_.to_whole.size());
  }

  void add_triangles() {
    for (const std::uint32_t i : cutter_.part_to_triangles_[number_]) {
      SurfaceTriangle triangle = mesh_.triangles[i].triangle;
      for (std::uint32_t& v : triangle.verts) v = known(v);
      part_.mesh.surface.add(triangle);
      for (const std::uint32_t tet : mesh_.triangles[i].tets) {
        if (!has(tet)) continue;
        const std::uint32_t local = cutter_.local_tet_[tet];
        for (std::uint32_t f = 0; f < 4; ++f) {
          const std::uint32_t apex = part_.mesh.verts(local)[f];
          if (std::find(triangle.verts.begin(), triangle.verts.end(), apex) == triangle.verts.end())
            m_.to_fixed[local] |= static_cast<std::uint8_t>(1u << f);
        }
      }
    }
  }

  // Those that its tets have, whether it has a triangle there or not.
  void add_edges() {
    for (const std::uint32_t tet : cutter_.part_to_tets_[number_])
      for_each_piece(mesh_, tet, [&](const ModelEdgePiece& piece) {
        part_.mesh.surface.add_edge(known(piece.verts[0]), known(piece.verts[1]), piece.edge);
      });
  }

  Cutter& cutter_;
  const WholeMesh& mesh_;
  std::uint32_t number_;
  PartOfWhole& part_;
  TetMesh& m_;
  std::unordered_map<std::uint32_t, std::uint32_t> shared_;  // their places here
};

void Cutter::build(std::uint32_t number, PartOfWhole& part) { Builder(*this, number, part).run(); }

}  // namespace tetloom::adapt
