#pragma once
// The mesh of everything: layers, and what fills the rest.
#include "mesher/layers/grow_layers.hpp"
#include "tetloom/layers.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// Adds the layers to `filled`, which is the growth's surface with tets above it. `given` is the mesh on which the
/// layers were grown; its entities and sides are taken over. Points that nothing has are left out. The cell fields
/// kLayerField (from 1, 0 elsewhere), kHeightField (of the layer, model length) and kStackField are added. With
/// `all_tets`, prisms and pyramids become tets: of a quadrilateral, the diagonal starts at the curve of lower number.
/// Errors: Cancelled, OutOfMemory.
Mesh make_layered_mesh(const LayerGrowth& growth, const Mesh& given, Mesh&& filled, bool all_tets,
                       const TaskRunner& runner);

/// What became of the layers. Seconds are left out. Errors: Cancelled.
LayerFigures measure_layers(const LayerGrowth& growth, const Mesh& given, const TaskRunner& runner);

}  // namespace tetloom::layers
