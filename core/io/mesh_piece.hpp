#pragma once
// The files of a mesh in pieces: one .vtu per piece, with the global ids of its points, and a .pvtu that lists them.
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

class AtomicFile;

/// One piece of a larger mesh. A piece may be empty.
struct MeshPiece {
  Mesh mesh;
  std::vector<std::uint64_t> global_ids;  ///< of the points; the same number in two pieces is the same point
};

/// Writes `mesh` as write_mesh does to .vtu, with `global_ids` as the array global_id of 64-bit integers on points.
/// Errors: those of write_mesh; InvalidArgument when there is not one id below 2^63 for each point, or when a field on
/// points is called global_id.
void write_mesh_piece(const Mesh& mesh, std::span<const std::uint64_t> global_ids, const std::filesystem::path& path,
                      const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

/// Reads back what write_mesh_piece made. Errors: those of read_mesh; InputUnsuitable for a file with points but
/// without the array global_id.
MeshPiece read_mesh_piece(const std::filesystem::path& path, const CancelToken* cancel = nullptr);

/// What a .pvtu says of the pieces.
struct PieceList {
  struct Piece {
    std::string source;  ///< path of the file, as seen from the folder of the .pvtu
    std::uint64_t points = 0, cells = 0;
  };
  struct Field {
    std::string name;
    int components = 1;
    friend bool operator==(const Field&, const Field&) = default;
  };
  /// Of the whole mesh: what only pieces that belong together add up to.
  struct Totals {
    std::uint64_t points = 0, cut_faces = 0;
    friend bool operator==(const Totals&, const Totals&) = default;
  };
  std::vector<Piece> pieces;
  std::vector<Field> point_fields, cell_fields;
  Totals totals;
};

/// Writes the list, which ParaView and others read as a "PUnstructuredGrid". Errors: those of AtomicFile.
void write_piece_list(const PieceList& list, AtomicFile& file);

/// Errors: InputUnreadable (no such file, no list of pieces), InputUnsuitable (one that write_piece_list did not make:
/// without global ids there is no way to tell which points of the pieces are the same), Cancelled.
PieceList read_piece_list(const std::filesystem::path& path, const CancelToken* cancel = nullptr);

}  // namespace tetloom
