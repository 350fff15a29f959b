#include "mesher/tets/acute_tets.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "core/spatial/distances.hpp"
#include "core/spatial/triangle_shape.hpp"
#include "core/tets/dihedral.hpp"
#include "core/tets/many_values.hpp"
#include "core/tets/triangle_verts.hpp"
#include "core/tets/working_mesh.hpp"
#include "mesher/intersection/triangle_tree.hpp"

namespace tetloom {

void keep_worst(std::vector<AcuteTet>& tets) {
  const auto key = [](const AcuteTet& tet) { return std::tie(tet.angle, tet.point.x, tet.point.y, tet.point.z); };
  std::ranges::stable_sort(tets, [&](const AcuteTet& a, const AcuteTet& b) { return key(a) < key(b); });
  if (tets.size() > kMostAcuteTets) tets.resize(kMostAcuteTets);
}

}  // namespace tetloom

namespace tetloom::tets {

namespace {

constexpr double kRegularAngle = 1.2309594173407747;  // arccos(1/3)
constexpr double kPoorTriangle = 0.5;
constexpr double kShortEdge = 1.0 / 3;
constexpr double kSlant = 0.7;            // height over distance below which points count as askew
constexpr std::size_t kMostBeside = 200;  // tets beside one that are looked at

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

double smallest_angle(const std::array<Vec3, 3>& corners) {
  double largest_cosine = -1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 &a = corners[i], &b = corners[(i + 1) % 3], &c = corners[(i + 2) % 3];
    largest_cosine = std::max(largest_cosine, dot(normalized(b - a), normalized(c - a)));
  }
  return std::acos(std::min(largest_cosine, 1.0));
}

// What forces the angle of one tet.
class CauseFinder {
 public:
  CauseFinder(const WorkingMesh& mesh, std::uint32_t tet, const Dihedral& dihedral, double least_wanted)
      : mesh_(mesh), tet_(tet), dihedral_(dihedral), least_wanted_(least_wanted) {}

  AcuteTet find() {
    found_.angle = degrees(dihedral_.angle);
    for (const std::uint32_t v : mesh_.verts(tet_)) found_.point += 0.25 * mesh_.point(v);
    if (!find_surface_angle() && !find_triangle() && !find_close_points()) find_narrow_region();
    return found_;
  }

 private:
  bool find_surface_angle() {
    double angle = dihedral_.angle;
    const FaceCode one = turn({tet_, dihedral_.face}, angle);
    const FaceCode other = one.valid() ? turn({tet_, dihedral_.other}, angle) : FaceCode();
    if (!other.valid() || angle >= least_wanted_) return false;
    found_.cause = AngleCause::SurfaceAngle;
    found_.cause_angle = degrees(angle);
    found_.triangles = {verts_of(mesh_.mesh(), one), verts_of(mesh_.mesh(), other)};
    return true;
  }

  // Goes from tet to tet around the edge of the angle, through `out` first, up to a face that has to stay, and adds
  // their angles; not valid when that leads back to the tet.
  FaceCode turn(FaceCode out, double& angle) const {
    const TetMesh& mesh = mesh_.mesh();
    const auto is_of_edge = [&](std::uint32_t vertex) {
      const std::uint32_t corner = mesh_.corner_of(tet_, vertex);
      return mesh_.verts(tet_)[corner] == vertex && corner != dihedral_.face && corner != dihedral_.other;
    };
    while (!mesh.is_fixed(out)) {
      const FaceCode in = mesh.behind(out);
      if (!in.valid() || in.tet() == tet_) return {};
      std::uint32_t corner = 0;
      while (corner == in.side() || is_of_edge(mesh_.verts(in.tet())[corner])) ++corner;
      out = {in.tet(), corner};
      angle += dihedral_between(mesh, in.tet(), in.side(), corner);
    }
    return out;
  }

  bool find_triangle() {
    double least = kPoorTriangle;
    for (const FaceCode face : FaceCode::of(tet_)) {
      if (!mesh_.mesh().is_fixed(face)) continue;
      const TriangleVerts verts = verts_of(mesh_.mesh(), face);
      const std::array corners{mesh_.point(verts[0]), mesh_.point(verts[1]), mesh_.point(verts[2])};
      const double quality = triangle_mean_ratio(corners[0], corners[1], corners[2]);
      if (quality >= least) continue;
      least = quality;
      found_.cause = AngleCause::SurfaceTriangle;
      found_.cause_angle = degrees(smallest_angle(corners));
      found_.triangles = {verts};
    }
    return found_.cause == AngleCause::SurfaceTriangle;
  }

  bool find_close_points() {
    const auto verts = mesh_.verts(tet_);
    double shortest = kShortEdge * longest_edge();
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const double length = distance(mesh_.point(verts[i]), mesh_.point(verts[j]));
        if (length >= shortest || !mesh_.is_fixed_point(verts[i]) || !mesh_.is_fixed_point(verts[j])) continue;
        shortest = length;
        found_.points = {verts[i], verts[j]};
      }
    }
    if (found_.points.empty()) return false;
    set_length(AngleCause::SurfacePoints, shortest);
    find_height(shortest);
    return true;
  }

  // In a wall of one layer, points that are close lie askew on its two sides: it is narrower than they are apart.
  void find_height(double least) {
    const auto verts = mesh_.verts(tet_);
    for (std::uint32_t i = 0; i < 4; ++i) {
      if (!mesh_.mesh().is_fixed({tet_, i}) || !mesh_.is_fixed_point(verts[i])) continue;
      const TriangleVerts t = verts_of(mesh_.mesh(), {tet_, i});
      const Vec3 &x = mesh_.point(t[0]), normal = cross(mesh_.point(t[1]) - x, mesh_.point(t[2]) - x);
      const double height = std::abs(dot(normalized(normal), mesh_.point(verts[i]) - x));
      if (height >= kSlant * least) continue;
      least = height;
      found_.points = {verts[i]};
      found_.triangles = {t};
      set_length(AngleCause::NarrowRegion, height);
    }
  }

  void find_narrow_region() {
    std::vector<std::uint32_t> points;
    std::vector<TriangleVerts> triangles;
    for (const std::uint32_t tet : tets_beside()) {
      for (const std::uint32_t v : mesh_.verts(tet))
        if (mesh_.is_fixed_point(v) && std::ranges::find(points, v) == points.end()) points.push_back(v);
      for (const FaceCode face : FaceCode::of(tet))
        if (mesh_.mesh().is_fixed(face)) triangles.push_back(verts_of(mesh_.mesh(), face));
    }
    double least = kShortEdge * longest_edge();
    for (const TriangleVerts& t : triangles)
      for (const std::uint32_t v : points) {
        if (std::ranges::find(t, v) != t.end()) continue;
        const double apart =
            distance_to_triangle(mesh_.point(v), mesh_.point(t[0]), mesh_.point(t[1]), mesh_.point(t[2]));
        if (apart >= least) continue;
        least = apart;
        found_.points = {v};
        found_.triangles = {t};
      }
    if (!found_.points.empty()) set_length(AngleCause::NarrowRegion, least);
  }

  // The tets that share a vertex with this one, as far as the surface does not lie between; this one first.
  std::vector<std::uint32_t> tets_beside() const {
    std::vector<std::uint32_t> found{tet_};
    const auto own = mesh_.verts(tet_);
    for (std::size_t i = 0; i < found.size() && found.size() < kMostBeside; ++i)
      for (const FaceCode face : FaceCode::of(found[i])) {
        if (mesh_.mesh().is_fixed(face) || !mesh_.mesh().behind(face).valid()) continue;
        const std::uint32_t other = mesh_.mesh().behind(face).tet();
        const auto verts = mesh_.verts(other);
        const bool touches =
            std::ranges::any_of(verts, [&](std::uint32_t v) { return std::ranges::find(own, v) != own.end(); });
        if (touches && std::ranges::find(found, other) == found.end()) found.push_back(other);
      }
    return found;
  }

  double longest_edge() const {
    const auto verts = mesh_.verts(tet_);
    double longest = 0;
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = i + 1; j < 4; ++j)
        longest = std::max(longest, distance(mesh_.point(verts[i]), mesh_.point(verts[j])));
    return longest;
  }

  void set_length(AngleCause cause, double length) {
    found_.cause = cause;
    found_.cause_length = length;
    found_.cause_angle = degrees(std::atan2(length, longest_edge()));
  }

  const WorkingMesh& mesh_;
  std::uint32_t tet_;
  const Dihedral& dihedral_;
  double least_wanted_;
  AcuteTet found_;
};

void count(const AcuteTet& tet, DihedralSummary& summary) {
  ++summary.below;
  summary.angles += tet.cause == AngleCause::SurfaceAngle;
  summary.triangles += tet.cause == AngleCause::SurfaceTriangle;
  summary.points += tet.cause == AngleCause::SurfacePoints || tet.cause == AngleCause::NarrowRegion;
}

}  // namespace

double dihedral_of_worst(const TetMesh& mesh, std::span<const float> qualities) {
  if (qualities.empty()) return kRegularAngle;
  const auto worst = std::find(qualities.begin(), qualities.end(), least_of(qualities));
  if (*worst == WorkingMesh::kDeadQuality) return kRegularAngle;
  return std::min(kRegularAngle, smallest_dihedral(mesh, static_cast<std::uint32_t>(worst - qualities.begin())).angle);
}

DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted) {
  return summarize_dihedrals(mesh, least_wanted, dihedral_of_worst(mesh.mesh(), mesh.qualities()));
}

DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted, double known_least) {
  DihedralSummary summary;
  double bound = 0, cosine = 0;
  const auto look_below = [&](double angle) {
    summary.least = angle;
    bound = largest_quality_with_dihedral(std::max(angle, least_wanted)) * kGain;
    cosine = std::cos(std::max(angle, least_wanted));
  };
  look_below(known_least);
  for (std::uint32_t tet = 0; tet < mesh.qualities().size(); ++tet) {
    if (mesh.quality(tet) > bound || mesh.mesh().is_dead(tet) || !may_be_below(mesh.mesh(), tet, cosine)) continue;
    const Dihedral dihedral = smallest_dihedral(mesh.mesh(), tet);
    if (dihedral.angle < summary.least) look_below(dihedral.angle);
    if (dihedral.angle >= least_wanted) continue;
    mesh.find_fixed_points();
    summary.worst.push_back(CauseFinder(mesh, tet, dihedral, least_wanted).find());
    count(summary.worst.back(), summary);
    if (summary.worst.size() == 10 * kMostAcuteTets) keep_worst(summary.worst);
  }
  keep_worst(summary.worst);
  return summary;
}

}  // namespace tetloom::tets
