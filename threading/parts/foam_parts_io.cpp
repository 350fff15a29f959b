// A case of OpenFOAM in parts: each rank writes the meshes of its own.
#include <memory>

#include "core/io/atomic_folder.hpp"
#include "core/io/solver/foam_mesh.hpp"
#include "core/io/solver/foam_writer.hpp"
#include "core/part/convert.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/group_names.hpp"
#include "threading/parts/parts_io_detail.hpp"

namespace tetloom::detail {
namespace {

FoamPart shared_faces_of(const Part& part, PartId number) {
  std::array<std::uint32_t, kCellKinds> first{};
  for (std::size_t kind = 1; kind < kCellKinds; ++kind)
    first[kind] = first[kind - 1] + static_cast<std::uint32_t>(part.mesh.cells[kind - 1].size());
  FoamPart foam{number.value, {}};
  const SharedEntities<CellPlace>& faces = part.boundary.faces;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const CellPlace place = faces.entities[i];
    const std::uint32_t cell = first[static_cast<std::size_t>(place.kind())] + place.cell();
    for (const Copy& copy : faces.copies_of(i)) foam.shared.push_back({cell, place.place(), copy.part.value});
  }
  return foam;
}

/// One part, ready to be written.
struct Piece {
  Mesh mesh;  // points by global id, so that both sides of a part boundary have them in one order
  std::unique_ptr<FoamMesh> foam;
  std::unique_ptr<AtomicFolder> folder;
};

std::vector<Piece> make_pieces(const PartitionedMesh& mesh, const Groups& groups, const TaskRunner& runner) {
  std::vector<Piece> pieces(mesh.local().size());
  run_on_all(*mesh.communicator, [&] {
    runner.for_each(pieces.size(), [&](std::size_t i) {
      const PartId part = mesh.local()[i];
      const Part& from = mesh.parts.at(part);
      pieces[i].mesh = make_mesh(from.mesh);
      pieces[i].foam = std::make_unique<FoamMesh>(pieces[i].mesh, groups, shared_faces_of(from, part), runner);
    });
  });
  return pieces;
}

/// Over all parts.
std::vector<std::int64_t> sum_counts(const PartitionedMesh& mesh, const std::vector<Piece>& pieces,
                                     std::size_t face_groups) {
  std::vector<std::int64_t> sums(2 * face_groups + 1, 0);
  for (const Piece& piece : pieces) {
    const std::vector<std::int64_t> counts = piece.foam->counts();
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += counts[i];
  }
  mesh.communicator->sum(sums);
  return sums;
}

/// All folders take their places, or none.
void swap_in(Communicator& communicator, std::vector<Piece>& pieces) {
  std::size_t done = 0;
  try {
    run_on_all(communicator, [&] {
      for (; done < pieces.size(); ++done) pieces[done].folder->swap_in();
    });
  } catch (...) {
    for (std::size_t i = 0; i < done; ++i) pieces[i].folder->swap_back();
    throw;
  }
}

}  // namespace

void write_foam_parts(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                      const CancelToken* cancel) {
  Communicator& communicator = *mesh.communicator;
  run_on_first(communicator, [&] { prepare_foam_parts(path, mesh.part_count(), cancel); });
  const GroupNames names = gather_group_names(mesh);
  std::vector<Piece> pieces = make_pieces(mesh, names.groups, runner);
  const std::vector<std::int64_t> counts = sum_counts(mesh, pieces, names.groups[2].size());
  run_on_all(communicator, [&] {
    runner.for_each(pieces.size(), [&](std::size_t i) {
      pieces[i].folder = std::make_unique<AtomicFolder>(foam_part_folder(path, mesh.local()[i].value), "polyMesh",
                                                        FoamMesh::is_file_name);
      pieces[i].foam->write(pieces[i].folder->temporary(), counts, cancel);
      runner.advance();
    });
  });
  swap_in(communicator, pieces);
}

}  // namespace tetloom::detail
