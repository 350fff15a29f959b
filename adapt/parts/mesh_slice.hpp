#pragma once
// What one rank has of the mesh that adaptation starts from.
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "adapt/metric/own_tets.hpp"
#include "adapt/parts/numbers.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/partition.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// The rank's own tets, which have consecutive numbers in the whole mesh, and all tets that touch them; the triangles
/// and pieces of model edges with a vertex of own tets. Ranks have equal numbers of tets. Points and tets ascend in
/// number; those of the points are consecutive over all ranks.
struct MeshSlice {
  Mesh mesh;           ///< with the names and sides of the whole, and the fields that are carried over
  MetricField metric;  ///< at the points
  std::vector<Number> to_vert_number, to_tet_number;
  std::vector<std::uint8_t> is_own;  ///< of every point: own tets have it, so that all tets there are here
  std::size_t begin = 0, end = 0;    ///< own tets
  std::size_t vert_count = 0;        ///< of the whole mesh
  std::vector<Number> first_tets;    ///< number of the first tet of each rank, and one past the last

  std::size_t tet_count() const { return first_tets.back() - first_tets.front(); }  ///< of the whole mesh

  OwnTets own_tets(const SharedWork& work) const;
};

/// Of a mesh that every rank has. `fields`: those that are carried over. Triangles of no tet's vertices are in all
/// slices, for somebody to find fault with. Linear in the whole. Pre: check_mesh, check_metric.
MeshSlice slice_of(const Mesh& mesh, const MetricField& metric, const std::vector<std::string>& fields, int rank,
                   int rank_count);

/// Of a mesh that lies in parts, which is emptied: points are numbered by global id, tets part by part. No rank has
/// more of it than its parts and its slice. `metric`: at the vertices of each part. In SharedWork::together. Errors:
/// InputUnsuitable for other cells than tets, and beyond 2^29 of them for each rank.
MeshSlice slice_of(PartitionedMesh&& mesh, PerPart<MetricField>&& metric, const std::vector<std::string>& fields,
                   const SharedWork& work);

/// A mesh, and the sizes asked for at its points.
struct MeshWithMetric {
  Mesh mesh;
  MetricField metric;
};
/// The whole mesh of slices, on every rank. In together. Errors: OutOfMemory for more tets than one mesh may have.
MeshWithMetric gather_slices(const MeshSlice& slice, const SharedWork& work);
/// The same of parts, which are emptied, with all fields. In together.
MeshWithMetric gather_parts(PartitionedMesh&& mesh, PerPart<MetricField>&& metric, const SharedWork& work);

}  // namespace tetloom::adapt
