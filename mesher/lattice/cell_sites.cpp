#include "mesher/lattice/cell_sites.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace tetloom::lattice {

namespace {

constexpr std::uint32_t kNoSite = 0xffffffffu, kNoGroup = 0xfffffffeu;

// A triangle ready for many distances.
class TriangleFrame {
 public:
  TriangleFrame(const Vec3& a, const Vec3& b, const Vec3& c)
      : corner_{a, b, c}, along_{b - a, c - b, a - c}, normal_(cross(b - a, c - a)), area2_(norm2(normal_)) {
    for (std::size_t i = 0; i < 3; ++i) {
      inwards_[i] = cross(normal_, along_[i]);
      const double length2 = norm2(along_[i]);
      per_length2_[i] = length2 > 0 ? 1 / length2 : 0;
    }
  }

  // The squared distance to x where it is below `best`, otherwise `best`. What is nearest to a point that does not
  // project into the triangle lies on one of the edges beyond which the point is.
  double nearer(const Vec3& x, double best) const {
    const double height = dot(x - corner_[0], normal_);
    if (height * height > area2_ * best) return best;
    bool is_above = area2_ > 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 from = x - corner_[i];
      if (area2_ > 0 && dot(from, inwards_[i]) >= 0) continue;
      is_above = false;
      const double t = std::clamp(dot(from, along_[i]) * per_length2_[i], 0.0, 1.0);
      best = std::min(best, norm2(from - t * along_[i]));
    }
    return is_above ? std::min(best, height * height / area2_) : best;
  }

 private:
  std::array<Vec3, 3> corner_, along_, inwards_;
  std::array<double, 3> per_length2_;
  Vec3 normal_;
  double area2_;
};

}  // namespace

std::vector<KeptSite> CellSites::find(const SiteLattice& lattice, const Box3& box, const Questions& questions) {
  lattice_ = &lattice;
  first_ = lattice.first_site(box.lo), end_ = lattice.first_site(box.hi);
  if (first_.i >= end_.i || first_.j >= end_.j || first_.k >= end_.k) return {};
  enter_sites(questions);
  if (wanted_first_.i >= wanted_end_.i) return {};
  if (questions.tree) measure_distances(*questions.tree);
  group_sites();
  return take_inside(questions);
}

bool CellSites::holds(const Site& s) const {
  return s.i >= first_.i && s.i < end_.i && s.j >= first_.j && s.j < end_.j && s.k >= first_.k && s.k < end_.k;
}

// Of the eight places in two by two by one parts of a cube's, from even coordinates on, no lattice has more than one.
std::size_t CellSites::slot_of(const Site& s) const {
  return (static_cast<std::size_t>(s.k - first_.k) * rows_ + static_cast<std::size_t>((s.j >> 1) - (first_.j >> 1))) *
             columns_ +
         static_cast<std::size_t>((s.i >> 1) - (first_.i >> 1));
}

void CellSites::enter_sites(const Questions& questions) {
  const double reach = lattice_->shape().triangle_reach() * lattice_->size();
  const double nearest = lattice_->shape().from_surface() * lattice_->size();
  reach2_ = reach * reach, nearest2_ = nearest * nearest;
  columns_ = static_cast<std::size_t>((end_.i >> 1) - (first_.i >> 1) + 1);
  rows_ = static_cast<std::size_t>((end_.j >> 1) - (first_.j >> 1) + 1);
  entries_.assign(slot_of({first_.i, first_.j, end_.k}), {{}, kNoSite, false});
  wanted_first_ = end_, wanted_end_ = first_;
  lattice_->for_each_between(first_, end_, [&](const Site& site) {
    Entry& entry = entries_[slot_of(site)];
    entry.point = lattice_->point(site);
    if (questions.is_wanted && !questions.is_wanted(entry.point)) return;
    entry.group = kNoGroup;
    wanted_first_ = {std::min(wanted_first_.i, site.i), std::min(wanted_first_.j, site.j),
                     std::min(wanted_first_.k, site.k)};
    wanted_end_ = {std::max(wanted_end_.i, site.i + 1), std::max(wanted_end_.j, site.j + 1),
                   std::max(wanted_end_.k, site.k + 1)};
  });
}

void CellSites::measure_distances(const intersection::TriangleTree& tree) {
  const double reach = lattice_->shape().near_surface() * lattice_->size();
  const bool asks_points = lattice_->shape().triangle_reach() < lattice_->shape().near_surface();
  Box3 box;
  for (const Site& corner : {wanted_first_, wanted_end_}) box.add(lattice_->point(corner));
  const Vec3 margin{reach, reach, reach};
  ++cell_;
  tree.for_each_leaf_in({box.lo - margin, box.hi + margin}, 0, [&](std::size_t leaf) {
    for (const std::uint32_t triangle : tree.leaf_triangles(leaf)) {
      const std::array<Vec3, 3> corners = tree.corners_of(triangle);
      const auto& verts = tree.verts_of(triangle);
      for (std::size_t i = 0; asks_points && i < 3; ++i) {
        if (verts[i] >= point_to_cell_.size()) point_to_cell_.resize(verts[i] + verts[i] / 2 + 1, 0);
        if (std::exchange(point_to_cell_[verts[i]], cell_) != cell_) mark_near(corners[i]);
      }
      measure_to(corners);
    }
  });
}

template <class Visit>
void CellSites::for_each_wanted_in(const Box3& box, Visit&& visit) {
  const Site lo = lattice_->first_site(box.lo), hi = lattice_->first_site(box.hi);
  const Site from{std::max(lo.i, wanted_first_.i), std::max(lo.j, wanted_first_.j), std::max(lo.k, wanted_first_.k)};
  const Site to{std::min(hi.i, wanted_end_.i), std::min(hi.j, wanted_end_.j), std::min(hi.k, wanted_end_.k)};
  if (from.i >= to.i || from.j >= to.j || from.k >= to.k) return;
  lattice_->for_each_between(from, to, [&](const Site& site) { visit(entries_[slot_of(site)]); });
}

void CellSites::mark_near(const Vec3& surface_point) {
  const double reach = lattice_->shape().near_surface() * lattice_->size();
  const Vec3 margin{reach, reach, reach};
  for_each_wanted_in({surface_point - margin, surface_point + margin},
                     [&](Entry& entry) { entry.near |= norm2(entry.point - surface_point) < reach * reach; });
}

void CellSites::measure_to(const std::array<Vec3, 3>& triangle) {
  const auto& [a, b, c] = triangle;
  const double reach = lattice_->shape().triangle_reach() * lattice_->size();
  const Vec3 margin{reach, reach, reach};
  Box3 box;
  for (const Vec3& x : triangle) box.add(x);
  const TriangleFrame frame(a, b, c);
  for_each_wanted_in({box.lo - margin, box.hi + margin}, [&](Entry& entry) {
    if (entry.group == kNoSite) return;
    const double told = entry.near ? nearest2_ : reach2_;
    const double distance2 = frame.nearer(entry.point, told);
    if (distance2 < nearest2_) entry.group = kNoSite;
    entry.near |= distance2 < told;
  });
}

void CellSites::group_sites() {
  heads_.clear();
  lattice_->for_each_between(wanted_first_, wanted_end_, [&](const Site& seed) {
    const Entry& entry = entries_[slot_of(seed)];
    if (entry.group != kNoGroup) return;
    spread_group(seed, static_cast<std::uint32_t>(heads_.size()));
    heads_.push_back(seed);
  });
}

void CellSites::spread_group(const Site& seed, std::uint32_t group) {
  const LatticeShape& shape = lattice_->shape();
  stack_.assign(1, seed);
  entries_[slot_of(seed)].group = group;
  while (!stack_.empty()) {
    const Site site = stack_.back();
    stack_.pop_back();
    for (const Site& step : shape.around(shape.kind_of(site))) {
      const Site next{site.i + step.i, site.j + step.j, site.k + step.k};
      if (!holds(next)) continue;
      Entry& entry = entries_[slot_of(next)];
      if (entry.group != kNoGroup) continue;
      entry.group = group;
      stack_.push_back(next);
    }
  }
}

std::vector<KeptSite> CellSites::take_inside(const Questions& questions) const {
  std::vector<char> inside;
  for (const Site& head : heads_)
    inside.push_back(!questions.is_inside || questions.is_inside(entries_[slot_of(head)].point));
  std::vector<KeptSite> kept;
  lattice_->for_each_between(first_, end_, [&](const Site& site) {
    const Entry& entry = entries_[slot_of(site)];
    if (entry.group < inside.size() && inside[entry.group]) kept.push_back({site, entry.near});
  });
  return kept;
}

}  // namespace tetloom::lattice
