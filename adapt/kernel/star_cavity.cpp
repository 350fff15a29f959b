#include "adapt/kernel/star_cavity.hpp"

#include <algorithm>
#include <utility>

namespace tetloom::adapt {

namespace {

constexpr std::size_t kMostMore = 4;  // tets beside the ball
constexpr std::size_t kMostBad = 2;   // faces at once

std::uint64_t key_of(std::uint32_t a, std::uint32_t b) { return std::uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

}  // namespace

void StarCavity::add(std::uint32_t tet) {
  tets_.push_back(tet);
  marks_[tet] = mark_;
}

// Fills made_ and sides_ for the tets at hand, and bad_ with faces whose tets would not be good enough. False: what
// lies between two of the tets has to stay, or too much is bad.
bool StarCavity::collect(double goal) {
  made_.clear(), sides_.clear(), bad_.clear();
  for (const std::uint32_t tet : tets_) {
    const std::uint32_t* v = mesh_.verts(tet);
    const std::uint32_t own = mesh_.corner_of(tet, p_);
    for (std::uint32_t j = 0; j < 4; ++j) {
      const FaceCode face(tet, j), behind = mesh_.mesh.behind(face);
      const bool fixed = mesh_.mesh.is_fixed(face);
      if (behind.valid() && has(behind.tet())) {
        if (fixed) return false;
        continue;
      }
      if (own < 4 && own != j) {
        std::uint64_t edge[2];
        std::size_t count = 0;
        for (std::uint32_t k = 0; k < 4; ++k)
          if (k != own && k != j) edge[count++] = v[k];
        sides_.push_back({key_of(static_cast<std::uint32_t>(edge[0]), static_cast<std::uint32_t>(edge[1])), kNone});
        continue;
      }
      Made one{{v[0], v[1], v[2], v[3]}, j, 0};
      one.verts[j] = p_;
      const double quality = mesh_.quality_of(one.verts[0], one.verts[1], one.verts[2], one.verts[3]);
      if (!(quality > goal)) {
        if (fixed || !behind.valid() || bad_.size() == kMostBad) return false;
        bad_.push_back(behind.tet());
      }
      one.quality = static_cast<float>(quality);
      made_.push_back(one);
    }
  }
  return true;
}

// Whether what is made closes around p, and no vertex but the core goes. Fills link_.
bool StarCavity::is_closed() {
  link_.clear();
  vert_marks_.resize(std::max(vert_marks_.size(), mesh_.mesh.points.size()), 0);
  vert_marks_[p_] = mark_;
  for (std::uint32_t n = 0; n < made_.size(); ++n) {
    const Made& one = made_[n];
    for (std::uint32_t j = 0; j < 4; ++j) {
      if (j == one.corner) continue;
      const std::uint32_t v = one.verts[j];
      if (vert_marks_[v] != mark_) link_.push_back(v), vert_marks_[v] = mark_;
      const std::uint32_t a = one.verts[(j + 1) % 4], b = one.verts[(j + 2) % 4], c = one.verts[(j + 3) % 4];
      sides_.push_back({a == p_ ? key_of(b, c) : b == p_ ? key_of(a, c) : key_of(a, b), n});
    }
  }
  for (const std::uint32_t tet : tets_)
    for (std::uint32_t j = 0; j < 4; ++j)
      if (mesh_.verts(tet)[j] != core_ && vert_marks_[mesh_.verts(tet)[j]] != mark_) return false;
  std::ranges::sort(sides_,
                    [](const Side& a, const Side& b) { return std::pair(a.edge, a.made) < std::pair(b.edge, b.made); });
  if (sides_.size() % 2 != 0) return false;
  for (std::size_t i = 0; i < sides_.size(); i += 2) {
    if (sides_[i].edge != sides_[i + 1].edge || sides_[i].made == kNone) return false;
    if (i > 0 && sides_[i - 1].edge == sides_[i].edge) return false;
  }
  return true;
}

bool StarCavity::find(const Cavity& ball, std::uint32_t p, double goal) {
  core_ = ball.core[0], p_ = p;
  marks_.resize(std::max(marks_.size(), mesh_.mesh.size()), 0);
  ++mark_;
  tets_.clear();
  for (const std::uint32_t tet : ball.tets) add(tet);
  for (;;) {
    if (!collect(goal)) return false;
    if (bad_.empty()) return !made_.empty() && is_closed();
    for (const std::uint32_t tet : bad_)
      if (!has(tet)) add(tet);
    if (tets_.size() > ball.tets.size() + kMostMore) return false;
  }
}

void StarCavity::fill() {
  std::vector<tets::NewTet> made;
  for (const Made& one : made_) made.push_back({one.verts, double{one.quality}});
  mesh_.replace(tets_, made);
  mesh_.vert_to_tet[core_] = kNone;
}

}  // namespace tetloom::adapt
