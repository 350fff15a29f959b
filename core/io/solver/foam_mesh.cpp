#include "core/io/solver/foam_mesh.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "core/io/atomic_file.hpp"
#include "core/io/solver/number_text.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

std::string header(const char* type, const std::string& object, const std::string& note = {}) {
  std::string text = "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class ";
  text += type;
  if (!note.empty()) text += ";\n    note \"" + note + "\"";
  text += ";\n    location \"constant/polyMesh\";\n    object ";
  return text + object + ";\n}\n\n";
}

std::string patch(const std::string& name, const char* type, const FoamRange& range, const std::string& more = {}) {
  return "    " + name + "\n    {\n        type " + type + ";\n        nFaces " + std::to_string(range.count) +
         ";\n        startFace " + std::to_string(range.first) + ";\n" + more + "    }\n";
}

/// Both sides of a face between parts begin with the same vertex.
std::span<std::uint32_t> from_lowest(std::span<std::uint32_t> verts) {
  std::ranges::rotate(verts, std::ranges::min_element(verts));
  return verts;
}

void write_numbers(AtomicFile& file, const auto& numbers, const BlockLoop& loop) {
  const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i) out = print(out, std::uint32_t{numbers[i]}, '\n');
    return out;
  };
  file.write_lines(numbers.size(), kIntegerBytes, print_block, loop);
}

void begin_zone(AtomicFile& file, const std::string& name, const char* type, const char* labels, std::size_t count) {
  file.write(name + "\n{\n    type " + type + ";\n    " + labels + " List<label>\n" + std::to_string(count) + "\n(\n");
}

}  // namespace

FoamMesh::FoamMesh(const Mesh& mesh, Groups named, const FoamPart& part, const BlockLoop& loop)
    : mesh_(mesh),
      loop_(loop),
      part_(part.number),
      cell_faces_(mesh, loop),
      groups_(make_groups(mesh, std::move(named))),
      faces_(order_foam_faces(cell_faces_, groups_[2], part.number, part.shared)),
      points_(mesh.points.size()) {
  for_each_cell_kind(mesh, [&](CellKind, const auto& cells, const auto&) {
    for (const auto& cell : cells)
      for (const std::uint32_t v : cell) points_.add(v);
  });
  points_.sort();
}

bool FoamMesh::is_file_name(const std::string& name) {
  static const std::set<std::string> names{"points",
                                           "faces",
                                           "owner",
                                           "neighbour",
                                           "boundary",
                                           "cellZones",
                                           "faceZones",
                                           "pointZones",
                                           "sets/",
                                           "pointProcAddressing",
                                           "faceProcAddressing",
                                           "cellProcAddressing",
                                           "boundaryProcAddressing"};
  return names.contains(name);
}

std::vector<std::int64_t> FoamMesh::counts() const {
  std::vector<std::int64_t> counts;
  for (const FoamRange& range : faces_.patches) counts.push_back(static_cast<std::int64_t>(range.count));
  for (const FoamFaces::Zone& zone : faces_.zones) counts.push_back(static_cast<std::int64_t>(zone.faces.size()));
  return counts;
}

void FoamMesh::write(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
                     const CancelToken* cancel) const {
  write_points(folder, cancel);
  write_faces(folder, cancel);
  write_owners(folder, cancel);
  write_boundary(folder, counts, cancel);
  write_cell_zones(folder, cancel);
  write_face_zones(folder, counts, cancel);
}

/// A file of `count` items of at most `bytes`, each printed by `print_item(out, i)`.
template <class PrintItem>
void FoamMesh::write_list(const std::filesystem::path& path, const char* type, std::size_t count, std::size_t bytes,
                          const PrintItem& print_item, const CancelToken* cancel, const std::string& note) const {
  AtomicFile file(path, cancel);
  file.write(header(type, path.filename().string(), note) + std::to_string(count) + "\n(\n");
  const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i) out = print_item(out, i);
    return out;
  };
  file.write_lines(count, bytes, print_block, loop_);
  file.write(")\n");
  file.commit();
}

void FoamMesh::write_points(const std::filesystem::path& folder, const CancelToken* cancel) const {
  const auto print_point = [&](char* out, std::size_t i) {
    const Vec3& x = mesh_.points[points_.items()[i]];
    *out++ = '(';
    for (int axis = 0; axis < 3; ++axis) out = print(out, x[axis], axis < 2 ? ' ' : ')');
    *out++ = '\n';
    return out;
  };
  write_list(folder / "points", "vectorField", points_.size(), 3 * kRealBytes + 4, print_point, cancel);
}

void FoamMesh::write_faces(const std::filesystem::path& folder, const CancelToken* cancel) const {
  const std::size_t first_shared =
      faces_.neighbours.empty() ? faces_.faces.size() : faces_.neighbours.front().range.first;
  const auto print_face = [&](char* out, std::size_t i) {
    std::array<std::uint32_t, 4> buffer;
    const std::size_t count = cell_faces_.vertices(faces_.faces[i], buffer).size();
    const std::span<std::uint32_t> verts = std::span(buffer).first(count);
    if (i >= first_shared) from_lowest(verts);
    out = print(out, count, '(');
    for (std::size_t k = 0; k < count; ++k) out = print(out, points_[verts[k]], k + 1 < count ? ' ' : ')');
    *out++ = '\n';
    return out;
  };
  write_list(folder / "faces", "faceList", faces_.faces.size(), 4 * kIntegerBytes + 4, print_face, cancel);
}

void FoamMesh::write_owners(const std::filesystem::path& folder, const CancelToken* cancel) const {
  const std::string note =
      "nPoints:" + std::to_string(points_.size()) + "  nCells:" + std::to_string(cell_faces_.cell_count()) +
      "  nFaces:" + std::to_string(faces_.faces.size()) + "  nInternalFaces:" + std::to_string(faces_.internal_count);
  const auto print_owner = [&](char* out, std::size_t i) {
    return print(out, cell_faces_.cell(faces_.faces[i]), '\n');
  };
  const auto print_neighbour = [&](char* out, std::size_t i) {
    return print(out, cell_faces_.cell(cell_faces_.twin(faces_.faces[i])), '\n');
  };
  write_list(folder / "owner", "labelList", faces_.faces.size(), kIntegerBytes, print_owner, cancel, note);
  write_list(folder / "neighbour", "labelList", faces_.internal_count, kIntegerBytes, print_neighbour, cancel, note);
}

void FoamMesh::write_boundary(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
                              const CancelToken* cancel) const {
  std::string patches;
  std::size_t count = faces_.neighbours.size();
  for (std::size_t i = 0; i < faces_.patches.size(); ++i) {
    if (counts[i] == 0) continue;
    patches += patch(i < groups_[2].size() ? groups_[2][i].name : "no_face", "patch", faces_.patches[i]);
    ++count;
  }
  for (const FoamFaces::Neighbour& other : faces_.neighbours) {
    const std::string own = std::to_string(part_), theirs = std::to_string(other.part);
    patches += patch("procBoundary" + own + "to" + theirs, "processor", other.range,
                     "        inGroups 1(processor);\n        matchTolerance 0.0001;\n        transform unknown;\n"
                     "        myProcNo " +
                         own + ";\n        neighbProcNo " + theirs + ";\n");
  }
  AtomicFile file(folder / "boundary", cancel);
  file.write(header("polyBoundaryMesh", "boundary") + std::to_string(count) + "\n(\n" + patches + ")\n");
  file.commit();
}

void FoamMesh::write_cell_zones(const std::filesystem::path& folder, const CancelToken* cancel) const {
  AtomicFile file(folder / "cellZones", cancel);
  file.write(header("regIOobject", "cellZones") + std::to_string(groups_[3].size()) + "\n(\n");
  for (const Group& group : groups_[3]) {
    begin_zone(file, group.name, "cellZone", "cellLabels", group.elements.size());
    write_numbers(file, group.elements, loop_);
    file.write(");\n}\n");
  }
  file.write(")\n");
  file.commit();
}

void FoamMesh::write_face_zones(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
                                const CancelToken* cancel) const {
  const auto zone_counts = std::span(counts).subspan(faces_.patches.size());
  AtomicFile file(folder / "faceZones", cancel);
  const auto zones = zone_counts.size() - static_cast<std::size_t>(std::ranges::count(zone_counts, 0));
  file.write(header("regIOobject", "faceZones") + std::to_string(zones) + "\n(\n");
  for (std::size_t i = 0; i < zone_counts.size(); ++i) {
    if (zone_counts[i] == 0) continue;
    const FoamFaces::Zone& zone = faces_.zones[i];
    begin_zone(file, groups_[2][i].name, "faceZone", "faceLabels", zone.faces.size());
    write_numbers(file, zone.faces, loop_);
    file.write(");\n    flipMap List<bool>\n" + std::to_string(zone.flips.size()) + "\n(\n");
    write_numbers(file, zone.flips, loop_);
    file.write(");\n}\n");
  }
  file.write(")\n");
  file.commit();
}

}  // namespace tetloom::detail
