// STL: triangles in single precision, each with its own three points.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "core/io/formats_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kHeaderBytes = 84, kTriangleBytes = 50;

using StlPoint = std::array<float, 3>;

/// Makes one point of equal ones, numbered by first appearance. `corners` holds three per triangle.
Mesh merge_corners(const std::vector<StlPoint>& corners) {
  std::vector<std::uint32_t> order(corners.size());
  std::iota(order.begin(), order.end(), 0u);
  // By bits, so that NaN has a place in the order; -0 was made +0 before.
  const auto compare = [&](std::uint32_t a, std::uint32_t b) {
    return std::memcmp(&corners[a], &corners[b], sizeof(StlPoint));
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const int sign = compare(a, b);
    return sign != 0 ? sign < 0 : a < b;
  });
  std::vector<std::uint32_t> first(corners.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && compare(order[i - 1], order[i]) == 0 ? first[order[i - 1]] : order[i];
  Mesh mesh;
  for (std::uint32_t i = 0; i < corners.size(); ++i) {
    if (first[i] == i) {
      first[i] = static_cast<std::uint32_t>(mesh.points.size());
      mesh.points.push_back({corners[i][0], corners[i][1], corners[i][2]});
    } else {
      first[i] = first[first[i]];
    }
  }
  mesh.tri_to_vert.resize(corners.size() / 3);
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    mesh.tri_to_vert[t] = {first[3 * t], first[3 * t + 1], first[3 * t + 2]};
  mesh.tri_to_entity.assign(mesh.tri_to_vert.size(), ModelFaceId::kNone);
  mesh.point_to_entity.resize(mesh.points.size());
  return mesh;
}

float plain_zero(float x) { return x == 0 ? 0.0f : x; }

std::vector<StlPoint> read_binary_corners(Cursor cursor, std::uint32_t triangles) {
  std::vector<StlPoint> corners;
  corners.reserve(std::size_t{3} * triangles);
  for (std::uint32_t t = 0; t < triangles; ++t) {
    cursor.jump(cursor.at() + 12);  // the normal
    for (int corner = 0; corner < 3; ++corner) {
      StlPoint point;
      for (float& x : point) x = plain_zero(cursor.read<float>());
      corners.push_back(point);
    }
    cursor.jump(cursor.at() + 2);  // the attribute
  }
  return corners;
}

std::vector<StlPoint> read_text_corners(Cursor cursor) {
  std::vector<StlPoint> corners;
  cursor.line();  // solid NAME
  for (;;) {
    const std::string_view word = cursor.token();
    if (word == "vertex") {
      StlPoint point;
      for (float& x : point) x = plain_zero(static_cast<float>(cursor.parse<double>()));
      corners.push_back(point);
    } else if (word == "facet") {
      if (corners.size() % 3 != 0) cursor.file().fail_at_line("a facet without three vertices", cursor.at());
    } else if (word == "solid" || word == "endsolid") {
      cursor.line();
      cursor.skip_space();
      if (word == "endsolid" && cursor.left() == 0) break;
    } else if (word.empty()) {
      cursor.file().fail_at_line("the file ends without 'endsolid'", cursor.at());
    }
  }
  if (corners.size() % 3 != 0) cursor.file().fail_at_line("a facet without three vertices", cursor.at());
  return corners;
}

}  // namespace

void write_stl(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  if (mesh.tri_to_vert.size() > 0xffffffffu)
    throw Error(ErrorCode::InvalidArgument, "the mesh has too many triangles for STL");
  std::array<char, 80> header{};
  std::memcpy(header.data(), "binary STL of tetloom", 21);
  file.write(header.data(), header.size());
  file.put(static_cast<std::uint32_t>(mesh.tri_to_vert.size()));
  const auto triangle_of = [&](std::size_t t) {
    const auto& [a, b, c] = mesh.tri_to_vert[t];
    const Vec3 &pa = mesh.points[a], &pb = mesh.points[b], &pc = mesh.points[c];
    std::array<char, kTriangleBytes> bytes{};  // the attribute at the end stays zero
    std::size_t at = 0;
    for (const Vec3& v : {normalized(cross(pb - pa, pc - pa)), pa, pb, pc}) {
      const StlPoint point{static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
      std::memcpy(bytes.data() + at, point.data(), sizeof(point));
      at += sizeof(point);
    }
    return bytes;
  };
  file.put_each(mesh.tri_to_vert.size(), triangle_of, loop);
}

Mesh read_stl(const InputFile& file) {
  Cursor cursor(file, file.bytes());
  if (cursor.left() >= kHeaderBytes) {
    Cursor count(file, file.bytes().substr(kHeaderBytes - 4));
    const auto triangles = count.read<std::uint32_t>();
    if (count.left() == triangles * std::uint64_t{kTriangleBytes}) {
      if (triangles == 0) file.fail(ErrorCode::InputUnsuitable, "the file has no triangles");
      if (triangles > 0x55555555u) file.fail(ErrorCode::InputUnsuitable, "the file has too many triangles");
      return merge_corners(read_binary_corners(count, triangles));
    }
  }
  if (!file.bytes().starts_with("solid"))
    file.fail(ErrorCode::InputUnreadable,
              "neither a text STL, which starts with 'solid', nor a binary one, whose size follows from its count");
  const std::vector<StlPoint> corners = read_text_corners(cursor);
  if (corners.empty()) file.fail(ErrorCode::InputUnsuitable, "the file has no triangles");
  return merge_corners(corners);
}

}  // namespace tetloom::detail
