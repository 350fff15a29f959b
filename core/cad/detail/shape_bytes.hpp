#pragma once
// Faces and edges of OpenCASCADE as bytes, and back, to the last bit of what they evaluate to. Private to core/cad.
#include <span>
#include <TopoDS_Edge.hxx>
#include <vector>

#include "core/cad/detail/exact_locations.hpp"
#include "core/cad/detail/face_shape.hpp"
#include "tetloom/storage.hpp"

namespace tetloom::cad {

/// The face as it lies without its location, and its edges, without what they are on other faces; `ids` as edges_of
/// says. Thread safety: any number of threads.
Bytes encode_face(const FaceShape& shape, const std::vector<ModelEdgeId>& ids);
/// `is_repeated`: whether the model has the shape in several places (see SharedFacets). Errors: Internal.
FaceShape decode_face(std::span<const std::byte> bytes, const std::vector<ModelEdgeId>& ids,
                      const LocationFactors& place, bool is_repeated);

/// Whether the curve of an edge has a location of its own: then its bytes hold the curve as it stands in the model, and
/// are not those of other edges of the same shape.
bool has_placed_curve(const TopoDS_Edge& edge);
/// The curve in space of an edge without its location. Thread safety: any number of threads.
Bytes encode_edge(const TopoDS_Edge& edge);
TopoDS_Edge decode_edge(std::span<const std::byte> bytes, const LocationFactors& place);

}  // namespace tetloom::cad
