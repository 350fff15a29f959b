#include "mesher/layers/fan_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/disjoint_sets.hpp"
#include "mesher/layers/growth_direction.hpp"
#include "mesher/layers/spherical_polygon.hpp"

namespace tetloom::layers {
namespace {

constexpr double kMostStep = 100 * std::numbers::pi / 180;  // between neighbouring curves
constexpr double kSeen = 0.5;                               // visibility of triangles between two sharp edges
constexpr std::size_t kLeastRun = 4;                        // vertices of fans that follow each other
constexpr double kLeastClosure = 0.15;                      // of a corner's tets: the product of three directions

Vec3 rotated(const Vec3& normal, const Vec3& axis, double angle) {
  return std::cos(angle) * normal + std::sin(angle) * cross(axis, normal);
}

}  // namespace

FanPlan::FanPlan(const WallEdges& edges, double turn, std::span<const std::uint32_t> blunt_verts)
    : edges_(edges), turn_(turn), corner_to_ring_(edges.across.size(), kNone) {
  find_turns();
  find_rings();
  find_steps();
  for (Ring& ring : rings_)
    if (!std::ranges::binary_search(blunt_verts, vertex(ring.corners[0]))) judge(ring);
  drop_short_runs();
}

// At rims of sheets, both sides of one triangle meet.
void FanPlan::find_turns() {
  for (const WallTriangle& wall : edges_.triangles) {
    const auto& [a, b, c] = wall.verts;
    normals_.push_back(normalized(cross(edges_.points[b] - edges_.points[a], edges_.points[c] - edges_.points[a])));
  }
  turns_.assign(edges_.across.size(), 0);
  for (std::uint32_t e = 0; e < turns_.size(); ++e) {
    if (edges_.across[e] == kNone) continue;
    const std::uint32_t here = e / 3, there = edges_.across[e] / 3;
    const Vec3 along = normalized(edges_.points[vertex(next_corner(e))] - edges_.points[vertex(e)]);
    turns_[e] = std::atan2(dot(cross(normals_[here], normals_[there]), along), dot(normals_[here], normals_[there]));
    if (edges_.triangles[here].triangle == edges_.triangles[there].triangle) turns_[e] = std::numbers::pi;
  }
}

void FanPlan::find_rings() {
  for (std::uint32_t e = 0; e < turns_.size(); ++e)
    if (is_sharp(e)) {
      if (corner_to_ring_[next_corner(e)] == kNone) walk(next_corner(e));
      if (corner_to_ring_[edges_.across[e]] == kNone) walk(edges_.across[e]);
    }
}

// Counter-clockwise around the vertex, and back to the first corner or up to the end of the walls.
void FanPlan::walk(std::uint32_t corner) {
  Ring ring;
  const auto number = static_cast<std::uint32_t>(rings_.size());
  std::uint32_t at = corner;
  do {
    ring.corners.push_back(at);
    corner_to_ring_[at] = number;
    const std::uint32_t crossing = last_corner(at);
    if (is_sharp(crossing)) ring.crossings.push_back(crossing);
    at = edges_.across[crossing];
  } while (at != kNone && at != corner);
  ring.is_closed = at == corner;
  rings_.push_back(std::move(ring));
}

// As many elements on all edges of a line that runs on from edge to edge.
void FanPlan::find_steps() {
  DisjointSets lines(edges_.across.size());
  for (std::uint32_t e = 0; e < turns_.size(); ++e)
    if (is_sharp(e)) lines.join(e, edges_.across[e]);
  for (const Ring& ring : rings_)
    if (ring.crossings.size() == 2) lines.join(ring.crossings[0], ring.crossings[1]);
  std::vector<double> most(turns_.size(), 0);
  for (std::uint32_t e = 0; e < turns_.size(); ++e) most[lines.find(e)] = std::max(most[lines.find(e)], turns_[e]);
  steps_.assign(turns_.size(), 0);
  for (std::uint32_t e = 0; e < turns_.size(); ++e)
    if (is_sharp(e)) steps_[e] = static_cast<std::uint8_t>(std::ceil(most[lines.find(e)] / kMostStep));
}

// Between the sides of an edge, from that of its own triangle on.
std::vector<Vec3> FanPlan::directions_between(std::uint32_t crossing) const {
  const Vec3 along = normalized(edges_.points[vertex(next_corner(crossing))] - edges_.points[vertex(crossing)]);
  std::vector<Vec3> between;
  for (int i = 1; i < steps_[crossing]; ++i)
    between.push_back(rotated(normals_[crossing / 3], along, turns_[crossing] * i / steps_[crossing]));
  return between;
}

// Per crossing. Where a line runs on, those of both of its edges are the same, in the opposite order.
std::vector<std::vector<Vec3>> FanPlan::middle_directions(const Ring& ring) const {
  std::vector<std::vector<Vec3>> middle;
  for (const std::uint32_t crossing : ring.crossings) middle.push_back(directions_between(crossing));
  if (middle.size() != 2) return middle;
  for (std::size_t i = 0; i < middle[0].size(); ++i) {
    Vec3 &one = middle[0][i], &other = middle[1][middle[0].size() - 1 - i];
    one = other = normalized(one + other);
  }
  return middle;
}

void FanPlan::judge(Ring& ring) {
  if (!ring.is_closed || ring.crossings.size() < 2) return;
  // From the triangle behind the first crossing on.
  std::ranges::rotate(ring.corners, std::ranges::find(ring.corners, edges_.across[ring.crossings[0]]));
  std::ranges::rotate(ring.crossings, ring.crossings.begin() + 1);
  std::vector<Vec3> groups, normals;
  for (const std::uint32_t corner : ring.corners) {
    normals.push_back(normals_[corner / 3]);
    if (!is_sharp(last_corner(corner))) continue;
    const GrowthDirection direction = most_normal_direction(normals);
    if (direction.visibility < kSeen) return;
    groups.push_back(direction.direction);
    normals.clear();
  }
  ring.is_fan = ring.crossings.size() == 2 || find_closure(ring, groups);
}

bool FanPlan::find_closure(Ring& ring, const std::vector<Vec3>& groups) {
  const std::vector<std::vector<Vec3>> middle = middle_directions(ring);
  std::vector<Vec3> nodes;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    nodes.push_back(groups[i]);
    nodes.insert(nodes.end(), middle[i].begin(), middle[i].end());
  }
  const SphericalTriangulation found = triangulate_on_sphere(nodes);
  ring.closure = found.triangles;
  return found.least >= kLeastClosure;
}

// The ends of a fan have poorer cells than there would be without it.
void FanPlan::drop_short_runs() {
  DisjointSets runs(rings_.size());
  for (std::uint32_t e = 0; e < turns_.size(); ++e) {
    if (!is_sharp(e)) continue;
    const std::uint32_t start = corner_to_ring_[e], end = corner_to_ring_[next_corner(e)];
    if (rings_[start].is_fan && rings_[end].is_fan) runs.join(start, end);
  }
  std::vector<std::size_t> length(rings_.size(), 0);
  for (std::uint32_t r = 0; r < rings_.size(); ++r) ++length[runs.find(r)];
  for (std::uint32_t r = 0; r < rings_.size(); ++r)
    rings_[r].is_fan = rings_[r].is_fan && length[runs.find(r)] >= kLeastRun;
}

bool FanPlan::parts_at_start(std::uint32_t edge) const {
  return is_sharp(edge) && rings_[corner_to_ring_[edge]].is_fan;
}

void FanPlan::add_to(Walls& walls) const {
  walls.curve_to_direction.assign(walls.curve_count(), {});
  walls.curve_is_late.assign(walls.curve_count(), 0);
  walls.curve_to_fan_vertex.assign(walls.curve_count(), kNone);
  Chains chains(turns_.size());
  for (const Ring& ring : rings_) add_curves(ring, walls, chains);
  for (const Ring& ring : rings_) add_corners(ring, walls, chains);
  for (std::uint32_t e = 0; e < turns_.size(); ++e)
    if (is_sharp(e) && e < edges_.across[e]) add_elements(e, walls, chains);
  std::ranges::sort(walls.blunt_verts);
}

void FanPlan::add_curves(const Ring& ring, Walls& walls, Chains& chains) const {
  const auto curve_at = [&](std::uint32_t corner) { return walls.triangles[corner / 3].curves[corner % 3]; };
  if (!ring.is_fan) {
    walls.blunt_verts.push_back(vertex(ring.corners[0]));
    for (const std::uint32_t crossing : ring.crossings) chains[crossing] = {curve_at(next_corner(crossing))};
    return;
  }
  const std::vector<std::vector<Vec3>> middle = middle_directions(ring);
  const bool runs_on = ring.crossings.size() == 2;
  FanVertex fan;
  for (const std::uint32_t crossing : ring.crossings) fan.curves.push_back(curve_at(next_corner(crossing)));
  for (std::size_t i = 0; i < ring.crossings.size(); ++i) {
    std::vector<std::uint32_t>& chain = chains[ring.crossings[i]];
    chain.push_back(curve_at(next_corner(ring.crossings[i])));
    if (runs_on && i == 1) {
      const auto& first = chains[ring.crossings[0]];
      chain.insert(chain.end(), first.rbegin() + 1, first.rend() - 1);
    } else {
      for (const Vec3& direction : middle[i]) {
        chain.push_back(static_cast<std::uint32_t>(walls.curve_count()));
        fan.curves.push_back(chain.back());
        walls.curve_to_vert.push_back(vertex(ring.corners[0]));
        walls.curve_to_direction.push_back(direction);
        walls.curve_is_late.push_back(0);
        walls.curve_to_fan_vertex.push_back(kNone);
      }
    }
    chain.push_back(curve_at(edges_.across[ring.crossings[i]]));
  }
  for (const std::uint32_t c : fan.curves)
    walls.curve_to_fan_vertex[c] = static_cast<std::uint32_t>(walls.fan_vertices.size());
  walls.fan_vertices.push_back(std::move(fan));
}

// Nodes are the curves of all chains but their last ones.
void FanPlan::add_corners(const Ring& ring, Walls& walls, const Chains& chains) const {
  std::vector<std::uint32_t> nodes;
  for (const std::uint32_t crossing : ring.crossings)
    nodes.insert(nodes.end(), chains[crossing].begin(), chains[crossing].end() - 1);
  if (!ring.is_fan) return;
  for (const auto& [i, j, k] : ring.closure)
    walls.fans.push_back({FanElement::Kind::Corner, {nodes[i], nodes[j], nodes[k], kNone}, ring.corners[0] / 3});
}

void FanPlan::add_elements(std::uint32_t edge, Walls& walls, const Chains& chains) const {
  const std::uint32_t wall = edge / 3;
  const auto& end = chains[edge];
  const std::vector<std::uint32_t> start(chains[edges_.across[edge]].rbegin(), chains[edges_.across[edge]].rend());
  if (start.size() == 1 && end.size() == 1) return;
  if (start.size() == 1) walls.curve_is_late[start[0]] = 1;
  if (end.size() == 1) walls.curve_is_late[end[0]] = 1;
  for (std::size_t i = 0; i + 1 < std::max(start.size(), end.size()); ++i) {
    if (start.size() == 1) {
      walls.fans.push_back({FanElement::Kind::End, {start[0], end[i + 1], end[i], kNone}, wall});
    } else if (end.size() == 1) {
      walls.fans.push_back({FanElement::Kind::End, {end[0], start[i], start[i + 1], kNone}, wall});
    } else {
      walls.fans.push_back({FanElement::Kind::Quad, {start[i], start[i + 1], end[i + 1], end[i]}, wall});
    }
  }
}

}  // namespace tetloom::layers
