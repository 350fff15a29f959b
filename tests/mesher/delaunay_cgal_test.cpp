// The Delaunay kernel beside that of CGAL, whose predicates are exact, too.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>

#include "tests/mesher/delaunay_oracle.hpp"

using namespace tetloom;
using namespace tetloom::tets::oracle_tests;

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangulation = CGAL::Delaunay_triangulation_3<
    Kernel, CGAL::Triangulation_data_structure_3<CGAL::Triangulation_vertex_base_with_info_3<std::uint32_t, Kernel>,
                                                 CGAL::Delaunay_triangulation_cell_base_3<Kernel>>>;

Point point_of(const Vec3& p) { return {p.x, p.y, p.z}; }

Tetrahedralisation by_cgal(const std::vector<Vec3>& points) {
  std::vector<std::pair<Point, std::uint32_t>> numbered;
  for (std::uint32_t v = 0; v < points.size(); ++v) numbered.emplace_back(point_of(points[v]), v);
  const Triangulation made(numbered.begin(), numbered.end());
  std::vector<Tet> tets;
  for (const auto cell : made.finite_cell_handles())
    tets.push_back(
        {cell->vertex(0)->info(), cell->vertex(1)->info(), cell->vertex(2)->info(), cell->vertex(3)->info()});
  return made_sound(points, std::move(tets));
}

// What CGAL's predicates say of our tets.
std::size_t count_conflicts_by_cgal(const Tetrahedralisation& made) {
  std::size_t conflicts = 0;
  const auto at = [&](std::uint32_t v) { return point_of(made.points[v]); };
  for_each_face(made, [&](const Tet& t, std::uint32_t apex) {
    conflicts +=
        CGAL::side_of_oriented_sphere(at(t[0]), at(t[1]), at(t[2]), at(t[3]), at(apex)) == CGAL::ON_POSITIVE_SIDE;
  });
  for (const Tet& t : made.tets)
    conflicts += CGAL::orientation(at(t[0]), at(t[1]), at(t[2]), at(t[3])) != CGAL::POSITIVE;
  return conflicts;
}

}  // namespace

TEST_CASE("tetrahedra are those of CGAL where there is but one Delaunay tetrahedralisation, else both are one") {
  for (const PointSet& set : point_sets()) {
    INFO(set.name);
    const Tetrahedralisation ours = our_own(set.points);
    CHECK(count_conflicts_by_cgal(ours) == 0);
    check_agreement(set, ours, by_cgal(ours.points));
  }
}
