#include <algorithm>
#include <memory>

#include "core/base/codec.hpp"
#include "core/io/atomic_file.hpp"
#include "core/io/atomic_folder.hpp"
#include "core/io/mesh_piece.hpp"
#include "core/part/convert.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/parts_io_detail.hpp"

namespace tetloom::detail {
namespace {

/// "<stem>_<number>.vtu".
bool is_piece_name(const std::string& name, const std::string& stem) {
  if (!name.starts_with(stem + "_") || !name.ends_with(".vtu") || name.size() <= stem.size() + 5) return false;
  return std::all_of(name.begin() + static_cast<std::ptrdiff_t>(stem.size()) + 1, name.end() - 4,
                     [](char c) { return c >= '0' && c <= '9'; });
}

std::string piece_name(const std::string& stem, std::size_t part) { return stem + "_" + std::to_string(part) + ".vtu"; }

std::vector<std::uint64_t> sorted_globals(const PartMesh& part) {
  std::vector<std::uint64_t> ids(part.vert_to_global.begin(), part.vert_to_global.end());
  std::sort(ids.begin(), ids.end());
  return ids;
}

/// The folder's name as rank 0 made it.
std::filesystem::path share_path(Communicator& communicator, const std::filesystem::path& own) {
  std::string text;
  share_from_first(
      communicator, [&](MessageWriter& writer) { put_text(writer, own.string()); },
      [&](MessageReader& reader) { text = get_text(reader); });
  return text;
}

std::vector<PieceList::Field> list_fields(const std::vector<FieldInfo>& fields) {
  std::vector<PieceList::Field> list;
  for (const FieldInfo& field : fields) list.push_back({field.name, field.components});
  return list;
}

/// Elements of all dimensions, as VTK counts cells, by part.
std::vector<std::int64_t> count_elements(const PartitionedMesh& mesh) {
  std::vector<std::int64_t> counts(mesh.part_count(), 0);
  for (const PartId part : mesh.local()) {
    const PartMesh& part_mesh = mesh.parts.at(part).mesh;
    std::size_t count = part_mesh.cell_count();
    for (const BoundaryBlock& block : part_mesh.boundary) count += block.size();
    counts[part.value] = static_cast<std::int64_t>(count);
  }
  mesh.communicator->sum(counts);
  return counts;
}

PieceList make_list(const PartitionedMesh& mesh, const std::string& stem) {
  const PartsFigures figures = measure_parts(mesh);
  const std::vector<std::int64_t> elements = count_elements(mesh);
  PieceList list;
  for (std::size_t part = 0; part < mesh.part_count(); ++part)
    list.pieces.push_back({stem + "/" + piece_name(stem, part),
                           static_cast<std::uint64_t>(figures.parts[part].vertices),
                           static_cast<std::uint64_t>(elements[part])});
  list.point_fields = list_fields(mesh.vertex_fields);
  list.cell_fields = list_fields(mesh.cell_fields);
  list.totals = {static_cast<std::uint64_t>(figures.vertices), static_cast<std::uint64_t>(figures.cut_faces)};
  return list;
}

void commit(const PieceList& list, AtomicFolder& folder, AtomicFile& master) {
  write_piece_list(list, master);
  folder.swap_in();
  try {
    master.commit();
  } catch (...) {
    folder.swap_back();
    throw;
  }
}

}  // namespace

void write_pieces(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                  const CancelToken* cancel) {
  std::error_code error;
  const bool is_link = std::filesystem::is_symlink(path, error);
  const std::filesystem::path target = is_link ? std::filesystem::weakly_canonical(path, error) : path;
  const std::string stem = path.stem().string();
  Communicator& communicator = *mesh.communicator;
  std::unique_ptr<AtomicFile> master;
  std::unique_ptr<AtomicFolder> folder;
  run_on_first(communicator, [&] {
    master = std::make_unique<AtomicFile>(target, cancel);
    folder = std::make_unique<AtomicFolder>(target.parent_path() / stem, target.filename().string(),
                                            [&](const std::string& name) { return is_piece_name(name, stem); });
  });
  const std::filesystem::path place = share_path(communicator, folder ? folder->temporary() : "");
  const PieceList list = make_list(mesh, stem);
  run_on_all(communicator, [&] {
    runner.for_each(mesh.local().size(), [&](std::size_t i) {
      const PartId part = mesh.local()[i];
      const PartMesh& part_mesh = mesh.parts.at(part).mesh;
      write_mesh_piece(make_mesh(part_mesh), sorted_globals(part_mesh), place / piece_name(stem, part.value), cancel,
                       runner);
      runner.advance();
    });
  });
  run_on_first(communicator, [&] { commit(list, *folder, *master); });
}

}  // namespace tetloom::detail
