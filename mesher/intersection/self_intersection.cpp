#include "mesher/intersection/self_intersection.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "core/base/failure.hpp"
#include "core/base/lists.hpp"
#include "mesher/intersection/triangle_pair.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

namespace {

constexpr std::size_t kLeafSize = intersection::TriangleTree::kLeafSize;
constexpr std::size_t kLeavesPerBlock = 256, kTrianglesPerBlock = 1 << 12;

bool comes_before(const TriangleIntersection& a, const TriangleIntersection& b) {
  return std::pair(a.first, a.second) < std::pair(b.first, b.second);
}

class Searcher {
 public:
  Searcher(const IntersectionSearch& search, const intersection::TriangleTree& tree, const SharedWork& work)
      : search_(search), tree_(tree), runner_(work.runner()), degenerate_(search.tri_to_vert.size()) {
    work.fill<char>(degenerate_, kTrianglesPerBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& [a, b, c] = search_.tri_to_vert[i];
        degenerate_[i] = intersection::is_degenerate(search_.points[a], search_.points[b], search_.points[c]);
      }
    });
  }

  std::size_t leaf_count() const { return tree_.leaf_count(); }

  // Intersections between the triangles of the leaves [begin, end) and those of all later leaves, and of all leaves
  // without new triangles.
  std::vector<TriangleIntersection> search_leaves(std::size_t begin, std::size_t end) const {
    std::vector<TriangleIntersection> found;
    for (std::size_t leaf = begin; leaf < end && found.size() < search_.most; ++leaf) {
      if (!has_new(leaf)) continue;
      runner_.check_cancelled();  // of long triangles, each may lie near all others
      for (const std::uint32_t triangle : tree_.leaf_triangles(leaf)) {
        if (degenerate_[triangle] && is_new(triangle)) found.push_back(degenerate_at(triangle));
      }
      // Of two leaves with new triangles the first compares them.
      const std::size_t first = search_.tri_is_new.empty() ? leaf : 0;
      const LeafBoxes boxes = boxes_of(leaf);
      tree_.for_each_leaf_in(boxes.around, first, [&](std::size_t other) {
        if (other >= leaf || !has_new(other)) compare_leaves(leaf, boxes, other, found);
      });
    }
    const std::size_t last = std::min(end * kLeafSize, search_.tri_to_vert.size());
    if (search_.tells_progress) runner_.advance(last - begin * kLeafSize);
    return found;
  }

 private:
  struct LeafBoxes {
    Box3 around;
    std::array<Box3, kLeafSize> of_triangles;
  };

  LeafBoxes boxes_of(std::size_t leaf) const {
    LeafBoxes boxes;
    std::ranges::transform(tree_.leaf_triangles(leaf), boxes.of_triangles.begin(), [&](std::uint32_t t) {
      const Box3 box = tree_.box_of(t);
      boxes.around.add(box);
      return box;
    });
    return boxes;
  }
  bool is_new(std::uint32_t triangle) const { return search_.tri_is_new.empty() || search_.tri_is_new[triangle] != 0; }
  bool has_new(std::size_t leaf) const {
    return std::ranges::any_of(tree_.leaf_triangles(leaf), [&](auto t) { return is_new(t); });
  }

  // `boxes`: of `leaf`.
  void compare_leaves(std::size_t leaf, const LeafBoxes& boxes, std::size_t other,
                      std::vector<TriangleIntersection>& found) const {
    const auto ours = tree_.leaf_triangles(leaf), theirs = tree_.leaf_triangles(other);
    for (std::size_t j = 0; j < theirs.size(); ++j) {
      const Box3 box = tree_.box_of(theirs[j]);
      if (!box.overlaps(boxes.around)) continue;
      for (std::size_t i = 0; i < (leaf == other ? j : ours.size()); ++i) {
        if (box.overlaps(boxes.of_triangles[i])) compare(ours[i], theirs[j], found);
      }
    }
  }

  void compare(std::uint32_t one, std::uint32_t other, std::vector<TriangleIntersection>& found) const {
    const auto [first, second] = std::minmax(one, other);
    if (degenerate_[first] || degenerate_[second] || found.size() >= search_.most) return;
    if (!is_new(first) && !is_new(second)) return;
    if (!search_.tri_to_group.empty() && search_.tri_to_group[first] != search_.tri_to_group[second]) return;
    const auto verdict =
        intersection::check_pair(search_.points, search_.tri_to_vert[first], search_.tri_to_vert[second]);
    if (verdict) found.push_back({first, second, verdict->kind, verdict->point});
  }

  TriangleIntersection degenerate_at(std::uint32_t triangle) const {
    return {triangle, triangle, IntersectionKind::Degenerate, search_.points[search_.tri_to_vert[triangle][0]]};
  }

  const IntersectionSearch& search_;
  const intersection::TriangleTree& tree_;
  const TaskRunner& runner_;
  std::vector<char> degenerate_;
};

std::string count_of(std::size_t count, const char* singular, const char* plural) {
  return std::to_string(count) + " " + (count == 1 ? singular : plural);
}

NamedEntity named_face(std::uint32_t face, const TriangleOrigin& origin) {
  const ModelEntity entity{2, face};
  if (origin.model && face < origin.model->topology().face_count()) return origin.model->named(entity);
  return {entity, {}};
}

// What the intersections of one pair of faces, or of one face with itself, have to say.
Diagnostic describe_group(std::span<const TriangleIntersection* const> group, const TriangleOrigin& origin) {
  const std::uint32_t one = origin.tri_to_face[group[0]->first], other = origin.tri_to_face[group[0]->second];
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::SelfIntersection;
  diagnostic.entities.push_back(named_face(std::min(one, other), origin));
  if (one != other) diagnostic.entities.push_back(named_face(std::max(one, other), origin));
  const auto& names = diagnostic.entities;
  const auto is_degenerate_triangle = [](const TriangleIntersection* x) {
    return x->kind == IntersectionKind::Degenerate;
  };
  if (std::all_of(group.begin(), group.end(), is_degenerate_triangle)) {
    diagnostic.message = "the surface mesh of " + describe(names[0]) + " has " +
                         count_of(group.size(), "triangle", "triangles") + " without area";
  } else if (std::ranges::all_of(group, [](const auto* x) { return x->kind == IntersectionKind::Skin; })) {
    diagnostic.message = "the material between " + describe(names.front()) + " and " +
                         (one == other ? "itself" : describe(names.back())) +
                         " is thinner than the tolerance of the model at " + count_of(group.size(), "pair", "pairs") +
                         " of triangles";
  } else if (one == other) {
    diagnostic.message = "the surface mesh of " + describe(names[0]) + " crosses or touches itself in " +
                         count_of(group.size(), "pair", "pairs") + " of triangles";
  } else {
    diagnostic.message = "the surface meshes of " + describe(names[0]) + " and " + describe(names[1]) +
                         " cross or touch in " + count_of(group.size(), "pair", "pairs") + " of triangles";
  }
  diagnostic.point = group[0]->point;
  for (const TriangleIntersection* item : group) {
    diagnostic.elements.push_back(item->first);
    if (item->second != item->first) diagnostic.elements.push_back(item->second);
  }
  std::sort(diagnostic.elements.begin(), diagnostic.elements.end());
  diagnostic.elements.erase(std::unique(diagnostic.elements.begin(), diagnostic.elements.end()),
                            diagnostic.elements.end());
  if (diagnostic.elements.size() > kElementsToldAtMost) diagnostic.elements.resize(kElementsToldAtMost);
  return diagnostic;
}

// Whether only few triangles are new: what is far from them need not be in the tree.
bool is_local(const IntersectionSearch& search) {
  constexpr std::ptrdiff_t kFew = 8;  // one in so many
  return !search.tri_is_new.empty() && !search.tells_progress &&
         std::ssize(search.tri_is_new) - std::ranges::count(search.tri_is_new, 0) <=
             std::ssize(search.tri_is_new) / kFew;
}

// New triangles, and those whose boxes nearly meet one of them; ascending.
std::vector<std::uint32_t> triangles_near_new(const IntersectionSearch& search, const TaskRunner& runner) {
  std::vector<std::array<std::uint32_t, 3>> all_new;
  for (std::size_t t = 0; t < search.tri_is_new.size(); ++t)
    if (search.tri_is_new[t]) all_new.push_back(search.tri_to_vert[t]);
  const intersection::TriangleTree tree(search.points, all_new, runner);
  std::vector<std::uint8_t> is_near(search.tri_is_new.begin(), search.tri_is_new.end());
  runner.for_blocks(is_near.size(), kTrianglesPerBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      Box3 box;
      for (const std::uint32_t v : search.tri_to_vert[t]) box.add(search.points[v]);
      is_near[t] = is_near[t] || tree.may_meet(box);
    }
  });
  std::vector<std::uint32_t> near;
  for (std::uint32_t t = 0; t < is_near.size(); ++t)
    if (is_near[t]) near.push_back(t);
  return near;
}

std::vector<TriangleIntersection> find_near_new(const IntersectionSearch& search, const TaskRunner& runner) {
  if (std::ranges::count(search.tri_is_new, 0) == std::ssize(search.tri_is_new)) return {};
  const std::vector<std::uint32_t> near = triangles_near_new(search, runner);
  std::vector<std::array<std::uint32_t, 3>> verts;
  std::vector<std::uint32_t> groups;
  std::vector<std::uint8_t> is_new;
  for (const std::uint32_t t : near) {
    verts.push_back(search.tri_to_vert[t]), is_new.push_back(search.tri_is_new[t]);
    if (!search.tri_to_group.empty()) groups.push_back(search.tri_to_group[t]);
  }
  const intersection::TriangleTree tree(search.points, verts, runner);
  std::vector<TriangleIntersection> found =
      find_self_intersections({search.points, verts, groups, search.most, false, is_new}, tree, runner);
  for (TriangleIntersection& one : found) one.first = near[one.first], one.second = near[one.second];
  return found;
}

}  // namespace

double longest_edge(const Mesh& surface, const TriangleIntersection& crossing) {
  double longest = 0;
  for (const std::uint32_t tri : {crossing.first, crossing.second}) {
    const auto& [a, b, c] = surface.tri_to_vert[tri];
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      longest = std::max(longest, distance(surface.points[from], surface.points[to]));
  }
  return longest;
}

std::vector<TriangleIntersection> find_self_intersections(const IntersectionSearch& search, const TaskRunner& runner) {
  if (is_local(search)) return find_near_new(search, runner);
  return find_self_intersections(search, intersection::TriangleTree(search.points, search.tri_to_vert, runner), runner);
}

std::vector<TriangleIntersection> find_self_intersections(const IntersectionSearch& search,
                                                          const intersection::TriangleTree& tree,
                                                          const SharedWork& work) {
  const Searcher searcher(search, tree, work);
  const std::vector<double> blocks((searcher.leaf_count() + kLeavesPerBlock - 1) / kLeavesPerBlock, 1.0);
  const auto block_to_found = work.make_lists<TriangleIntersection>(blocks, [&](std::size_t block) {
    const std::size_t begin = block * kLeavesPerBlock;
    return searcher.search_leaves(begin, std::min(begin + kLeavesPerBlock, searcher.leaf_count()));
  });
  std::vector<TriangleIntersection> all = joined(block_to_found);
  std::sort(all.begin(), all.end(), comes_before);
  if (all.size() > search.most) all.resize(search.most);
  return all;
}

std::vector<Diagnostic> describe_intersections(std::span<const TriangleIntersection> intersections,
                                               const TriangleOrigin& origin) {
  // Faces in ascending order, with degenerate triangles told apart from a face that crosses itself.
  std::map<std::tuple<std::uint32_t, std::uint32_t, bool>, std::vector<const TriangleIntersection*>> groups;
  for (const TriangleIntersection& item : intersections) {
    const auto [low, high] = std::minmax(origin.tri_to_face[item.first], origin.tri_to_face[item.second]);
    groups[{low, high, item.kind == IntersectionKind::Degenerate}].push_back(&item);
  }
  std::vector<std::pair<std::size_t, Diagnostic>> told;
  for (const auto& [faces, group] : groups) told.emplace_back(group.size(), describe_group(group, origin));
  std::stable_sort(told.begin(), told.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Diagnostic> diagnostics;
  for (auto& [count, diagnostic] : told) diagnostics.push_back(std::move(diagnostic));
  return diagnostics;
}

}  // namespace tetloom
