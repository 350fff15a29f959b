#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <cctype>

#include "core/io/mesh_parts.hpp"
#include "core/io/solver/foam_writer.hpp"
#include "tetloom/io.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/parts_io_detail.hpp"

namespace tetloom {
namespace {

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

}  // namespace

bool is_piece_list(const std::filesystem::path& path) { return extension_of(path) == ".pvtu"; }

bool is_writable_parts_format(const std::filesystem::path& path) {
  return is_piece_list(path) || extension_of(path) == ".msh" || detail::is_foam_case(path);
}

bool is_partitioned_file(const std::filesystem::path& path, Communicator& communicator) {
  if (is_piece_list(path)) return true;
  if (extension_of(path) != ".msh") return false;
  return share_number(communicator, communicator.rank() == 0 && has_msh_parts(path) ? 1 : 0) != 0;
}

void write_parts(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                 const CancelToken* cancel) {
  if (!is_writable_parts_format(path))
    throw Error(ErrorCode::InvalidArgument,
                "'" + path.string() + "' is no partitioned file by its extension; known are .foam, .msh, .pvtu");
  if (is_piece_list(path)) return detail::write_pieces(mesh, path, runner, cancel);
  if (detail::is_foam_case(path)) return detail::write_foam_parts(mesh, path, runner, cancel);
  detail::write_partitioned(mesh, path, runner, cancel);
}

PartitionedMesh read_parts(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
                           const CancelToken* cancel) {
  PartsAsTheyAre parts = read_parts_as_they_are(path, communicator, runner, cancel);
  if (parts.misfit) throw Error(*parts.misfit);
  return std::move(parts.mesh);
}

PartsAsTheyAre read_parts_as_they_are(const std::filesystem::path& path, Communicator& communicator,
                                      const TaskRunner& runner, const CancelToken* cancel) {
  if (is_piece_list(path)) return detail::read_pieces(path, communicator, runner, cancel);
  if (extension_of(path) == ".msh") return {detail::read_partitioned(path, communicator, runner, cancel), {}};
  Mesh mesh;
  run_on_first(communicator, [&] { mesh = read_mesh(path, cancel); });
  return {distribute_mesh(mesh, communicator), {}};
}

}  // namespace tetloom
