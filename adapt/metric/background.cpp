#include "adapt/metric/background.hpp"

#include <cmath>

#include "adapt/metric/background_search.hpp"
#include "core/base/grain.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

// The arrays of a background mesh, for the search.
struct WholeSource {
  TetView mesh;
  std::span<const FaceCode> links;
  const BoundaryTree& boundary;

  std::size_t tet_count() const { return mesh.tets.size(); }
  std::array<Vec3, 4> corners(BackgroundTet tet) const {
    const TetVerts& v = mesh.tets[tet];
    return {mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]};
  }
  BackgroundFace behind(BackgroundFace face) const { return face_of(links[face.tet() * 4 + face.side()]); }
  std::uint64_t number(BackgroundTet tet) const { return tet; }
  NearestOnBoundary nearest(const Vec3& x) const {
    const BoundaryTree::Nearest nearest = boundary.find_nearest(mesh, x, HUGE_VAL);
    return {face_of(nearest.face), nearest.point};
  }

 private:
  static BackgroundFace face_of(FaceCode face) {
    return face.valid() ? BackgroundFace{face.tet(), face.side()} : BackgroundFace();
  }
};

}  // namespace

BackgroundMesh::BackgroundMesh(const TetView& mesh, MetricField metric, const TaskRunner& runner)
    : BackgroundMesh(mesh, link_tets(mesh, runner), std::move(metric), runner) {}

BackgroundMesh::BackgroundMesh(const TetView& mesh, std::vector<FaceCode> links, MetricField metric,
                               const TaskRunner& runner)
    : BackgroundMesh(std::vector<Vec3>(mesh.points.begin(), mesh.points.end()),
                     std::vector<TetVerts>(mesh.tets.begin(), mesh.tets.end()), std::move(links), std::move(metric),
                     runner) {}

BackgroundMesh::BackgroundMesh(std::vector<Vec3>&& points, std::vector<TetVerts>&& tets, std::vector<FaceCode>&& links,
                               MetricField&& metric, const TaskRunner& runner)
    : points_(std::move(points)), tets_(std::move(tets)), links_(std::move(links)), metric_(std::move(metric)) {
  TETLOOM_ASSERT(!tets_.empty() && (metric_.size() == points_.size() || metric_.size() == 0));
  std::vector<FaceCode> open;
  for (const FaceCode face : tets::FaceRange(0, tets_.size()))
    if (!links_[face.index()].valid()) open.push_back(face);
  boundary_ = BoundaryTree(this->mesh(), std::move(open), runner);
  grid_ = StartGrid(this->mesh());
}

BackgroundPlace BackgroundMesh::locate(const Vec3& x, BackgroundTet hint) const {
  if (tiles_) return BackgroundSearch(*tiles_).locate(x, hint);
  TETLOOM_DEBUG_ASSERT(is_finite(x) && (hint == kNoTet || hint < tets_.size()));
  const WholeSource source{mesh(), links_, boundary_};
  return BackgroundSearch(source).locate(x, hint == kNoTet ? grid_.tet_near(x) : hint);
}

std::vector<BackgroundPlace> BackgroundMesh::locate(std::span<const Vec3> points, const BlockLoop& loop) const {
  std::vector<BackgroundPlace> places(points.size());
  loop.for_blocks(points.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    BackgroundTet hint = kNoTet;
    for (std::size_t i = begin; i < end; ++i) {
      places[i] = locate(points[i], hint);
      hint = places[i].tet;
    }
  });
  return places;
}

}  // namespace tetloom::adapt
