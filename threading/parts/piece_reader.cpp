#include <algorithm>
#include <set>

#include "core/io/mesh_piece.hpp"
#include "core/part/convert.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/parts_io_detail.hpp"

namespace tetloom::detail {
namespace {

/// Names the file, where the message does not do so itself.
Diagnostic in_file(const std::filesystem::path& file, Diagnostic diagnostic) {
  const std::string name = "'" + file.string() + "'";
  if (diagnostic.code != ErrorCode::Cancelled && diagnostic.message.find(name) == std::string::npos)
    diagnostic.message = name + ": " + diagnostic.message;
  return diagnostic;
}

template <class Fields>
std::vector<PieceList::Field> shapes_of(const Fields& fields) {
  std::vector<PieceList::Field> shapes;
  for (const auto& field : fields) shapes.push_back({field.name, field.components});
  return shapes;
}

/// A part without anything has the fields of the others, without values.
PartMesh empty_part(const PieceList& list) {
  PartMesh part;
  for (const PieceList::Field& field : list.point_fields)
    part.vertex_fields.push_back({field.name, field.components, {}});
  for (const PieceList::Field& field : list.cell_fields) part.cell_fields.push_back({field.name, field.components, {}});
  return part;
}

std::size_t element_count(const PartMesh& part) {
  std::size_t count = part.cell_count();
  for (const BoundaryBlock& block : part.boundary) count += block.size();
  return count;
}

PartMesh read_piece(const PieceList& list, std::size_t index, const std::filesystem::path& file,
                    const CancelToken* cancel) {
  const PieceList::Piece& listed = list.pieces[index];
  const MeshPiece piece = read_mesh_piece(file, cancel);
  if (piece.mesh.points.size() != listed.points)
    throw Error(ErrorCode::InputUnreadable, "the piece has " + std::to_string(piece.mesh.points.size()) +
                                                " points, but " + std::to_string(listed.points) +
                                                " by the list of pieces");
  PartMesh part = piece.mesh.points.empty() ? empty_part(list) : make_part(piece.mesh, piece.global_ids);
  if (element_count(part) != listed.cells || part.vertex_count() != listed.points)
    throw Error(ErrorCode::InputUnreadable, "the piece has other elements than the list of pieces says");
  if (shapes_of(part.vertex_fields) != list.point_fields || shapes_of(part.cell_fields) != list.cell_fields)
    throw Error(ErrorCode::InputUnreadable, "the piece has other fields than the list of pieces says");
  return part;
}

class PieceReader {
 public:
  PieceReader(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
              const CancelToken* cancel)
      : path_(path), communicator_(communicator), runner_(runner), cancel_(cancel) {}

  PartsAsTheyAre read() {
    run_on_all(communicator_, [&] {
      list_ = read_piece_list(path_, cancel_);
      require_distinct_files();
    });
    require_same_list();
    PartitionedMesh mesh(communicator_, list_.pieces.size());
    for (const auto& field : list_.point_fields) mesh.vertex_fields.push_back({field.name, field.components});
    for (const auto& field : list_.cell_fields) mesh.cell_fields.push_back({field.name, field.components});
    read_local(mesh);
    link_parts(mesh, runner_);
    std::optional<Diagnostic> misfit = find_misfit(mesh);
    return {std::move(mesh), std::move(misfit)};
  }

 private:
  std::filesystem::path file_of(std::size_t part) const {
    return path_.parent_path() / std::filesystem::path(list_.pieces[part].source);
  }

  void require_distinct_files() const {
    std::set<std::string> names;
    for (const PieceList::Piece& piece : list_.pieces)
      if (!names.insert(piece.source).second)
        throw Error(ErrorCode::InputUnreadable,
                    "'" + path_.string() + "': the piece '" + piece.source + "' is listed twice");
  }

  // Ranks on machines of their own may see another state of the file.
  void require_same_list() const {
    std::array<double, 2> counts{static_cast<double>(list_.pieces.size()), -static_cast<double>(list_.pieces.size())};
    communicator_.max(counts);
    if (counts[0] != -counts[1])
      throw Error(ErrorCode::InputUnreadable, "'" + path_.string() + "': not all ranks see the same file");
  }

  void read_local(PartitionedMesh& mesh) {
    const auto local = mesh.local();
    std::vector<std::optional<Diagnostic>> failures(local.size());
    run_on_all(communicator_, [&] {
      runner_.for_each(local.size(), [&](std::size_t i) {
        const std::filesystem::path file = file_of(local[i].value);
        failures[i] =
            failure_of([&] { mesh.parts.at(local[i]).mesh = read_piece(list_, local[i].value, file, cancel_); });
        if (failures[i]) failures[i] = in_file(file, std::move(*failures[i]));
        runner_.advance();
      });
      for (const std::optional<Diagnostic>& failure : failures)
        if (failure) throw Error(*failure);
    });
  }

  /// Of the lowest rank that has one; known to all.
  std::optional<Diagnostic> find_misfit(PartitionedMesh& mesh) {
    const PartsReport report = validate_parts(mesh, runner_);
    if (report.valid()) return find_wrong_totals(mesh);
    try {
      agree(communicator_, first_problem(report));
    } catch (const Error& error) {
      return error.diagnostic();
    }
    throw Error(ErrorCode::Internal, "problems of parts are counted and not listed");
  }

  std::optional<Diagnostic> first_problem(const PartsReport& report) const {
    // A problem with a point says more.
    const PartProblem* shown = nullptr;
    for (const PartProblem& problem : report.problems)
      if (shown == nullptr || (!shown->point && problem.point)) shown = &problem;
    if (shown == nullptr) return std::nullopt;
    return Diagnostic{ErrorCode::InputUnsuitable,
                      "'" + file_of(shown->part.value).string() + "' does not fit the other pieces: " + shown->message +
                          (shown->count > 1 ? " (" + std::to_string(shown->count) + " times)" : ""),
                      {},
                      shown->point,
                      {}};
  }

  std::optional<Diagnostic> find_wrong_totals(const PartitionedMesh& mesh) const {
    const PartsFigures figures = measure_parts(mesh);
    const PieceList::Totals found{static_cast<std::uint64_t>(figures.vertices),
                                  static_cast<std::uint64_t>(figures.cut_faces)};
    if (found == list_.totals) return std::nullopt;
    return Diagnostic{ErrorCode::InputUnsuitable,
                      "'" + path_.string() + "': the pieces have " + std::to_string(found.points) + " points and " +
                          std::to_string(found.cut_faces) + " faces between them, but " +
                          std::to_string(list_.totals.points) + " and " + std::to_string(list_.totals.cut_faces) +
                          " by the list: they do not belong together",
                      {},
                      {},
                      {}};
  }

  const std::filesystem::path path_;
  Communicator& communicator_;
  const TaskRunner& runner_;
  const CancelToken* cancel_;
  PieceList list_;
};

}  // namespace

PartsAsTheyAre read_pieces(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
                           const CancelToken* cancel) {
  return PieceReader(path, communicator, runner, cancel).read();
}

}  // namespace tetloom::detail
