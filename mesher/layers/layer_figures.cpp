#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "mesher/layers/layered_mesh.hpp"
#include "mesher/layers/stack_cells.hpp"

namespace tetloom {

std::string_view to_string(LayerLimit limit) {
  constexpr std::array<std::string_view, kLayerLimits> kNames{"none", "gap",      "concave",    "isotropy", "no_normal",
                                                              "cell", "crossing", "side_angle", "filling",  "fan"};
  return kNames[static_cast<std::size_t>(limit)];
}

}  // namespace tetloom

namespace tetloom::layers {
namespace {

constexpr double kAsAsked = 0.1;  // of the first height

class Measuring {
 public:
  Measuring(const LayerGrowth& growth, const Mesh& given)
      : growth_(growth), walls_(growth.walls()), counts_(growth.counts()), given_(given) {}

  LayerFigures run(const TaskRunner& runner) {
    measure_cells(runner);
    measure_curves(runner);
    figures_.fans = walls_.fan_vertices.size();
    std::map<std::uint32_t, Sums> faces;
    Sums whole;
    for (const WallTriangle& wall : walls_.triangles) {
      const Sums one = measure(wall);
      whole.add(one);
      faces[given_.tri_to_entity[wall.triangle]].add(one);
      note_limit(wall, one.area);
    }
    figures_.coverage = whole.shares();
    figures_.first_angle_p99 = percentile_of_angles();
    for (const auto& [face, sums] : faces) figures_.by_face.push_back({ModelFaceId(face), sums.shares()});
    for (const auto& [key, limited] : limited_) figures_.limited.push_back(limited.figure);
    std::ranges::stable_sort(figures_.limited, std::ranges::greater{}, &LimitedLayers::area);
    return std::move(figures_);
  }

 private:
  struct Sums {
    double area = 0, full = 0, covered = 0, thickness = 0, as_asked = 0, error = 0, growth_error = 0;

    void add(const Sums& other) {
      area += other.area, full += other.full, covered += other.covered;
      thickness += other.thickness, as_asked += other.as_asked, error += other.error;
      growth_error = std::max(growth_error, other.growth_error);
    }
    LayerCoverage shares() const {
      if (area == 0) return {};
      const double with_layer = covered > 0 ? covered : 1;
      return {area,        full / area, covered / area, thickness / area, as_asked / with_layer, error / with_layer,
              growth_error};
    }
  };
  struct CurveFigures {
    double growth_error = 0;  // where the curve is straight
    bool is_at_ridge = false;
  };
  struct AngleOnArea {
    double angle = 0, area = 0;
  };
  struct Limited {
    LimitedLayers figure;
    double left = 2;  // share of the layers at the point
  };

  std::array<int, 3> counts_of(const WallTriangle& wall) const {
    return {counts_.count(wall.curves[0]), counts_.count(wall.curves[1]), counts_.count(wall.curves[2])};
  }

  Vec3 area_of(const WallTriangle& wall) const {
    const auto& [a, b, c] = wall.verts;
    return 0.5 * cross(given_.points[b] - given_.points[a], given_.points[c] - given_.points[a]);
  }

  Sums measure(const WallTriangle& wall) {
    const Vec3 area = area_of(wall);
    Sums sums;
    sums.area = norm(area);
    bool is_full = true;
    double share = 0, height = 0, asked = 0;
    for (const std::uint32_t c : wall.curves) {
      const LayerHeights& heights = walls_.curve_to_heights[c];
      is_full = is_full && counts_.count(c) == heights.count;
      share += heights.sum(counts_.count(c)) / heights.sum(heights.count) / 3;
      asked += heights.first / 3;
      sums.growth_error = std::max(sums.growth_error, curves_[c].growth_error);
      if (counts_.count(c) > 0) height += dot(counts_.point(c, 1) - counts_.point(c, 0), normalized(area)) / 3;
    }
    sums.thickness = share * sums.area;
    if (is_full) sums.full = sums.area;
    if (std::ranges::min(counts_of(wall)) == 0) return sums;
    sums.covered = sums.area;
    sums.error = std::abs(height - asked) / asked * sums.area;
    note_angle(wall, area);
    if (std::abs(height - asked) <= kAsAsked * asked) sums.as_asked = sums.area;
    return sums;
  }

  void measure_curves(const TaskRunner& runner) {
    constexpr std::size_t kGrain = 1024;
    curves_.resize(walls_.curve_count());
    runner.for_blocks(curves_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (auto c = static_cast<std::uint32_t>(begin); c < end; ++c)
        curves_[c] = {is_straight(c) ? growth_error(c) : 0, is_at_ridge(c)};
    });
  }

  bool is_straight(std::uint32_t curve) const {
    constexpr double kBend = 1e-9;
    const Vec3 foot = counts_.point(curve, 0), way = counts_.top(curve) - foot;
    for (int level = 1; level < counts_.count(curve); ++level)
      if (norm(cross(counts_.point(curve, level) - foot, way)) > kBend * norm2(way)) return false;
    return true;
  }

  double growth_error(std::uint32_t curve) const {
    double worst = 0;
    const auto height = [&](int level) {
      return distance(counts_.point(curve, level), counts_.point(curve, level + 1));
    };
    for (int level = 0; level + 1 < counts_.count(curve); ++level)
      worst =
          std::max(worst, std::abs(height(level + 1) / (height(level) * walls_.curve_to_heights[curve].growth) - 1));
    return worst;
  }

  // Where the wall turns by more than 20 degrees from its mean.
  bool is_at_ridge(std::uint32_t curve) const {
    constexpr double kCosine = 0.9396926207859084;
    Vec3 mean{};
    for (const std::uint32_t w : walls_.triangles_at(curve)) mean = mean + area_of(walls_.triangles[w]);
    return std::ranges::any_of(walls_.triangles_at(curve), [&](std::uint32_t w) {
      return dot(normalized(mean), normalized(area_of(walls_.triangles[w]))) < kCosine;
    });
  }

  // The largest of a first cell's edges.
  void note_angle(const WallTriangle& wall, const Vec3& area) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    double least = 1;
    for (const std::uint32_t c : wall.curves)
      if (!curves_[c].is_at_ridge)
        least = std::min(least, dot(normalized(counts_.point(c, 1) - counts_.point(c, 0)), normalized(area)));
    angles_.push_back({kDegrees * std::acos(std::max(-1.0, least)), norm(area)});
  }

  double percentile_of_angles() {
    std::ranges::sort(angles_, {}, &AngleOnArea::angle);
    double all = 0, below = 0;
    for (const AngleOnArea& one : angles_) all += one.area;
    for (const AngleOnArea& one : angles_)
      if ((below += one.area) >= 0.99 * all) return one.angle;
    return 0;
  }

  void note_limit(const WallTriangle& wall, double area) {
    const auto left = [&](std::uint32_t c) {
      return static_cast<double>(counts_.count(c)) / walls_.curve_to_heights[c].count;
    };
    const std::uint32_t worst = *std::ranges::min_element(wall.curves, {}, left);
    if (left(worst) < 1) return note(wall, area, worst, counts_.limit(worst));
    for (const std::uint32_t c : wall.curves)
      if (std::ranges::binary_search(walls_.blunt_verts, walls_.curve_to_vert[c]))
        return note(wall, area, c, LayerLimit::Fan);
  }

  void note(const WallTriangle& wall, double area, std::uint32_t curve, LayerLimit reason) {
    const std::uint32_t face = given_.tri_to_entity[wall.triangle];
    const double left = static_cast<double>(counts_.count(curve)) / walls_.curve_to_heights[curve].count;
    Limited& limited = limited_[{reason, face}];
    limited.figure.reason = reason;
    limited.figure.face = ModelFaceId(face);
    limited.figure.area += area;
    if (std::ranges::min(counts_of(wall)) == 0) limited.figure.uncovered += area;
    if (left >= limited.left) return;
    limited.left = left;
    limited.figure.point = given_.points[walls_.curve_to_vert[curve]];
  }

  void measure_cells(const TaskRunner& runner) {
    constexpr std::size_t kGrain = 1024;
    struct Part {
      std::array<std::size_t, kCellKinds> cells{};
      std::vector<float> jacobians;
    };
    const auto count_of = [&](std::uint32_t c) { return counts_.count(c); };
    const auto measure_stack = [&](std::size_t stack, Part& part) {
      for_each_cell_on(walls_, stack, count_of, [&](const auto& cell, int) {
        std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(cell)>>> x;
        for (std::size_t i = 0; i < x.size(); ++i)
          x[i] = cell[i].is_apex() ? counts_.apex(walls_.fan(stack)) : counts_.point(cell[i].curve, cell[i].level);
        ++part.cells[static_cast<std::size_t>(kind_of_cell(x.size()))];
        part.jacobians.push_back(static_cast<float>(scaled_jacobian(x)));
      });
    };
    const auto parts =
        map_blocks<Part>(runner, walls_.stack_count(), kGrain, {}, [&](std::size_t begin, std::size_t end, Part& part) {
          for (std::size_t s = begin; s < end; ++s) measure_stack(s, part);
        });
    std::vector<float> all;
    for (const Part& part : parts) {
      figures_.tets += part.cells[static_cast<std::size_t>(CellKind::Tet)];
      figures_.pyramids += part.cells[static_cast<std::size_t>(CellKind::Pyramid)];
      figures_.prisms += part.cells[static_cast<std::size_t>(CellKind::Prism)];
      figures_.hexes += part.cells[static_cast<std::size_t>(CellKind::Hex)];
      all.insert(all.end(), part.jacobians.begin(), part.jacobians.end());
    }
    if (all.empty()) return;
    figures_.min_scaled_jacobian = std::ranges::min(all);
    const auto percentile = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 100);
    std::ranges::nth_element(all, percentile);
    figures_.scaled_jacobian_p1 = *percentile;
  }

  const LayerGrowth& growth_;
  const Walls& walls_;
  const LayerCounts& counts_;
  const Mesh& given_;
  std::vector<CurveFigures> curves_;
  std::vector<AngleOnArea> angles_;  // of wall triangles with a layer
  LayerFigures figures_;
  std::map<std::pair<LayerLimit, std::uint32_t>, Limited> limited_;
};

}  // namespace

LayerFigures measure_layers(const LayerGrowth& growth, const Mesh& given, const TaskRunner& runner) {
  return Measuring(growth, given).run(runner);
}

}  // namespace tetloom::layers
