#pragma once
// Values on tets as linear functions inside of them.
#include <span>
#include <vector>

#include "adapt/metric/tet_links.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Numbers on tets: `components` for each, one after the other. Non-owning.
struct CellValues {
  std::span<const double> values;
  std::size_t components = 1;
  const double* of(std::size_t tet) const { return values.data() + tet * components; }
};

/// Tets with their links, as of link_tets, and regions, of which those from `begin` to `end` count: all tets at their
/// vertices are there. Non-owning.
struct LinkedTets {
  TetView mesh;
  std::span<const FaceCode> links;
  std::span<const std::uint32_t> regions;
  std::size_t begin = 0, end = 0;
};

/// A gradient per tet that counts and component, of linear functions that have the values of the tets in their centres:
/// by least squares over neighbours across faces and their neighbours, weighted by 1 / distance², in coordinates of the
/// tet so that thin tets are as good as others. Only tets of the same region count.
///
/// A gradient is made smaller until, at every corner of its tet, the function lies between the least and the greatest
/// value of the tets of the region at that corner (as Park, Yoon & Kim 2010 limit it), so no new extremes arise. Linear
/// fields keep their gradient away from the sides of regions. Linear in the number of tets.
std::vector<Vec3> limited_slopes(const LinkedTets& mesh, const CellValues& cells, const BlockLoop& loop);

}  // namespace tetloom::adapt
