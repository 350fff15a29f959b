#pragma once
// What there is at the vertices and tets of a share, found while a rank has its slice of the mesh that was given.
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "adapt/parts/mesh_slice.hpp"
#include "adapt/parts/share.hpp"
#include "adapt/parts/umbrellas.hpp"
#include "tetloom/metric.hpp"

namespace tetloom::adapt {

/// What a rank knows of the vertices of its share as the mesh was given.
struct ShareVerts {
  std::vector<Number> to_given;  ///< in the mesh that was given; those that umbrellas made of one have the same
  bool has_metric = false;       ///< the same on all ranks
  std::vector<Tensor> logs;      ///< of the metric; none where there is none
  std::vector<Tensor> implied;   ///< logarithms; see ImpliedMetric
  std::size_t components = 0;    ///< of all fields on points that are carried over
  std::vector<double> fields;    ///< their values, all components of a vertex side by side
  std::vector<Number> to_start;  ///< a tet that has the vertex
};

/// The same at its tets.
struct ShareCells {
  std::size_t components = 0;  ///< of all fields on tets that are carried over
  bool has_slopes = false;
  std::vector<double> values;  ///< all components of a tet side by side
  std::vector<Vec3> slopes;    ///< as of limited_slopes; none where tets have constants
};

/// Of each vertex the first of the tets that have it, by number; kNone without any. `to_vert`: 4 per tet.
std::vector<std::uint32_t> first_tets_of(std::span<const std::uint32_t> to_vert, std::size_t vert_count);

/// What is known at the vertices of a slice before umbrellas have vertices of their own.
struct SliceVerts {
  std::vector<Tensor> implied;
  std::vector<std::uint32_t> starts;  ///< places of tets in the slice
};

/// At the vertices of the share that a slice has become. `fields`: names of the slice's, in the order wanted.
ShareVerts verts_of_share(const MeshSlice& slice, const SliceVerts& verts, const WholeMesh& share,
                          const ShareLinks& links, const TouchingVerts& touching,
                          const std::vector<std::string>& fields);

}  // namespace tetloom::adapt
