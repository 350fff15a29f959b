#include "mesher/volume/region_coloring.hpp"

#include <algorithm>
#include <utility>

#include "core/predicates/predicates.hpp"

namespace tetloom::volume {

namespace {

constexpr std::uint32_t kUnseen = 0xffffffffu;

Vec3 center_of(const Filling& filling, const TetVertices& tet) {
  Vec3 sum;
  for (const std::uint32_t v : tet) sum += filling.points[v];
  return 0.25 * sum;
}

FillingVerdict orient_tets(Filling& filling) {
  for (TetVertices& tet : filling.tet_to_vert) {
    const auto& p = filling.points;
    const int sign = orient3d(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]);
    if (sign == 0) return {"a tetrahedron has no volume", {}, center_of(filling, tet)};
    if (sign < 0) std::swap(tet[2], tet[3]);
  }
  return {};
}

class Coloring {
 public:
  Coloring(const Complex& complex, Filling& filling)
      : complex_(complex), filling_(filling), faces_(pair_faces(filling.tet_to_vert, filling.points.size())) {}

  FillingVerdict run() {
    if (!faces_.conforming) return {"more than two tetrahedra share a face", {}, filling_.points[0]};
    for (const auto& step :
         {&Coloring::mark_surface, &Coloring::flood, &Coloring::name_floods, &Coloring::check_sides}) {
      if (FillingVerdict verdict = (this->*step)(); !verdict.good()) return verdict;
    }
    drop_outside();
    return {};
  }

 private:
  // Finds every triangle among the faces and remembers it there.
  FillingVerdict mark_surface() {
    const FaceLookup lookup(filling_.tet_to_vert, filling_.points.size());
    face_to_tri_.assign(filling_.tet_to_vert.size() * 4, kNoFace);
    FillingVerdict verdict;
    for (std::uint32_t t = 0; t < complex_.tri_to_vert.size(); ++t) {
      const auto found = lookup.find(complex_.tri_to_vert[t]);
      if (found[0] == kNoFace) verdict.triangles.push_back(t);
      for (const std::uint32_t face : found) {
        if (face != kNoFace) face_to_tri_[face] = t;
      }
    }
    if (verdict.triangles.empty()) return {};
    const auto& [a, b, c] = complex_.tri_to_vert[verdict.triangles[0]];
    verdict.point = (complex_.points[a] + complex_.points[b] + complex_.points[c]) / 3;
    verdict.message = std::to_string(verdict.triangles.size()) + " surface triangles are not faces of the mesh";
    return verdict;
  }

  FillingVerdict flood() {
    tet_to_flood_.assign(filling_.tet_to_vert.size(), kUnseen);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t seed = 0; seed < tet_to_flood_.size(); ++seed) {
      if (tet_to_flood_[seed] != kUnseen) continue;
      const auto color = static_cast<std::uint32_t>(flood_to_region_.size());
      flood_to_region_.push_back(kUnseen);
      tet_to_flood_[seed] = color;
      stack.push_back(seed);
      while (!stack.empty()) {
        const std::uint32_t tet = stack.back();
        stack.pop_back();
        for (std::uint32_t face = 4 * tet; face < 4 * tet + 4; ++face) {
          if (face_to_tri_[face] != kNoFace || faces_.face_to_mate[face] == kNoFace) continue;
          const std::uint32_t next = faces_.face_to_mate[face] / 4;
          if (tet_to_flood_[next] != kUnseen) continue;
          tet_to_flood_[next] = color;
          stack.push_back(next);
        }
      }
    }
    return {};
  }

  // The region that a marked face's triangle names on the side of the face's tet.
  ModelRegionId named_region(std::uint32_t face) const {
    const std::uint32_t t = face_to_tri_[face];
    const bool normal_points_out = turn_of(filling_.tet_to_vert[face / 4], face % 4, complex_.tri_to_vert[t]) > 0;
    return normal_points_out ? complex_.tri_to_sides[t].back : complex_.tri_to_sides[t].front;
  }

  // Every flood has a triangle around it, except one that reaches the hull through an unmarked face: outside.
  FillingVerdict name_floods() {
    std::vector<char> named(flood_to_region_.size(), 0);
    for (std::uint32_t face = 0; face < face_to_tri_.size(); ++face) {
      const std::uint32_t color = tet_to_flood_[face / 4];
      const bool hull = faces_.face_to_mate[face] == kNoFace;
      if (face_to_tri_[face] == kNoFace && !hull) continue;
      const std::uint32_t region = face_to_tri_[face] == kNoFace ? kUnseen : named_region(face).value;
      if (named[color] && flood_to_region_[color] != region) {
        FillingVerdict verdict{
            "the surface does not separate its regions", {}, center_of(filling_, filling_.tet_to_vert[face / 4])};
        if (face_to_tri_[face] != kNoFace) verdict.triangles.push_back(face_to_tri_[face]);
        return verdict;
      }
      named[color] = 1;
      flood_to_region_[color] = region;
    }
    return {};
  }

  FillingVerdict check_sides() {
    std::vector<char> front(complex_.tri_to_vert.size(), 0), back(front);
    for (std::uint32_t face = 0; face < face_to_tri_.size(); ++face) {
      const std::uint32_t t = face_to_tri_[face];
      if (t == kNoFace) continue;
      const bool out = turn_of(filling_.tet_to_vert[face / 4], face % 4, complex_.tri_to_vert[t]) > 0;
      (out ? back : front)[t] = 1;
    }
    for (std::uint32_t t = 0; t < front.size(); ++t) {
      const FaceSides& sides = complex_.tri_to_sides[t];
      if ((sides.front.valid() && !front[t]) || (sides.back.valid() && !back[t])) {
        return {"a side of a surface triangle was left empty", {t}, complex_.points[complex_.tri_to_vert[t][0]]};
      }
    }
    return {};
  }

  void drop_outside() {
    std::size_t kept = 0;
    for (std::size_t tet = 0; tet < filling_.tet_to_vert.size(); ++tet) {
      const std::uint32_t region = flood_to_region_[tet_to_flood_[tet]];
      if (region == kUnseen) continue;
      filling_.tet_to_vert[kept++] = filling_.tet_to_vert[tet];
      filling_.tet_to_region.push_back(region);
    }
    filling_.tet_to_vert.resize(kept);
    drop_unused_points();
  }

  void drop_unused_points() {
    std::vector<std::uint32_t> to_new(filling_.points.size(), kUnseen);
    for (const TetVertices& tet : filling_.tet_to_vert) {
      for (const std::uint32_t v : tet) to_new[v] = 0;
    }
    std::uint32_t kept = 0;
    for (std::uint32_t v = 0; v < to_new.size(); ++v) {
      if (v >= complex_.points.size() && to_new[v] == kUnseen) continue;
      filling_.points[kept] = filling_.points[v];
      to_new[v] = kept++;
    }
    filling_.points.resize(kept);
    for (TetVertices& tet : filling_.tet_to_vert) {
      for (std::uint32_t& v : tet) v = to_new[v];
    }
  }

  const Complex& complex_;
  Filling& filling_;
  TetFaces faces_;
  std::vector<std::uint32_t> face_to_tri_, tet_to_flood_, flood_to_region_;
};

}  // namespace

FillingVerdict color_regions(const Complex& complex, Filling& filling) {
  filling.tet_to_region.clear();
  if (filling.tet_to_vert.empty()) return {"there are no tetrahedra", {}, complex.points[0]};
  if (FillingVerdict verdict = orient_tets(filling); !verdict.good()) return verdict;
  return Coloring(complex, filling).run();
}

}  // namespace tetloom::volume
