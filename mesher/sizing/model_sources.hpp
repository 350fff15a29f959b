#pragma once
// Sources of small sizes on a model: sizes of entities, curvature, proximity. Private to mesher/sizing.
// An entity whose geometry fails gives no sources. All functions run in parallel over entities, which ranks share, and
// what they return depends on the entities' order alone.
#include <vector>

#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/sizing/source_tree.hpp"
#include "tetloom/model.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// How closely each face must be facetted for its sources.
std::vector<FacetTolerance> source_tolerances(const GeometricModel& model, const SizeTargets& targets);

/// Sizes of model vertices, and sizes and curvature of model edges.
std::vector<SizeSource> edge_sources(const GeometricModel& model, const SizeTargets& targets, const SharedWork& work);

/// Sizes (with those of their regions) and curvature of faces.
std::vector<SizeSource> face_sources(const GeometricModel& model, const SizeTargets& targets,
                                     const std::vector<Tessellation>& facets, const SharedWork& work);

/// Where gaps between faces, and walls between them, are thinner than `targets.proximity` times the global size: sizes
/// that fit the asked number of edges in. A gap is seen along the facets' normals, to the first face that is turned
/// towards them within 45 degrees, or within 20 degrees when it is the neighbour across an edge or a vertex: a wedge
/// is no gap. Gaps below a millionth of the model's diagonal are contacts.
std::vector<SizeSource> proximity_sources(const GeometricModel& model, const SizeTargets& targets,
                                          const std::vector<Tessellation>& facets, const FacetTree& tree,
                                          const SharedWork& work);

/// The number of facets of each face, as an estimate of the work on it.
std::vector<double> facet_counts(const std::vector<Tessellation>& facets);

}  // namespace tetloom
