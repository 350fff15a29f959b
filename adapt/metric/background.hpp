#pragma once
// The mesh that adaptation starts from, kept as it was: where the metric and the solution are looked up while the mesh
// changes.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/metric/background_place.hpp"
#include "adapt/metric/background_tiles.hpp"
#include "adapt/metric/boundary_tree.hpp"
#include "adapt/metric/start_grid.hpp"
#include "adapt/metric/tet_links.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// A copy of the tets, points and metrics of a mesh, or what a rank has of one in tiles. Immutable after construction,
/// so any number of threads may ask.
///
/// A point outside of the mesh, such as one on a curved surface of which the mesh has the chords, stands for the
/// nearest point of the boundary. About 90 bytes per tet.
class BackgroundMesh {
 public:
  /// Pre: at least one tet, all of positive volume; indices in range; one metric per point, or none, and fewer than
  /// 2^30 tets. Errors: Cancelled.
  BackgroundMesh(const TetView& mesh, MetricField metric, const TaskRunner& runner);
  /// The same where the links of the tets are known; see link_tets.
  BackgroundMesh(const TetView& mesh, std::vector<FaceCode> links, MetricField metric, const TaskRunner& runner);
  /// The same, of arrays that it takes over.
  BackgroundMesh(std::vector<Vec3>&& points, std::vector<TetVerts>&& tets, std::vector<FaceCode>&& links,
                 MetricField&& metric, const TaskRunner& runner);

  /// The mesh that lies in `tiles`, to which this refers. Then `mesh`, `links` and `metric` are empty, tets are named
  /// as there, and what is asked for may throw MissingTile. Hints must not be kNoTet.
  explicit BackgroundMesh(const BackgroundTiles& tiles) : tiles_(&tiles) {}

  TetView mesh() const { return {points_, tets_}; }
  const MetricField& metric() const { return metric_; }
  /// See link_tets.
  std::span<const FaceCode> links() const { return links_; }
  /// The same face of the tet behind it, not valid where there is none.
  BackgroundFace behind(BackgroundFace face) const {
    if (tiles_) return tiles_->behind(face);
    const FaceCode behind = links_[face.tet() * 4 + face.side()];
    return behind.valid() ? BackgroundFace{behind.tet(), behind.side()} : BackgroundFace();
  }

  /// The tet that holds x, and where: by a walk from the tet `hint`, or from one near x when that is kNoTet. A good
  /// hint is the tet of a point near by, which costs some 0.1 µs; without one it takes about 1 µs, and outside of the
  /// mesh 1 or 2 more. Where x lies on a face or outside, the hint may decide between tets that all hold the nearest
  /// point. Always returns a place. Pre: x is finite, hint is kNoTet or a tet.
  BackgroundPlace locate(const Vec3& x, BackgroundTet hint = kNoTet) const;
  /// Places of many points, each with that of the point before as its hint, block by block.
  std::vector<BackgroundPlace> locate(std::span<const Vec3> points, const BlockLoop& loop = serial_loop()) const;

  /// The logarithm of the metric there: the mean of those of the corners. Pre: there is a metric.
  Tensor log_metric_at(const BackgroundPlace& place) const {
    return tiles_ ? tiles_->log_metric_at(place) : mean_of_corners(metric_.logs, place, tets_[place.tet]);
  }
  /// The same of `implied`, one tensor per point of this mesh; of tiles that of theirs.
  Tensor implied_log_at(const BackgroundPlace& place, std::span<const Tensor> implied) const {
    return tiles_ ? tiles_->implied_log_at(place) : mean_of_corners(implied, place, tets_[place.tet]);
  }

  /// The value of component `c` of a point field there. Linear fields are exact inside the mesh.
  double value_at(const MeshField& field, int c, const BackgroundPlace& place) const {
    const auto n = static_cast<std::size_t>(field.components);
    const TetVerts& tet = tets_[place.tet];
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
      sum += place.weights[i] * field.values[tet[i] * n + static_cast<std::size_t>(c)];
    return sum;
  }

 private:
  std::vector<Vec3> points_;
  std::vector<TetVerts> tets_;
  std::vector<FaceCode> links_;  ///< see link_tets
  MetricField metric_;
  BoundaryTree boundary_;
  StartGrid grid_;
  const BackgroundTiles* tiles_ = nullptr;
};

}  // namespace tetloom::adapt
