#pragma once
// Facets of a face by OpenCASCADE's incremental mesher. Private to core/cad.
#include "core/cad/detail/topology.hpp"

namespace tetloom::cad {

/// Works on a copy of the face, because OpenCASCADE writes triangulations into shapes. Where its mesher fails at the
/// fineness asked for, others are tried, finer ones first, then larger angles. Errors: FaceFailed, InvalidArgument.
Tessellation tessellate_face(const ShapeTables& shapes, const ModelTopology& topology, ModelFaceId id, double chord,
                             double angle);

}  // namespace tetloom::cad
