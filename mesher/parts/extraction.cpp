#include "mesher/parts/extraction.hpp"

#include <algorithm>

#include "core/tets/triangle_verts.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

// Strips are a small share of the part: a byte per tet and per vertex is all that grows with it.
class Extraction {
 public:
  Extraction(const TetMesh& mesh, const PartBorder& border)
      : mesh_(mesh), tet_flags_(mesh.size(), 0), vert_flags_(mesh.points.size(), 0) {
    for (const auto& [vert, face] : border.verts) vert_flags_[vert] = kShared;
  }

  std::vector<TetsToMigrate> run(std::span<const FaceCode> open_faces,
                                 std::span<const std::pair<PartId, std::uint32_t>> verts) {
    for (const auto& [part, code] : find_seeds(open_faces, verts)) take_star(code, part);
    const std::size_t first_layer = taken_.size();
    for (std::size_t i = 0; i < first_layer; ++i) {
      const auto [part, tet] = taken_[i];
      for (const FaceCode code : FaceCode::of(tet)) take_star(code, part);
    }
    std::sort(taken_.begin(), taken_.end());
    std::vector<TetsToMigrate> result;
    for (const auto& [part, tet] : taken_) {
      if (result.empty() || result.back().to != part) result.push_back({part, {}});
      result.back().tets.push_back(tet);
    }
    return result;
  }

 private:
  static constexpr std::uint8_t kTaken = 16;                          // of a tet, beside a bit per corner
  static constexpr std::uint8_t kShared = 1, kDone = 2, kWanted = 4;  // of a vertex

  // Where a star is in several pieces, each has an open face at its vertex.
  std::vector<std::pair<PartId, FaceCode>> find_seeds(std::span<const FaceCode> open_faces,
                                                      std::span<const std::pair<PartId, std::uint32_t>> verts) {
    std::vector<std::pair<std::uint32_t, PartId>> vert_to_part;
    for (const auto& [part, vert] : verts) {
      vert_to_part.emplace_back(vert, part);
      vert_flags_[vert] |= kWanted;
    }
    std::sort(vert_to_part.begin(), vert_to_part.end());
    std::vector<std::pair<PartId, FaceCode>> seeds;
    for (const FaceCode face : open_faces) {
      for (const std::uint32_t v : verts_of(mesh_, face)) {
        if (!(vert_flags_[v] & kWanted)) continue;
        const auto owned = std::lower_bound(vert_to_part.begin(), vert_to_part.end(), std::pair{v, PartId(0)});
        seeds.emplace_back(owned->second, FaceCode(face.tet(), corner_of(mesh_, face.tet(), v)));
      }
    }
    std::stable_sort(seeds.begin(), seeds.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    return seeds;
  }

  // Tets around the vertex at a corner, as far as they hang together, that nobody has yet. Stars are not cut where
  // others have taken a part of them.
  void take_star(FaceCode code, PartId part) {
    std::uint8_t& flags = vert_flags_[mesh_.apex(code)];
    // Stars that are no part's border hang together: one walk is enough.
    if (flags & kShared ? is_walked(code) : (flags & kDone) != 0) return;
    flags |= kDone;
    walk_star(code, part);
  }

  void walk_star(FaceCode code, PartId part) {
    const std::uint32_t vert = mesh_.apex(code);
    stack_.assign(1, code);
    walk(code);
    while (!stack_.empty()) {
      const std::uint32_t tet = stack_.back().tet(), corner = stack_.back().side();
      stack_.pop_back();
      if (!(tet_flags_[tet] & kTaken)) {
        tet_flags_[tet] |= kTaken;
        taken_.emplace_back(part, tet);
      }
      for (std::uint32_t i = 0; i < 4; ++i) {
        const FaceCode face(tet, i), behind = mesh_.behind(face);
        if (i == corner || !behind.valid() || mesh_.is_fixed(face)) continue;
        const FaceCode next(behind.tet(), corner_of(mesh_, behind.tet(), vert));
        if (is_walked(next)) continue;
        walk(next);
        stack_.push_back(next);
      }
    }
  }

  // Whether the star of the vertex at this corner was walked through the tet.
  bool is_walked(FaceCode code) const { return (tet_flags_[code.tet()] >> code.side() & 1) != 0; }
  void walk(FaceCode code) { tet_flags_[code.tet()] |= static_cast<std::uint8_t>(1u << code.side()); }

  const TetMesh& mesh_;
  std::vector<std::uint8_t> tet_flags_, vert_flags_;
  std::vector<std::pair<PartId, std::uint32_t>> taken_;
  std::vector<FaceCode> stack_;
};

}  // namespace

std::vector<TetsToMigrate> find_tets_to_migrate(const TetMesh& mesh, const StripState& strips,
                                                std::span<const std::pair<PartId, std::uint32_t>> verts) {
  return Extraction(mesh, strips.border).run(strips.open_faces, verts);
}

}  // namespace tetloom::parts
