#include "tests/support/families/facets.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <unordered_map>

namespace tetloom::test {
namespace {

namespace fs = std::filesystem;

constexpr double kNearest = 1e-3;  // of a point to the end of the edge that it lies on, beside its length

/// Marches over the tets of a grid.
class Marcher {
 public:
  Marcher(const std::function<double(const Vec3&)>& field, int cells) : nodes_(static_cast<std::uint64_t>(cells) + 1) {
    values_.reserve(nodes_ * nodes_ * nodes_);
    for (std::uint64_t node = 0; node < nodes_ * nodes_ * nodes_; ++node) {
      const double value = field(place(node));
      values_.push_back(static_cast<float>(value));
    }
  }

  FacetSurface run() {
    for (std::uint64_t z = 0; z + 1 < nodes_; ++z)
      for (std::uint64_t y = 0; y + 1 < nodes_; ++y)
        for (std::uint64_t x = 0; x + 1 < nodes_; ++x) cut_cube(x + nodes_ * (y + nodes_ * z));
    return std::move(surface_);
  }

 private:
  Vec3 place(std::uint64_t node) const {
    const double step = 1 / static_cast<double>(nodes_ - 1);
    return {step * static_cast<double>(node % nodes_), step * static_cast<double>(node / nodes_ % nodes_),
            step * static_cast<double>(node / nodes_ / nodes_)};
  }
  bool inside(std::uint64_t node) const { return values_[node] > 0; }

  /// The six tets of a cube have its diagonal in common and go from corner 0 to 7 by one axis after the other.
  void cut_cube(std::uint64_t corner) {
    const std::array<std::uint64_t, 3> steps{1, nodes_, nodes_ * nodes_};
    const std::uint64_t far = corner + steps[0] + steps[1] + steps[2];
    const bool whole = inside(corner);
    bool crossed = false;
    for (int bits = 1; bits < 8; ++bits) {
      std::uint64_t node = corner;
      for (std::size_t axis = 0; axis < 3; ++axis)
        if ((bits >> axis & 1) != 0) node += steps[axis];
      crossed = crossed || inside(node) != whole;
    }
    if (!crossed) return;
    static constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
    for (int i = 0; i < 6; ++i) {
      const std::uint64_t one = corner + steps[static_cast<std::size_t>(kOrders[i][0])];
      const std::uint64_t two = one + steps[static_cast<std::size_t>(kOrders[i][1])];
      // Even permutations of the axes give positive tets.
      cut_tet(i < 3 ? std::array{corner, one, two, far} : std::array{corner, two, one, far});
    }
  }

  /// Pre: a positive tet.
  void cut_tet(std::array<std::uint64_t, 4> tet) {
    const auto in = std::count_if(tet.begin(), tet.end(), [&](std::uint64_t node) { return inside(node); });
    if (in == 0 || in == 4) return;
    // Rotations bring the lone node, or the two inside, to the front and keep the orientation.
    static constexpr std::size_t kEven[12][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 0, 3, 2},
                                                 {1, 3, 2, 0}, {1, 2, 0, 3}, {2, 3, 0, 1}, {2, 0, 1, 3},
                                                 {2, 1, 3, 0}, {3, 2, 1, 0}, {3, 1, 0, 2}, {3, 0, 2, 1}};
    for (const auto& order : kEven) {
      const std::array<std::uint64_t, 4> t{tet[order[0]], tet[order[1]], tet[order[2]], tet[order[3]]};
      if (in == 2 ? inside(t[0]) && inside(t[1]) : inside(t[0]) == (in == 1) && inside(t[1]) != inside(t[0]))
        return add_cut(t, in);
    }
  }

  void add_cut(const std::array<std::uint64_t, 4>& t, std::ptrdiff_t in) {
    if (in == 2) {
      const std::uint32_t a = cross_point(t[0], t[2]), b = cross_point(t[0], t[3]), c = cross_point(t[1], t[3]),
                          d = cross_point(t[1], t[2]);
      surface_.triangles.push_back({a, b, c});
      surface_.triangles.push_back({a, c, d});
      return;
    }
    const std::uint32_t a = cross_point(t[0], t[1]), b = cross_point(t[0], t[2]), c = cross_point(t[0], t[3]);
    in == 1 ? surface_.triangles.push_back({a, b, c}) : surface_.triangles.push_back({a, c, b});
  }

  std::uint32_t cross_point(std::uint64_t a, std::uint64_t b) {
    if (a > b) std::swap(a, b);
    const auto next = static_cast<std::uint32_t>(surface_.points.size());
    const auto [entry, is_new] = points_.try_emplace(a * 8 + edge_kind(b - a), next);
    if (is_new) {
      // Not so near a node that single precision turns a needle over.
      const double u = values_[a], v = values_[b], share = std::clamp(u / (u - v), kNearest, 1 - kNearest);
      surface_.points.push_back(place(a) + share * (place(b) - place(a)));
    }
    return entry->second;
  }

  /// Which of the seven ways an edge goes up from its lower node.
  std::uint64_t edge_kind(std::uint64_t difference) const {
    const std::uint64_t z = difference / (nodes_ * nodes_), rest = difference % (nodes_ * nodes_);
    return rest % nodes_ + 2 * (rest / nodes_) + 4 * z;
  }

  std::uint64_t nodes_;
  std::vector<float> values_;
  FacetSurface surface_;
  std::unordered_map<std::uint64_t, std::uint32_t> points_;  ///< by edge; only looked up, so its order does not matter
};

void write_binary_stl(const FacetSurface& surface, const fs::path& path) {
  std::string bytes(80, ' ');
  const auto put = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(surface.triangles.size()));
  for (const auto& triangle : surface.triangles) {
    for (int i = 0; i < 3; ++i) put(0.0f);
    for (const std::uint32_t corner : triangle)
      for (int i = 0; i < 3; ++i) put(static_cast<float>(surface.points[corner][i]));
    put(std::uint16_t{0});
  }
  std::ofstream(path, std::ios::binary) << bytes;
}

std::string point_text(const Vec3& point) {
  char text[96];
  std::snprintf(text, sizeof(text), "%.9g %.9g %.9g", point.x, point.y, point.z);
  return text;
}

void write_text_stl(const FacetSurface& surface, const fs::path& path) {
  std::ofstream file(path);
  file << "solid made\n";
  for (const auto& triangle : surface.triangles) {
    file << "facet normal 0 0 0\nouter loop\n";
    for (const std::uint32_t corner : triangle) file << "vertex " << point_text(surface.points[corner]) << '\n';
    file << "endloop\nendfacet\n";
  }
  file << "endsolid made\n";
}

void write_obj(const FacetSurface& surface, const fs::path& path) {
  std::ofstream file(path);
  for (const Vec3& point : surface.points) file << "v " << point_text(point) << '\n';
  for (const auto& [a, b, c] : surface.triangles) file << "f " << a + 1 << ' ' << b + 1 << ' ' << c + 1 << '\n';
}

struct Ball {
  Vec3 centre;
  double radius = 0;
};

}  // namespace

double enclosed_volume(const FacetSurface& surface) {
  double six_volumes = 0;
  const Vec3 origin = surface.points.at(0);
  for (const auto& [a, b, c] : surface.triangles)
    six_volumes += dot(cross(surface.points[a] - origin, surface.points[b] - origin), surface.points[c] - origin);
  return six_volumes / 6;
}

FacetSurface march(const std::function<double(const Vec3&)>& field, int cells) { return Marcher(field, cells).run(); }

FacetSurface random_blob(Random& random, int cells) {
  std::vector<Ball> balls;
  Vec3 centre{.5, .5, .5};
  for (int i = random.integer(1, 6); i > 0; --i) {
    balls.push_back({centre, random.uniform(.1, .18)});
    // The next begins within this one, so that all of them are one body.
    const Vec3 next = centre + 1.2 * balls.back().radius * random.direction();
    for (int axis = 0; axis < 3; ++axis) centre[axis] = std::clamp(next[axis], .25, .75);
  }
  const auto field = [&](const Vec3& x) {
    double sum = -1;
    for (const Ball& ball : balls) {
      const Vec3 apart = x - ball.centre;
      sum += ball.radius * ball.radius / (dot(apart, apart) + 1e-9);
    }
    const double wall = std::min({x.x, x.y, x.z, 1 - x.x, 1 - x.y, 1 - x.z});
    return std::min(sum, 40 * wall - 1);  // the box stays outside
  };
  FacetSurface surface = march(field, cells);
  for (Vec3& point : surface.points) point = 20 * point;
  return surface;
}

void write_facets(const FacetSurface& surface, Random& random, const fs::path& folder, FamilyModel& model) {
  switch (random.integer(0, 3)) {
    case 0: model.file = folder / "model.obj"; return write_obj(surface, model.file);
    case 1: model.file = folder / "model.stl"; return write_text_stl(surface, model.file);
    default: model.file = folder / "model.stl"; return write_binary_stl(surface, model.file);
  }
}

}  // namespace tetloom::test
