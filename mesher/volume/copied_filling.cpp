#include "mesher/volume/copied_filling.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <utility>

#include "core/base/pairing.hpp"
#include "core/predicates/predicates.hpp"
#include "core/sizing/size_change.hpp"

namespace tetloom::volume {

namespace {

constexpr double kSamePlace = 1e-8;  // of the diagonal of a complex

std::uint64_t number_of(ModelEntity entity) { return std::uint64_t{entity.dim} << 32 | entity.index; }

// An orthonormal frame of three points, in columns; none where they lie on a line.
std::optional<std::array<Vec3, 3>> frame_of(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 first = normalized(b - a), third = normalized(cross(first, c - a));
  if (norm2(third) == 0) return std::nullopt;
  return std::array{first, cross(third, first), third};
}

// The motion that takes points to others; none where there is no such.
std::optional<RigidMotion> find_motion(std::span<const Vec3> from, std::span<const Vec3> to) {
  const Box3 box = box_of(from);
  const auto farthest = [&](const auto& measure) {
    return static_cast<std::size_t>(std::ranges::max_element(from, {}, measure) - from.begin());
  };
  const std::size_t b = farthest([&](const Vec3& p) { return norm2(p - from[0]); });
  const std::size_t c = farthest([&](const Vec3& p) { return norm2(cross(p - from[0], from[b] - from[0])); });
  const auto first = frame_of(from[0], from[b], from[c]), second = frame_of(to[0], to[b], to[c]);
  if (!first || !second) return std::nullopt;
  RigidMotion motion = RigidMotion{*second, {}} * RigidMotion{*first, {}}.inverse();
  motion.shift = to[0] - motion.turned(from[0]);
  const double most = kSamePlace * box.diagonal();
  for (std::size_t i = 0; i < from.size(); ++i)
    if (!(distance(motion(from[i]), to[i]) <= most)) return std::nullopt;
  return motion;
}

class CopyTest {
 public:
  CopyTest(const FillingPlan& plan, const Complex& original, const Complex& complex)
      : plan_(plan), original_(original), complex_(complex) {}

  std::optional<RigidMotion> run() const {
    if (!std::ranges::equal(original_.tri_to_vert, complex_.tri_to_vert) || !have_same_sides() || !have_same_faces())
      return std::nullopt;
    const auto motion = find_motion(original_.points, complex_.points);
    if (!motion || !has_same_sizes(*plan_.input.sizes, *motion, original_.points)) return std::nullopt;
    return !plan_.freedom || have_same_freedom(*plan_.freedom) ? motion : std::nullopt;
  }

 private:
  static std::size_t place_of(ModelRegionId region, const Complex& complex) {
    if (!region.valid()) return complex.regions.size();
    return static_cast<std::size_t>(std::ranges::lower_bound(complex.regions, region.value) - complex.regions.begin());
  }

  bool have_same_sides() const {
    return std::ranges::equal(original_.tri_to_sides, complex_.tri_to_sides,
                              [&](const FaceSides& a, const FaceSides& b) {
                                return place_of(a.front, original_) == place_of(b.front, complex_) &&
                                       place_of(a.back, original_) == place_of(b.back, complex_);
                              });
  }

  bool have_same_faces() const {
    Pairing faces;
    const auto& tri_to_face = plan_.input.tri_to_face;
    return std::ranges::equal(original_.to_input_tri, complex_.to_input_tri, [&](std::uint32_t a, std::uint32_t b) {
      return faces.pair(tri_to_face[a], tri_to_face[b]);
    });
  }

  bool have_same_freedom(const SurfaceFreedom& freedom) const {
    Pairing entities;
    const auto &to_input = original_.to_input_vert, &to_other = complex_.to_input_vert;
    for (std::size_t v = 0; v < to_input.size(); ++v) {
      const ModelEntity a = freedom.entity_of(to_input[v]), b = freedom.entity_of(to_other[v]);
      if (a.dim != b.dim || !entities.pair(number_of(a), number_of(b))) return false;
    }
    for (const auto& [a, b, c] : original_.tri_to_vert)
      for (const auto& [v, w] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
        if (freedom.is_kept(to_input[v], to_input[w]) != freedom.is_kept(to_other[v], to_other[w])) return false;
    return true;
  }

  const FillingPlan& plan_;
  const Complex &original_, &complex_;
};

bool are_positive(const PartMesh& part) {
  const auto& verts = part.block(CellKind::Tet).to_vert;
  const auto point = [&](std::size_t i) -> const Vec3& { return part.points[verts[i]]; };
  for (std::size_t i = 0; i < verts.size(); i += 4)
    if (orient3d(point(i), point(i + 1), point(i + 2), point(i + 3)) <= 0) return false;
  return true;
}

PartMesh move_part(const PartMesh& given, const Complex& original, const Complex& complex, const RigidMotion& motion) {
  PartMesh part = given;
  for (std::size_t v = 0; v < part.points.size(); ++v) {
    const std::uint64_t number = part.vert_to_global[v];
    const bool stays = number < original.points.size() && part.points[v] == original.points[number];
    part.points[v] = stays ? complex.points[number] : motion(part.points[v]);
  }
  for (std::uint32_t& region : part.block(CellKind::Tet).to_region) {
    const auto place = std::ranges::lower_bound(original.regions, region) - original.regions.begin();
    region = complex.regions[static_cast<std::size_t>(place)];
  }
  return part;
}

FillingFigures figures_of_copy(const FillingFigures& original) {
  FillingFigures figures = original;
  figures.seconds = {};
  figures.optimizer.acute_tets.clear();
  return figures;
}

}  // namespace

std::vector<std::optional<ComplexCopy>> find_copies(const FillingPlan& plan, std::span<const Complex> complexes,
                                                    const TaskRunner& runner) {
  std::map<std::array<std::size_t, 3>, std::vector<std::size_t>> alike;
  for (std::size_t i = 0; i < complexes.size(); ++i)
    alike[{complexes[i].points.size(), complexes[i].tri_to_vert.size(), complexes[i].regions.size()}].push_back(i);
  std::vector<std::optional<ComplexCopy>> copies(complexes.size());
  std::vector<const std::vector<std::size_t>*> groups;
  for (const auto& [counts, group] : alike) groups.push_back(&group);
  runner.for_each(groups.size(), [&](std::size_t g) {
    std::vector<std::size_t> originals;
    for (const std::size_t i : *groups[g]) {
      for (const std::size_t original : originals) {
        const auto motion = CopyTest(plan, complexes[original], complexes[i]).run();
        if (!motion) continue;
        copies[i] = ComplexCopy{original, *motion};
        break;
      }
      if (!copies[i]) originals.push_back(i);
    }
  });
  return copies;
}

std::optional<VolumeParts> copy_filled(const FillingPlan& plan, const VolumeParts& filled, const Complex& original,
                                       const Complex& complex, const RigidMotion& motion) {
  if (filled.part_count == 0 || !filled.errors.empty() || !filled.warnings.empty()) return std::nullopt;
  VolumeParts copy;
  for (const PartMesh& part : filled.parts) {
    if (!has_same_sizes(*plan.input.sizes, motion, part.points.span())) return std::nullopt;
    copy.parts.push_back(move_part(part, original, complex, motion));
    if (!are_positive(copy.parts.back())) return std::nullopt;
  }
  copy.part_count = filled.part_count;
  copy.new_points = filled.new_points;
  copy.figures = figures_of_copy(filled.figures);
  return copy;
}

}  // namespace tetloom::volume
