// The Delaunay kernel beside TetGen's, which runs in its worker.
#include "mesher/volume/worker_process.hpp"
#include "mesher/volume/worker_protocol.hpp"
#include "tests/mesher/delaunay_oracle.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::tets::oracle_tests;

namespace {

Tetrahedralisation by_tetgen(const std::vector<Vec3>& points) {
  const volume::WorkerRequest request{"QJz", points, {}};
  const volume::WorkerRun run = volume::run_worker(TETLOOM_WORKER, volume::encode(request), TaskRunner(1));
  INFO(run.failure);
  REQUIRE(!run.response.empty());
  const volume::WorkerResponse response = volume::decode_response(run.response, points.size());
  INFO(response.message);
  REQUIRE(response.status == volume::WorkerStatus::Filled);
  CHECK(response.new_points.empty());
  return made_sound(points, response.tet_to_vert);
}

}  // namespace

TEST_CASE("tetrahedra are those of TetGen where there is but one Delaunay tetrahedralisation, else both are one") {
  for (const PointSet& set : point_sets()) {
    INFO(set.name);
    const Tetrahedralisation ours = our_own(set.points);
    check_agreement(set, ours, by_tetgen(ours.points));
  }
}
