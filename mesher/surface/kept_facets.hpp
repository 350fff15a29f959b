#pragma once
// Places at which a surface of facets is meshed by its own facets: these cross nowhere, whatever the size is.
#include <span>
#include <vector>

#include "mesher/surface/edge_mesher.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// A ball in which the surface stays as given.
struct KeptPlace {
  Vec3 center;
  double radius = 0;
};

/// Balls in which faces without a plane keep their facets, and edges the ends of those as nodes.
class KeptFacets {
 public:
  bool empty() const { return places_.empty(); }
  /// A ball around a center that lies well inside a known one as large is not taken. Returns whether it was.
  bool add(const KeptPlace& place);
  bool holds(const Vec3& x) const;
  std::span<const KeptPlace> places() const { return places_; }

  /// Gives edges of such faces the ends of facets as nodes, inside of the balls. Nodes that are nearer to these than
  /// a third of the distance between nodes go. Linear in the facets of the faces that have edges there, and the balls.
  void put_on_edges(const GeometricModel& model, std::vector<EdgeMesh>& edges) const;

 private:
  std::vector<KeptPlace> places_;
};

}  // namespace tetloom
