// A file that holds one mesh, read by all ranks, of which each has a slice.
#include <array>
#include <optional>
#include <utility>

#include "core/io/file_slice.hpp"
#include "core/part/convert.hpp"
#include "tetloom/error.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/owned_elements.hpp"

namespace tetloom {
namespace {

template <std::size_t N>
std::int64_t count_owned(const BoundaryBlock& block, OwnedElements& owned) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < block.size(); ++i) {
    std::array<std::uint32_t, N> verts;
    std::copy_n(&block.to_vert[i * N], N, verts.begin());
    count += owned.has(verts) ? 1 : 0;
  }
  return count;
}

// Whether every element of the file is in some part.
bool has_all(const PartitionedMesh& mesh, const FileCounts& file) {
  std::array<std::int64_t, 3> counts{};
  for (const PartId id : mesh.local()) {
    const Part& part = mesh.parts.at(id);
    OwnedElements owned(part, id);
    counts[0] += static_cast<std::int64_t>(part.mesh.cell_count());
    counts[1] += count_owned<3>(part.mesh.block(BoundaryKind::Triangle), owned);
    counts[2] += count_owned<2>(part.mesh.block(BoundaryKind::Edge), owned);
  }
  mesh.communicator->sum(counts);
  return counts == std::array{static_cast<std::int64_t>(file.tets), static_cast<std::int64_t>(file.triangles),
                              static_cast<std::int64_t>(file.edges)};
}

// What only the whole file shows to be unsuitable is told of by those who read it as a whole.
template <class Work>
auto unless_unsuitable(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InputUnsuitable) throw;
    return {};
  }
}

}  // namespace

std::optional<SlicedMesh> read_slices(const std::filesystem::path& path, Communicator& communicator,
                                      const TaskRunner& runner, const CancelToken* cancel) {
  if (!has_slices(path)) return {};
  const auto ranks = static_cast<std::size_t>(communicator.rank_count());
  const auto rank = static_cast<std::size_t>(communicator.rank());
  SlicedMesh sliced{PartitionedMesh(communicator, ranks), 0};
  PartitionedMesh& mesh = sliced.mesh;
  FileCounts file;
  std::uint64_t unfit = 0;
  run_on_all(communicator, [&] {
    std::optional<FileSlice> slice =
        unless_unsuitable([&]() -> std::optional<FileSlice> { return read_slice(path, rank, ranks, cancel); });
    std::optional<PartMesh> part = unless_unsuitable([&]() -> std::optional<PartMesh> {
      if (!slice) return {};
      return make_part(slice->piece.mesh, slice->piece.global_ids);
    });
    unfit = part ? 0 : 1;
    if (!part) return;
    file = slice->file, sliced.points = file.points;
    for (const VertexField& field : part->vertex_fields) mesh.vertex_fields.push_back({field.name, field.components});
    for (const CellField& field : part->cell_fields) mesh.cell_fields.push_back({field.name, field.components});
    mesh.parts.at(PartId(rank)).mesh = std::move(*part);
  });
  if (sum_over_ranks(communicator, unfit) > 0) return {};
  return unless_unsuitable([&]() -> std::optional<SlicedMesh> {
    link_parts(mesh, runner);
    if (!has_all(mesh, file)) return {};
    return std::move(sliced);
  });
}

}  // namespace tetloom
