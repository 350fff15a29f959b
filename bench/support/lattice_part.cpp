#include "bench/support/lattice_part.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include "core/base/mix_bits.hpp"
#include "core/part/adjacency.hpp"

namespace tetloom::bench {
namespace {

using Solid = std::function<bool(double, double, double)>;

bool in_cylinder(double u, double v, double cu, double cv, double radius) {
  return std::hypot(u - cu, v - cv) < radius;
}

Solid find_solid(const std::string& name) {
  if (name == "ball") return [](double x, double y, double z) { return std::hypot(x - 0.5, y - 0.5, z - 0.5) < 0.5; };
  if (name == "drilled-block")
    return [](double x, double y, double z) {
      return z < 0.6 && !in_cylinder(x, y, 0.3, 0.3, 0.15) && !in_cylinder(x, y, 0.7, 0.65, 0.2) &&
             !in_cylinder(x, z, 0.75, 0.3, 0.1);
    };
  if (name == "bracket")
    return [](double x, double y, double z) {
      return y < 0.7 && (x < 0.3 || z < 0.3) && !in_cylinder(y, z, 0.35, 0.7, 0.15) &&
             !in_cylinder(x, y, 0.7, 0.35, 0.15);
    };
  throw std::invalid_argument("no solid '" + name + "'; there are ball, drilled-block and bracket");
}

// In [-1, 1), from the place in the lattice alone.
double jitter(std::uint64_t place, std::uint64_t axis) {
  const std::uint64_t hash = mix_bits((place * 3 + axis + 1) * 0x9e3779b97f4a7c15u);
  return static_cast<double>(static_cast<std::int64_t>(hash)) * 0x1p-63;
}

class Lattice {
 public:
  Lattice(const Solid& solid, std::uint32_t cubes) : cubes_(cubes), inside_(std::size_t{cubes} * cubes * cubes) {
    const double h = 1.0 / cubes;
    for (std::uint32_t k = 0; k < cubes; ++k)
      for (std::uint32_t j = 0; j < cubes; ++j)
        for (std::uint32_t i = 0; i < cubes; ++i)
          inside_[cube_at(i, j, k)] = solid((i + 0.5) * h, (j + 0.5) * h, (k + 0.5) * h);
  }

  PartMesh make() {
    PartMesh part;
    number_points(part);
    for (std::uint32_t k = 0; k < cubes_; ++k)
      for (std::uint32_t j = 0; j < cubes_; ++j)
        for (std::uint32_t i = 0; i < cubes_; ++i)
          if (inside_[cube_at(i, j, k)]) add_cube(part, i, j, k);
    part.block(CellKind::Tet).to_region.resize(part.block(CellKind::Tet).to_vert.size() / 4, 0);
    return part;
  }

 private:
  std::size_t cube_at(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return (std::size_t{k} * cubes_ + j) * cubes_ + i;
  }
  std::size_t point_at(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return (std::size_t{k} * (cubes_ + 1) + j) * (cubes_ + 1) + i;
  }
  bool has_cube(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    return i < cubes_ && j < cubes_ && k < cubes_ && inside_[cube_at(i, j, k)];
  }

  // How many of the eight cubes at a point are inside.
  int cubes_around(std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    int count = 0;
    for (std::uint32_t corner = 0; corner < 8; ++corner)
      count += has_cube(i - (corner & 1), j - (corner >> 1 & 1), k - (corner >> 2)) ? 1 : 0;
    return count;
  }

  void number_points(PartMesh& part) {
    const double h = 1.0 / cubes_;
    point_to_vert_.assign(std::size_t{cubes_ + 1} * (cubes_ + 1) * (cubes_ + 1), kNone);
    for (std::uint32_t k = 0; k <= cubes_; ++k) {
      for (std::uint32_t j = 0; j <= cubes_; ++j) {
        for (std::uint32_t i = 0; i <= cubes_; ++i) {
          const int around = cubes_around(i, j, k);
          if (around == 0) continue;
          const std::size_t place = point_at(i, j, k);
          const double move = around == 8 ? 0.1 * h : 0;
          point_to_vert_[place] = static_cast<std::uint32_t>(part.vertex_count());
          part.vert_to_global.push_back(part.vertex_count());
          part.vert_to_entity.push_back(PackedEntity(around == 8 ? ModelEntity(3, 0) : ModelEntity(2, 0)));
          part.points.push_back(
              {i * h + move * jitter(place, 0), j * h + move * jitter(place, 1), k * h + move * jitter(place, 2)});
        }
      }
    }
  }

  // One tet for each order of the axes: from the low corner to the high one along the cube's edges.
  void add_cube(PartMesh& part, std::uint32_t i, std::uint32_t j, std::uint32_t k) const {
    constexpr std::array<std::array<std::uint32_t, 2>, 6> middle{{{1, 3}, {3, 2}, {2, 6}, {6, 4}, {4, 5}, {5, 1}}};
    const auto vert = [&](std::uint32_t corner) {
      return point_to_vert_[point_at(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2))];
    };
    for (const auto& [a, b] : middle) {
      const std::array<std::uint32_t, 4> tet{vert(0), vert(a), vert(b), vert(7)};
      part.block(CellKind::Tet).to_vert.append(tet);
    }
  }

  std::uint32_t cubes_;
  std::vector<bool> inside_;
  std::vector<std::uint32_t> point_to_vert_;
};

void add_triangles(PartMesh& part) {
  BoundaryBlock& triangles = part.block(BoundaryKind::Triangle);
  for_each_open_face(part, [&](CellPlace face) {
    const auto verts = vertices_of_face(part, face);
    triangles.to_vert.append(std::span(verts).first(3));
    triangles.to_entity.push_back(0);
  });
}

}  // namespace

PartMesh make_lattice_part(const std::string& solid, double tets) {
  constexpr std::uint32_t kSample = 60;
  const Solid inside = find_solid(solid);
  std::size_t count = 0;
  for (std::uint32_t i = 0; i < kSample * kSample * kSample; ++i)
    count += inside((i % kSample + 0.5) / kSample, (i / kSample % kSample + 0.5) / kSample,
                    (i / kSample / kSample + 0.5) / kSample)
                 ? 1
                 : 0;
  const double share = static_cast<double>(count) / (kSample * kSample * kSample);
  PartMesh part = Lattice(inside, static_cast<std::uint32_t>(std::ceil(std::cbrt(tets / 6 / share)))).make();
  connect_cells(part);
  add_triangles(part);
  return part;
}

}  // namespace tetloom::bench
