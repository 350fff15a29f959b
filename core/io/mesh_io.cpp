#include "tetloom/io.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <new>
#include <optional>
#include <string_view>

#include "core/io/file_slice.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/slice_filter_detail.hpp"
#include "core/io/solver/foam_writer.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/mapbc.hpp"
#include "core/io/vtu_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom {
namespace {

struct Format {
  const char* extension;
  void (*write)(const Mesh&, AtomicFile&, const BlockLoop&);
  Mesh (*read)(const detail::InputFile&);  ///< null: the format is written only
  bool has_second_order = false;
  bool has_groups = false;  ///< under the names of solver_names
  bool has_mapbc = false;   ///< names stand in a .mapbc file beside it
  std::optional<FileSlice> (*read_slice)(const detail::InputFile&, detail::SliceFilter&) = nullptr;
};

// Ascending, so that ".lb8.ugrid" comes before ".ugrid".
constexpr std::array<Format, 15> kFormats{
    {{".b8.ugrid", detail::write_b8_ugrid, detail::read_b8_ugrid, false, true, true},
     {".bdf", detail::write_bdf, nullptr, true, true},
     {".cgns", detail::write_cgns, detail::read_cgns, true, true},
     {".exo", detail::write_exodus, nullptr, true, true},
     {".inp", detail::write_inp, detail::read_inp, true, true},
     {".lb8.ugrid", detail::write_lb8_ugrid, detail::read_lb8_ugrid, false, true, true},
     {".med", detail::write_med, detail::read_med, true, true},
     {".mesh", detail::write_medit_text, detail::read_medit_text, false, false, false, detail::read_medit_text_slice},
     {".meshb", detail::write_medit_binary, detail::read_medit_binary, false, false, false,
      detail::read_medit_binary_slice},
     {".msh", detail::write_msh, detail::read_msh, true, false, false, detail::read_msh_slice},
     {".stl", detail::write_stl, detail::read_stl},
     {".su2", detail::write_su2, detail::read_su2, false, true},
     {".ugrid", detail::write_ugrid_text, detail::read_ugrid_text, false, true, true},
     {".vtkhdf", detail::write_vtkhdf, nullptr, true},
     {".vtu", detail::write_vtu, detail::read_vtu, true, false, false, detail::read_vtu_slice}}};

const Format* find_format(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const Format& format : kFormats) {
    const std::string_view extension = format.extension;
    if (name.size() > extension.size() && name.ends_with(extension)) return &format;
  }
  return nullptr;
}

std::string extensions(bool only_read) {
  std::string text;
  for (const Format& format : kFormats)
    if (!only_read || format.read) text += (text.empty() ? "" : ", ") + std::string(format.extension);
  return text;
}

const Format& format_of(const std::filesystem::path& path, bool reads) {
  const Format* format = find_format(path);
  if (format == nullptr)
    throw Error(ErrorCode::InvalidArgument, "'" + path.string() + "' is no mesh file by its extension; known are " +
                                                (reads ? known_mesh_extensions() : writable_mesh_extensions()));
  if (reads && !format->read)
    throw Error(ErrorCode::InvalidArgument, "'" + path.string() + "': files of this format are written, but not read");
  return *format;
}

// Fills the file of names before either takes its place.
void commit_with_mapbc(const Mesh& mesh, const std::filesystem::path& path, AtomicFile& file,
                       const CancelToken* cancel) {
  AtomicFile names(path, cancel);
  detail::write_mapbc(mesh, path, names, cancel);
  names.commit();
  file.commit();
}

void require_names(const std::vector<MeshField>& fields) {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const std::string& name = fields[i].name;
    const bool printable = std::all_of(name.begin(), name.end(), [](unsigned char c) { return c >= ' '; });
    if (name.empty() || !printable)
      throw Error(ErrorCode::InvalidArgument, "a field has no name, or one with control characters");
    for (std::size_t j = 0; j < i; ++j)
      if (fields[j].name == name) throw Error(ErrorCode::InvalidArgument, "two fields have the name '" + name + "'");
  }
}

}  // namespace

bool is_mesh_extension(const std::filesystem::path& path) {
  const Format* format = find_format(path);
  return format != nullptr && format->read != nullptr;
}

bool is_writable_mesh_format(const std::filesystem::path& path) {
  return find_format(path) != nullptr || detail::is_foam_folder(path);
}

bool holds_second_order(const std::filesystem::path& path) {
  const Format* format = find_format(path);
  return format != nullptr && format->has_second_order;
}

bool holds_solver_names(const std::filesystem::path& path, const WriteOptions& options) {
  const Format* format = find_format(path);
  if (format == nullptr) return detail::is_foam_folder(path);
  return format->has_groups || (format->write == detail::write_msh && options.msh_2_2);
}

std::string known_mesh_extensions() { return extensions(true); }

std::string writable_mesh_extensions() { return extensions(false) + ", .foam (a folder), /polyMesh (a folder)"; }

std::vector<NamedGroup> solver_names(const Mesh& mesh) {
  return detail::list_names(detail::name_groups(mesh.entities, detail::tags_with_elements(mesh)), mesh.entities);
}

void write_mesh(const Mesh& mesh, const std::filesystem::path& path, const CancelToken* cancel, const BlockLoop& loop) {
  write_mesh(mesh, path, WriteOptions{}, cancel, loop);
}

void write_mesh(const Mesh& mesh, const std::filesystem::path& path, const WriteOptions& options,
                const CancelToken* cancel, const BlockLoop& loop) {
  const bool is_foam = detail::is_foam_folder(path);
  auto write = is_foam ? nullptr : format_of(path, false).write;
  require_consistent(mesh, loop);
  require_names(mesh.point_fields);
  require_names(mesh.cell_fields);
  if (!mesh.mid_to_vert.empty() && !holds_second_order(path))
    throw Error(ErrorCode::InvalidArgument, "'" + path.string() + "': this format holds no mesh of second order");
  if (is_foam) return detail::write_foam(mesh, path, cancel, loop);
  if (write == detail::write_stl && mesh.tri_to_vert.empty())
    throw Error(ErrorCode::InvalidArgument, "the mesh has no triangles to write to '" + path.string() + "'");
  if (write == detail::write_msh && options.msh_2_2)
    write = options.text ? detail::write_msh2_text : detail::write_msh2_binary;
  AtomicFile file(path, cancel);
  write(mesh, file, loop);
  if (const Format& format = format_of(path, false); format.has_mapbc)
    return commit_with_mapbc(mesh, detail::mapbc_beside(path, format.extension), file, cancel);
  file.commit();
}

Mesh read_mesh(const std::filesystem::path& path, const CancelToken* cancel) try {
  const Format& format = format_of(path, true);
  const detail::InputFile file(path, cancel);
  Mesh mesh = format.read(file);
  detail::check_read_mesh(file, mesh);
  if (format.has_mapbc) detail::read_mapbc(detail::mapbc_beside(path, format.extension), mesh, cancel);
  return mesh;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::OutOfMemory, "not enough memory to read '" + path.string() + "'");
}

void write_mesh_piece(const Mesh& mesh, std::span<const std::uint64_t> global_ids, const std::filesystem::path& path,
                      const CancelToken* cancel, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  require_names(mesh.point_fields);
  require_names(mesh.cell_fields);
  const bool fits = global_ids.size() == mesh.points.size() &&
                    std::all_of(global_ids.begin(), global_ids.end(), [](std::uint64_t id) { return id >> 63 == 0; });
  if (!fits) throw Error(ErrorCode::InvalidArgument, "a piece needs one global id below 2^63 for each point");
  for (const MeshField& field : mesh.point_fields)
    if (field.name == detail::kGlobalId)
      throw Error(ErrorCode::InvalidArgument,
                  "a field on points has the name 'global_id', which pieces use themselves");
  AtomicFile file(path, cancel);
  detail::write_vtu_piece(mesh, global_ids, file, loop);
  file.commit();
}

MeshPiece read_mesh_piece(const std::filesystem::path& path, const CancelToken* cancel) try {
  const detail::InputFile file(path, cancel);
  MeshPiece piece = detail::read_vtu_piece(file);
  if (!piece.mesh.points.empty()) detail::check_read_mesh(file, piece.mesh);
  return piece;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::OutOfMemory, "not enough memory to read '" + path.string() + "'");
}

bool has_slices(const std::filesystem::path& path) {
  const Format* format = find_format(path);
  return format != nullptr && format->read_slice != nullptr;
}

std::optional<FileSlice> read_slice(const std::filesystem::path& path, std::size_t index, std::size_t count,
                                    const CancelToken* cancel) try {
  const Format& format = format_of(path, true);
  const detail::InputFile file(path, cancel, detail::FileAccess::Mapped);
  detail::SliceFilter filter(index, count);
  return format.read_slice(file, filter);
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::OutOfMemory, "not enough memory to read '" + path.string() + "'");
}

void write_msh_parts(const Mesh& mesh, const MeshParts& parts, const std::filesystem::path& path,
                     const CancelToken* cancel, const BlockLoop& loop) {
  require_consistent(mesh, loop);
  require_names(mesh.point_fields);
  require_names(mesh.cell_fields);
  const bool fits =
      parts.count > 0 && parts.cell_to_part.size() == cell_count(mesh) &&
      std::all_of(parts.cell_to_part.begin(), parts.cell_to_part.end(), [&](auto part) { return part < parts.count; });
  if (!fits) throw Error(ErrorCode::InvalidArgument, "every cell needs a part below the number of parts");
  AtomicFile file(path, cancel);
  detail::write_partitioned_msh(mesh, parts, file, loop);
  file.commit();
}

Mesh read_msh_parts(const std::filesystem::path& path, MeshParts& parts, const CancelToken* cancel) try {
  const detail::InputFile file(path, cancel);
  Mesh mesh = detail::read_partitioned_msh(file, parts);
  detail::check_read_mesh(file, mesh);
  return mesh;
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::OutOfMemory, "not enough memory to read '" + path.string() + "'");
}

bool has_msh_parts(const std::filesystem::path& path, const CancelToken* cancel) try {
  return detail::InputFile(path, cancel).bytes().find("\n$PartitionedEntities") != std::string_view::npos;
} catch (const Error& error) {
  if (error.code() == ErrorCode::Cancelled) throw;
  return false;  // whoever reads it says why
}

namespace detail {
namespace {

constexpr std::array<const char*, kBlocks> kBlockNames{"edge",    "triangle", "quadrilateral", "tet",
                                                       "pyramid", "prism",    "hexahedron"};

/// Overwrites the classification of the points of `elements`: with their entity, or with none where two differ.
template <class Element>
void classify_on(const std::vector<Element>& elements, const std::vector<std::uint32_t>& entities, int dim,
                 std::vector<ModelEntity>& point_to_entity) {
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const ModelEntity entity(dim, entities[e]);
    for (const std::uint32_t v : elements[e]) {
      ModelEntity& at = point_to_entity[v];
      if (at.dim != dim) at = entity;
      if (at != entity) at.index = ModelFaceId::kNone;  // where entities meet, on one of lower dimension
    }
  }
}

template <class Elements>
void check_indices(const InputFile& file, const Elements& elements, std::size_t point_count, const char* kind) {
  for (std::size_t e = 0; e < elements.size(); ++e)
    for (const std::uint32_t v : elements[e])
      if (v >= point_count)
        file.fail(ErrorCode::InputUnreadable, std::string(kind) + " " + std::to_string(e + 1) +
                                                  " refers to a point that is not among the " +
                                                  std::to_string(point_count) + " of the file");
}

}  // namespace

std::uint64_t largest_tag(const Mesh& mesh, const BlockLoop& loop) {
  std::uint64_t largest = largest_of(mesh.points.size(), loop, [&](std::size_t i) { return point_tag(mesh, i); });
  for_each_block(mesh, [&](Block, const auto&, const auto& entities) {
    const auto tag_of = [&](std::size_t e) { return tag_of_index(entities[e]); };
    largest = std::max(largest, largest_of(entities.size(), loop, tag_of));
  });
  return largest;
}

void classify_points(Mesh& mesh, std::span<const Corner> corners) {
  mesh.point_to_entity.assign(mesh.points.size(), {});
  for_each_cell_kind(mesh, [&](CellKind, const auto& cells, const auto& entities) {
    classify_on(cells, entities, 3, mesh.point_to_entity);
  });
  for_each_surface_kind(mesh, [&](const auto& elements, const auto& entities) {
    classify_on(elements, entities, 2, mesh.point_to_entity);
  });
  classify_on(mesh.edge_to_vert, mesh.edge_to_entity, 1, mesh.point_to_entity);
  for (const Corner& corner : corners) mesh.point_to_entity[corner.point] = {0, corner.index};
  for (ModelEntity& entity : mesh.point_to_entity)
    if (!entity.valid()) entity = {};
}

void check_read_mesh(const InputFile& file, const Mesh& mesh) {
  if (mesh.points.empty()) file.fail(ErrorCode::InputUnsuitable, "the file has no points");
  if (mesh.edge_to_vert.empty() && surface_count(mesh) + cell_count(mesh) == 0)
    file.fail(ErrorCode::InputUnsuitable, "the file has no edges, triangles or cells");
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    check_indices(file, elements, mesh.points.size(), kBlockNames[static_cast<std::size_t>(block)]);
  });
}

void refuse_elements(const InputFile& file, const std::string& kind) {
  file.fail(ErrorCode::InputUnsuitable, "the file has elements of the type " + kind +
                                            "; only points, edges, triangles, quadrilaterals, tets, pyramids, prisms "
                                            "and hexahedra with straight edges are supported");
}

}  // namespace detail
}  // namespace tetloom
