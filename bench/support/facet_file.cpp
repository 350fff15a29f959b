#include "bench/support/facet_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

struct Soup {
  std::vector<Vec3> points;
  Triangles triangles;
};

std::string lower_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string content_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void add_triangle(Soup& soup) {
  const auto first = static_cast<std::uint32_t>(soup.points.size() - 3);
  soup.triangles.push_back({first, first + 1, first + 2});
}

constexpr std::size_t kHeaderBytes = 84, kTriangleBytes = 50;

/// How many triangles a binary STL file announces.
std::uint32_t announced(const std::string& bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeaderBytes) std::memcpy(&count, bytes.data() + kHeaderBytes - sizeof count, sizeof count);
  return count;
}

bool is_binary_stl(const std::string& bytes) {
  return bytes.size() >= kHeaderBytes && bytes.size() >= kHeaderBytes + kTriangleBytes * std::size_t{announced(bytes)};
}

Soup read_binary_stl(const std::string& bytes) {
  Soup soup;
  for (std::size_t t = 0; t < announced(bytes); ++t) {
    std::array<float, 12> numbers;  // the normal, then the corners
    std::memcpy(numbers.data(), bytes.data() + kHeaderBytes + t * kTriangleBytes, sizeof numbers);
    for (std::size_t k = 3; k < 12; k += 3) soup.points.push_back({numbers[k], numbers[k + 1], numbers[k + 2]});
    add_triangle(soup);
  }
  return soup;
}

Soup read_text_stl(const std::string& bytes) {
  Soup soup;
  std::istringstream text(bytes);
  int corners = 0;
  for (std::string word; text >> word;) {
    if (word == "outer") corners = 0;
    if (word != "vertex") continue;
    Vec3 point;
    if (!(text >> point.x >> point.y >> point.z)) throw std::runtime_error("an STL file with a broken vertex");
    soup.points.push_back(point);
    if (++corners == 3) add_triangle(soup), corners = 0;
  }
  return soup;
}

/// The corners of a line "f 1/2/3 -1 ...", 0-based.
std::vector<std::uint32_t> read_corners(std::istringstream& words, std::size_t points) {
  std::vector<std::uint32_t> corners;
  for (std::string word; words >> word;) {
    const long index = std::strtol(word.c_str(), nullptr, 10);
    const long corner = index > 0 ? index - 1 : static_cast<long>(points) + index;
    if (index == 0 || corner < 0 || corner >= static_cast<long>(points))
      throw std::runtime_error("an OBJ file with a facet of points that are not there");
    corners.push_back(static_cast<std::uint32_t>(corner));
  }
  return corners;
}

Soup read_obj(const std::string& bytes) {
  Soup soup;
  std::istringstream text(bytes);
  for (std::string line; std::getline(text, line);) {
    std::istringstream words(line);
    std::string key;
    words >> key;
    Vec3 point;
    if (key == "v" && words >> point.x >> point.y >> point.z) soup.points.push_back(point);
    if (key != "f") continue;
    const std::vector<std::uint32_t> corners = read_corners(words, soup.points.size());
    for (std::size_t k = 2; k < corners.size(); ++k) soup.triangles.push_back({corners[0], corners[k - 1], corners[k]});
  }
  return soup;
}

/// Equal points become one, numbered in ascending order of their coordinates.
Mesh merge_points(const Soup& soup) {
  const auto key = [](const Vec3& p) { return std::array{p.x + 0.0, p.y + 0.0, p.z + 0.0}; };
  std::vector<std::array<double, 3>> distinct;
  for (const Vec3& point : soup.points) distinct.push_back(key(point));
  std::sort(distinct.begin(), distinct.end());
  distinct.erase(std::unique(distinct.begin(), distinct.end()), distinct.end());
  Mesh mesh;
  for (const auto& [x, y, z] : distinct) mesh.points.push_back({x, y, z});
  for (const auto& triangle : soup.triangles) {
    std::array<std::uint32_t, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = std::lower_bound(distinct.begin(), distinct.end(), key(soup.points[triangle[k]]));
      corners[k] = static_cast<std::uint32_t>(place - distinct.begin());
    }
    mesh.tri_to_vert.push_back(corners);
  }
  mesh.tri_to_entity.assign(mesh.tri_to_vert.size(), ModelFaceId::kNone);
  mesh.point_to_entity.resize(mesh.points.size());
  return mesh;
}

/// Lines along z through a box, evenly, and where they pass facets.
class Columns {
 public:
  explicit Columns(const Mesh& facets) : passed_(std::size_t{kColumns} * kColumns) {
    const Box3 box = box_of(facets.points);
    // Steps that put no line through the corners of a regular model.
    lo_ = box.lo, width_ = 1.0001 * (box.hi.x - box.lo.x) / kColumns,
    depth_ = 1.0003 * (box.hi.y - box.lo.y) / kColumns;
  }

  void pass(const Vec3& a, const Vec3& b, const Vec3& c) {
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (area == 0) return;
    const auto first = [](double from, double step) { return std::max(0, static_cast<int>(from / step) - 1); };
    const double right = std::max({a.x, b.x, c.x}), far = std::max({a.y, b.y, c.y});
    for (int i = first(std::min({a.x, b.x, c.x}) - lo_.x, width_); i < kColumns && x_of(i) <= right; ++i)
      for (int j = first(std::min({a.y, b.y, c.y}) - lo_.y, depth_); j < kColumns && y_of(j) <= far; ++j) {
        const double x = x_of(i) - a.x, y = y_of(j) - a.y;
        const double wb = (x * (c.y - a.y) - (c.x - a.x) * y) / area, wc = ((b.x - a.x) * y - x * (b.y - a.y)) / area;
        if (wb < 0 || wc < 0 || wb + wc > 1) continue;
        passed_[static_cast<std::size_t>(i) * kColumns + static_cast<std::size_t>(j)].emplace_back(
            a.z + wb * (b.z - a.z) + wc * (c.z - a.z), area > 0 ? 1 : -1);
      }
  }

  /// Upwards, a facet that looks down is passed from without to within.
  double volume(bool is_inside_out) {
    double length = 0;
    for (auto& column : passed_) {
      std::ranges::sort(column);
      int winding = 0;
      for (std::size_t k = 0; k + 1 < column.size(); ++k) {
        winding -= column[k].second;
        if (is_inside_out ? winding < 0 : winding > 0) length += column[k + 1].first - column[k].first;
      }
    }
    return length * width_ * depth_;
  }

 private:
  static constexpr int kColumns = 512;  // in each direction
  double x_of(int i) const { return lo_.x + (i + 0.49) * width_; }
  double y_of(int j) const { return lo_.y + (j + 0.51) * depth_; }

  Vec3 lo_;
  double width_ = 0, depth_ = 0;
  std::vector<std::vector<std::pair<double, int>>> passed_;  // height, and up or down
};

}  // namespace

bool is_facet_file(const fs::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".stl" || extension == ".obj";
}

Mesh read_facet_file(const fs::path& path) {
  const std::string bytes = content_of(path);
  const Soup soup = lower_extension(path) == ".obj" ? read_obj(bytes)
                    : is_binary_stl(bytes)          ? read_binary_stl(bytes)
                                                    : read_text_stl(bytes);
  if (soup.triangles.empty()) throw std::runtime_error("no triangles in '" + path.string() + "'");
  return merge_points(soup);
}

bool is_closed_manifold(const Mesh& facets) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& [a, b, c] : facets.tri_to_vert) {
    if (a == b || b == c || c == a) continue;
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      edges.emplace_back(std::min(from, to), std::max(from, to));
  }
  std::sort(edges.begin(), edges.end());
  for (auto begin = edges.begin(), end = begin; begin != edges.end(); begin = end) {
    end = std::upper_bound(begin, edges.end(), *begin);
    if (end - begin != 2) return false;
  }
  return !edges.empty();
}

double enclosed_volume(const Mesh& facets) {
  const Vec3 origin = facets.points.at(0);
  double six_volumes = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    six_volumes += dot(cross(facets.points[a] - origin, facets.points[b] - origin), facets.points[c] - origin);
  return six_volumes / 6;
}

double wound_volume(const Mesh& facets) {
  Columns columns(facets);
  for (const auto& verts : facets.tri_to_vert)
    columns.pass(facets.points[verts[0]], facets.points[verts[1]], facets.points[verts[2]]);
  return columns.volume(enclosed_volume(facets) < 0);
}

}  // namespace tetloom::bench
