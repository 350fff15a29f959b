#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "tetloom/metric.hpp"

#include <algorithm>

namespace tetloom::adapt {
namespace {

/// The tets of every vertex.
struct Stars {
  std::vector<std::size_t> begins;
  std::vector<std::uint32_t> tets;

  explicit Stars(const TetView& mesh) : begins(mesh.points.size() + 2), tets(mesh.tets.size() * 4) {
    for (const TetVerts& tet : mesh.tets)
      for (const std::uint32_t v : tet) ++begins[v + 2];
    for (std::size_t v = 2; v < begins.size(); ++v) begins[v] += begins[v - 1];
    // begins[v + 1] is where the next tet of v goes, and ends up as the end of v's.
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
      for (const std::uint32_t v : mesh.tets[t]) tets[begins[v + 1]++] = static_cast<std::uint32_t>(t);
  }
};

struct Rows {
  std::vector<std::uint32_t> counts, neighbors;
};

}  // namespace

VertexGraph::VertexGraph(const TetView& mesh, const BlockLoop& loop) {
  const Stars stars(mesh);
  const auto rows = map_blocks(loop, mesh.points.size(), kElementGrain, Rows(),
                               [&](std::size_t begin, std::size_t end, Rows& of_block) {
                                 std::vector<std::uint32_t> found;
                                 for (std::size_t v = begin; v < end; ++v) {
                                   found.clear();
                                   for (std::size_t k = stars.begins[v]; k < stars.begins[v + 1]; ++k)
                                     for (const std::uint32_t w : mesh.tets[stars.tets[k]])
                                       if (w != v) found.push_back(w);
                                   sort_unique(found);
                                   of_block.counts.push_back(static_cast<std::uint32_t>(found.size()));
                                   of_block.neighbors.insert(of_block.neighbors.end(), found.begin(), found.end());
                                 }
                               });
  begins_.reserve(mesh.points.size() + 1);
  begins_.push_back(0);
  for (const Rows& of_block : rows)
    for (const std::uint32_t count : of_block.counts) begins_.push_back(begins_.back() + count);
  neighbors_.reserve(begins_.back());
  for (const Rows& of_block : rows)
    neighbors_.insert(neighbors_.end(), of_block.neighbors.begin(), of_block.neighbors.end());
}

}  // namespace tetloom::adapt
