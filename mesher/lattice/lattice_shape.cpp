#include "mesher/lattice/lattice_shape.hpp"

#include <algorithm>
#include <tuple>
#include <utility>

namespace tetloom::lattice {

namespace {

Site operator+(const Site& a, const Site& b) { return {a.i + b.i, a.j + b.j, a.k + b.k}; }
Site operator-(const Site& a, const Site& b) { return {a.i - b.i, a.j - b.j, a.k - b.k}; }
std::int32_t norm2(const Site& a) { return a.i * a.i + a.j * a.j + a.k * a.k; }

// Six times the volume of the tet (0, a, b, c).
std::int32_t determinant(const Site& a, const Site& b, const Site& c) {
  return a.i * (b.j * c.k - b.k * c.j) + a.j * (b.k * c.i - b.i * c.k) + a.k * (b.i * c.j - b.j * c.i);
}

std::int32_t floor_of(std::int32_t x, int parts) { return (x & ~(parts - 1)) / parts; }

// The order does not change when all of the steps go as many cubes further.
auto order_of(const SiteStep& step) { return std::tuple(step.kind, step.z, step.y, step.x); }
bool is_before(const SiteStep& a, const SiteStep& b) { return order_of(a) < order_of(b); }

std::array<SiteStep, 3> sorted_face(const TetType& tet, std::size_t face) {
  std::array<SiteStep, 3> verts{};
  for (std::size_t i = 0, n = 0; i < 4; ++i)
    if (i != face) verts[n++] = tet.verts[i];
  std::sort(verts.begin(), verts.end(), is_before);
  return verts;
}

// True when face `b` moved by as many cubes as lie between their first vertices is face `a`.
bool is_moved(const std::array<SiteStep, 3>& a, const std::array<SiteStep, 3>& b) {
  const auto same = [&](std::size_t i) {
    return a[i].kind == b[i].kind && a[i].x - b[i].x == a[0].x - b[0].x && a[i].y - b[i].y == a[0].y - b[0].y &&
           a[i].z - b[i].z == a[0].z - b[0].z;
  };
  return same(0) && same(1) && same(2);
}

}  // namespace

const LatticeShape& LatticeShape::of(LatticeKind lattice) {
  static const LatticeShape bcc(LatticeKind::Bcc), a15(LatticeKind::A15);
  return lattice == LatticeKind::A15 ? a15 : bcc;
}

LatticeShape::LatticeShape(LatticeKind lattice) {
  lattice == LatticeKind::A15 ? set_a15() : set_bcc();
  residue_to_kind_.assign(static_cast<std::size_t>(parts_) * parts_ * parts_, -1);
  rows_.resize(static_cast<std::size_t>(parts_) * parts_);
  for (std::size_t kind = 0; kind < sites_.size(); ++kind) {
    const Site& site = sites_[kind];
    residue_to_kind_[residue(site.i, site.j, site.k)] = static_cast<int>(kind);
    Row& row = rows_[static_cast<std::size_t>(site.k * parts_ + site.j)];
    if (row.step == 0) {
      row = {site.i, parts_};
    } else {
      row = {std::min(row.first, site.i), parts_ / 2};
    }
  }
  find_around();
  find_tets();
  find_behind();
}

void LatticeShape::set_bcc() {
  parts_ = 2, nearest_ = 3, farthest_ = 4;
  cube_per_size_ = 1.06, graded_cube_per_size_ = 1.06;
  from_surface_ = 0.575, near_surface_ = 1.215, triangle_reach_ = from_surface_;  // faces: .5747, spheres: 1.211
  sites_ = {{0, 0, 0}, {1, 1, 1}};
}

void LatticeShape::set_a15() {
  parts_ = 4, nearest_ = 4, farthest_ = 6;
  cube_per_size_ = 1.715, graded_cube_per_size_ = 1.715;
  from_surface_ = 0.53, near_surface_ = 1.28, triangle_reach_ = near_surface_;
  sites_ = {{0, 0, 0}, {2, 2, 2}, {1, 0, 2}, {3, 0, 2}, {2, 1, 0}, {2, 3, 0}, {0, 2, 1}, {0, 2, 3}};
}

bool LatticeShape::is_next(const Site& a, const Site& b) const {
  const std::int32_t apart = norm2(a - b);
  return apart >= nearest_ && apart <= farthest_;
}

SiteStep LatticeShape::step_to(const Site& from, const Site& step) const {
  const Site to = from + step;
  return {kind_of(to), floor_of(to.i, parts_), floor_of(to.j, parts_), floor_of(to.k, parts_)};
}

void LatticeShape::find_around() {
  for (const Site& site : sites_) {
    std::vector<Site>& around = around_.emplace_back();
    for (std::int32_t k = -2; k <= 2; ++k) {
      for (std::int32_t j = -2; j <= 2; ++j) {
        for (std::int32_t i = -2; i <= 2; ++i) {
          const Site next = site + Site{i, j, k};
          if (kind_of(next) >= 0 && is_next(site, next)) around.push_back({i, j, k});
        }
      }
    }
  }
}

void LatticeShape::find_tets() {
  for (const Site& site : sites_) add_tets_at(site);
}

// Each tet once, at the first of its vertices.
void LatticeShape::add_tets_at(const Site& first) {
  const SiteStep here = step_to(first, {0, 0, 0});
  std::vector<Site> later;
  for (const Site& step : around(here.kind))
    if (is_before(here, step_to(first, step))) later.push_back(first + step);
  for (std::size_t a = 0; a < later.size(); ++a) {
    for (std::size_t b = a + 1; b < later.size(); ++b) {
      if (!is_next(later[a], later[b])) continue;
      for (std::size_t c = b + 1; c < later.size(); ++c) {
        if (is_next(later[a], later[c]) && is_next(later[b], later[c]))
          tets_.push_back(make_type({first, later[a], later[b], later[c]}));
      }
    }
  }
}

TetType LatticeShape::make_type(std::array<Site, 4> verts) const {
  if (determinant(verts[1] - verts[0], verts[2] - verts[0], verts[3] - verts[0]) < 0) std::swap(verts[2], verts[3]);
  TetType type{};
  for (std::size_t i = 0; i < 4; ++i) type.verts[i] = step_to(verts[i], {0, 0, 0});
  return type;
}

void LatticeShape::find_behind() {
  for (std::size_t tet = 0; tet < tets_.size() * 4; ++tet) {
    const std::array<SiteStep, 3> face = sorted_face(tets_[tet / 4], tet % 4);
    for (std::size_t other = 0; other < tets_.size() * 4; ++other) {
      const std::array<SiteStep, 3> back = sorted_face(tets_[other / 4], other % 4);
      if (other == tet || !is_moved(face, back)) continue;
      tets_[tet / 4].behind[tet % 4] = {static_cast<int>(other / 4), static_cast<int>(other % 4), face[0].x - back[0].x,
                                        face[0].y - back[0].y, face[0].z - back[0].z};
    }
  }
}

}  // namespace tetloom::lattice
