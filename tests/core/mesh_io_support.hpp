#pragma once
// Comparing meshes field by field, and sending them through files, for the tests of core/io.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <filesystem>
#include <iostream>
#include <string>

#include "tests/support/error_of.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::test {

/// A file name from its stem and its extension.
inline std::string joined(std::string stem, const std::string& extension) { return stem += extension; }

/// In these a file is called by its name, or by its extension alone, which starts with a dot.
inline std::string file_name(const std::string& name) { return name.starts_with('.') ? joined("mesh", name) : name; }

inline Mesh read_content(const std::string& name, const std::string& content) {
  const TemporaryFolder folder;
  write_file(folder / file_name(name), content);
  return read_mesh(folder / file_name(name));
}

/// Why such a file is refused.
inline Diagnostic error_for(const std::string& name, const std::string& content) {
  return error_of([&] { static_cast<void>(read_content(name, content)); });
}

inline Mesh written_and_read(const Mesh& mesh, const std::string& name, const WriteOptions& options = {}) {
  const TemporaryFolder folder;
  write_mesh(mesh, folder / file_name(name), options);
  return read_mesh(folder / file_name(name));
}

/// What a file of the mesh holds.
inline std::string content_of(const Mesh& mesh, const std::string& name) {
  const TemporaryFolder folder;
  write_mesh(mesh, folder / file_name(name));
  return file_content(folder / file_name(name));
}

/// Reads a damaged file: either it is refused with a reason, or it holds some mesh.
inline void survive(const std::filesystem::path& path) {
  try {
    static_cast<void>(mesh_digest(read_mesh(path)));
  } catch (const Error& error) {
    const bool expected = error.code() == ErrorCode::InputUnreadable || error.code() == ErrorCode::InputUnsuitable;
    if (!expected || error.diagnostic().message.empty()) FAIL_CHECK("unexpected error: " << error.what());
  }
}

inline bool same_points(const Mesh& a, const Mesh& b) {
  if (a.points.size() != b.points.size()) return false;
  for (std::size_t i = 0; i < a.points.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      if (std::bit_cast<std::uint64_t>(a.points[i][axis]) != std::bit_cast<std::uint64_t>(b.points[i][axis]))
        return false;
  return true;
}

inline bool same_sides(const Mesh& a, const Mesh& b) {
  if (a.face_to_sides.size() != b.face_to_sides.size()) return false;
  for (std::size_t i = 0; i < a.face_to_sides.size(); ++i)
    if (a.face_to_sides[i].front != b.face_to_sides[i].front || a.face_to_sides[i].back != b.face_to_sides[i].back)
      return false;
  return true;
}

inline bool same_attributes(const Mesh& a, const Mesh& b) {
  for (std::size_t dim = 0; dim < 4; ++dim) {
    if (a.entities[dim].size() != b.entities[dim].size()) return false;
    for (std::size_t i = 0; i < a.entities[dim].size(); ++i) {
      const EntityAttributes &x = a.entities[dim][i], &y = b.entities[dim][i];
      if (x.name != y.name || x.color != y.color || x.layer != y.layer || x.group != y.group ||
          x.tolerance != y.tolerance)
        return false;
    }
  }
  return true;
}

/// Checks everything but attributes and sides.
inline void check_same_elements(const Mesh& a, const Mesh& b) {
  CHECK(same_points(a, b));
  CHECK(a.point_to_entity == b.point_to_entity);
  CHECK(a.edge_to_vert == b.edge_to_vert);
  CHECK(a.edge_to_entity == b.edge_to_entity);
  CHECK(a.tri_to_vert == b.tri_to_vert);
  CHECK(a.tri_to_entity == b.tri_to_entity);
  CHECK(a.tet_to_vert == b.tet_to_vert);
  CHECK(a.tet_to_entity == b.tet_to_entity);
  CHECK(a.quad_to_vert == b.quad_to_vert);
  CHECK(a.quad_to_entity == b.quad_to_entity);
  CHECK(a.pyramid_to_vert == b.pyramid_to_vert);
  CHECK(a.pyramid_to_entity == b.pyramid_to_entity);
  CHECK(a.prism_to_vert == b.prism_to_vert);
  CHECK(a.prism_to_entity == b.prism_to_entity);
  CHECK(a.hex_to_vert == b.hex_to_vert);
  CHECK(a.hex_to_entity == b.hex_to_entity);
}

/// Bit for bit, so that NaN equals itself.
inline bool same_fields(const std::vector<MeshField>& a, const std::vector<MeshField>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const MeshField& x, const MeshField& y) {
    return x.name == y.name && x.components == y.components &&
           std::equal(x.values.begin(), x.values.end(), y.values.begin(), y.values.end(), [](double p, double q) {
             return std::bit_cast<std::uint64_t>(p) == std::bit_cast<std::uint64_t>(q);
           });
  });
}

/// Whether a command runs and succeeds; its output goes to `log`.
inline bool succeeds(const std::string& command, const std::filesystem::path& log = "/dev/null") {
  return std::system((command + " > '" + log.string() + "' 2>&1").c_str()) == 0;
}

inline bool has_meshio() {
  static const bool found = succeeds("/usr/bin/python3 -c 'import meshio'");
  if (!found) std::cout << "meshio is not installed: skipped\n";
  return found;
}

}  // namespace tetloom::test
