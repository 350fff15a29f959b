// Triangle surfaces with the troubles of scans and exports.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mesher/intersection/self_intersection.hpp"
#include "tests/support/families/facets.hpp"
#include "tests/support/families/families.hpp"
#include "tests/support/families/shapes.hpp"
#include "tetloom/tasks.hpp"

#include <BRep_Tool.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <Poly_Triangulation.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS.hxx>

namespace tetloom::test {
namespace {

int random_cells(Random& random, FamilyScale scale) {
  return scale == FamilyScale::Full ? static_cast<int>(random.log_uniform(12, 400)) : random.integer(10, 16);
}

/// Of a closed surface, which is rounded to what files of facets hold. It is sound where it does not cross itself.
FamilyModel facet_model(FacetSurface& surface, const std::string& what) {
  for (Vec3& point : surface.points)
    for (int axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(point[axis]);
  FamilyModel model;
  model.what = std::to_string(surface.triangles.size()) + " facets" + what;
  model.volume = enclosed_volume(surface);
  const IntersectionSearch search{surface.points, surface.triangles, {}, 1};
  model.sound = find_self_intersections(search, TaskRunner(1)).empty();
  model.relative_size = .04, model.curvature = 0;  // the grid's facets turn everywhere
  return model;
}

/// A side of a box, cut into rows and columns: `origin` and the edges `along` and `up`, whose product points outwards.
void add_side(FacetSurface& surface, const Vec3& origin, const Vec3& along, const Vec3& up, Random& random) {
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  const auto columns = static_cast<std::uint32_t>(random.integer(1, 6)),
             rows = static_cast<std::uint32_t>(random.integer(1, 6));
  for (std::uint32_t row = 0; row <= rows; ++row)
    for (std::uint32_t column = 0; column <= columns; ++column)
      surface.points.push_back(origin + static_cast<double>(column) / columns * along +
                               static_cast<double>(row) / rows * up);
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t column = 0; column < columns; ++column) {
      const std::uint32_t a = first + row * (columns + 1) + column, b = a + 1, c = b + columns + 1, d = c - 1;
      surface.triangles.push_back({a, b, c});
      surface.triangles.push_back({a, c, d});
    }
}

/// Turns all points about an axis, so that points on an edge are so only up to rounding.
void turn(FacetSurface& surface, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  for (Vec3& p : surface.points) {
    p = {c * p.x - s * p.y, s * p.x + c * p.y, p.z};
    p = {p.x, c * p.y - s * p.z, s * p.y + c * p.z};
  }
}

/// Each facet has its own points, as OpenCASCADE's triangulation of single faces has.
void add_face(FacetSurface& surface, const TopoDS_Face& face) {
  TopLoc_Location place;
  const Handle(Poly_Triangulation) triangulation = BRep_Tool::Triangulation(face, place);
  if (triangulation.IsNull()) throw std::runtime_error("a face without triangles");
  const auto first = static_cast<std::uint32_t>(surface.points.size());
  for (int i = 1; i <= triangulation->NbNodes(); ++i) {
    const gp_Pnt p = triangulation->Node(i).Transformed(place.Transformation());
    surface.points.push_back({p.X(), p.Y(), p.Z()});
  }
  for (int i = 1; i <= triangulation->NbTriangles(); ++i) {
    int a = 0, b = 0, c = 0;
    triangulation->Triangle(i).Get(a, b, c);
    if (face.Orientation() == TopAbs_REVERSED) std::swap(b, c);
    const auto corner = [&](int node) { return first + static_cast<std::uint32_t>(node - 1); };
    surface.triangles.push_back({corner(a), corner(b), corner(c)});
  }
}

}  // namespace

FamilyModel make_blobs(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(12, seed);
  FacetSurface surface = random_blob(random, random_cells(random, scale));
  FamilyModel model = facet_model(surface, "");
  write_facets(surface, random, folder, model);
  return model;
}

FamilyModel make_noisy_blobs(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(13, seed);
  const int cells = random_cells(random, scale);
  FacetSurface surface = random_blob(random, cells);
  const double share = random.log_uniform(1e-6, .1);
  for (Vec3& point : surface.points) point = point + 20 * share / cells * random.direction();
  FamilyModel model = facet_model(surface, labelled(", noise / cell", share));
  write_facets(surface, random, folder, model);
  return model;
}

FamilyModel make_t_junctions(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(14, seed);
  const Vec3 a{random.uniform(5, 20), 0, 0}, b{0, random.uniform(5, 20), 0}, c{0, 0, random.uniform(5, 20)}, o{};
  FacetSurface surface;
  add_side(surface, o, b, a, random), add_side(surface, c, a, b, random);
  add_side(surface, o, a, c, random), add_side(surface, b, c, a, random);
  add_side(surface, o, c, b, random), add_side(surface, a, b, c, random);
  const bool turned = random.chance(.5);
  if (turned) turn(surface, random.uniform(.1, 1));
  FamilyModel model = facet_model(surface, turned ? ", turned" : "");
  model.volume = a.x * b.y * c.z;
  model.sound = true;
  write_facets(surface, random, folder, model);
  return model;
}

FamilyModel make_holes(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(15, seed);
  FacetSurface surface = random_blob(random, random_cells(random, scale));
  FamilyModel model = facet_model(surface, "");
  const int holes = random.integer(1, 8);
  for (int i = 0; i < holes; ++i)
    surface.triangles.erase(surface.triangles.begin() +
                            random.integer(0, static_cast<int>(surface.triangles.size()) - 1));
  model.what += ", " + std::to_string(holes) + " of them gone";
  model.sound = false;
  write_facets(surface, random, folder, model);
  return model;
}

FamilyModel make_dirt(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(16, seed);
  FacetSurface surface = random_blob(random, random_cells(random, scale));
  FamilyModel model = facet_model(surface, ", some twice, turned or flat");
  const std::size_t count = surface.triangles.size();
  const double turned = random.uniform(0, .3), twice = random.log_uniform(1e-3, .2),
               flat = random.log_uniform(1e-3, .2);
  for (std::size_t t = 0; t < count; ++t) {
    auto& [a, b, c] = surface.triangles[t];
    if (random.chance(turned)) std::swap(b, c);
    if (random.chance(twice)) surface.triangles.push_back(surface.triangles[t]);
    if (random.chance(flat))
      surface.triangles.push_back({surface.triangles[t][0], surface.triangles[t][1], surface.triangles[t][1]});
  }
  write_facets(surface, random, folder, model);
  return model;
}

FamilyModel make_exports(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(17, seed);
  const TopoDS_Shape part = part_with_hole(random, 20);
  const double chord = random.log_uniform(.002, .5);
  BRepMesh_IncrementalMesh(part, chord, false, .5);
  FacetSurface surface;
  for (const TopoDS_Shape& face : faces_of(part)) add_face(surface, TopoDS::Face(face));
  FamilyModel model = facet_model(surface, labelled(", chord", chord));
  model.sound = true;  // faces share no points here, and so they touch
  write_facets(surface, random, folder, model);
  return model;
}

}  // namespace tetloom::test
