#pragma once
// How large a mesh will be, known before it is made.
#include <vector>

#include "core/sizing/memory_check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

class FacetTree;

/// Triangles from the faces' areas and the sizes on them (4/√3 per size²), tetrahedra from the regions' volumes and
/// the sizes in them (kTetsPerCube per size³), bytes from 800 per triangle and 65 per tetrahedron. Within a few
/// percent for uniform sizes; graded sizes are integrated over samples, which is good to about a tenth.
MeshEstimate estimate_mesh(const GeometricModel& model, const SizeField& sizes, const SharedWork& work);

/// The same with facets of all faces at hand.
MeshEstimate estimate_mesh(const GeometricModel& model, const SizeField& sizes, const std::vector<Tessellation>& facets,
                           const FacetTree& tree, const SharedWork& work);

/// A lower bound from the global size and the sizes of faces and regions alone, before anything is built, so that it
/// can refuse sizes that would already fill the memory with their own size field.
/// Errors: InvalidArgument, InputUnsuitable (as build_size_field).
MeshEstimate estimate_least_mesh(const GeometricModel& model, const SizeOptions& options);

/// Tets of a mesh that fills volumes: a wall thinner than the size has one and a half per triangle.
double count_elements(const MeshEstimate& estimate);

/// Leaves the tetrahedra out, for a run that makes the surface only.
MeshEstimate surface_part(const MeshEstimate& estimate);

}  // namespace tetloom
