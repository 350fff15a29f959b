#pragma once
// Files that hold one mesh, read by several readers of which each keeps a slice.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>

#include "core/io/mesh_piece.hpp"
#include "tetloom/host.hpp"

namespace tetloom {

/// How much a file holds.
struct FileCounts {
  std::uint64_t points = 0, tets = 0, triangles = 0, edges = 0;
};

/// One slice of a file: some of its tets, in their order, with their points and with the triangles and edges that they
/// have. Global ids are the numbers of points in the file.
struct FileSlice {
  MeshPiece piece;
  FileCounts file;
};

/// Whether files of this name are read by slices: .vtu, .msh, .mesh and .meshb.
bool has_slices(const std::filesystem::path& path);

/// The tets from n · index / count to n · (index + 1) / count of a file with n of them, with fields as read_mesh reads
/// them. Nothing for files with other cells, quadrilaterals, mid nodes or fewer tets than `count`, and for a .msh in
/// which the tags of nodes or tets have gaps, or which is in parts. The file must not
/// become shorter meanwhile. It takes no more memory than the slice; in a .vtu with arrays that are text, compressed or
/// in base64, three of these as well. Pre: index < count, has_slices(path). Errors: those of read_mesh, as far as the
/// slice shows them.
std::optional<FileSlice> read_slice(const std::filesystem::path& path, std::size_t index, std::size_t count,
                                    const CancelToken* cancel = nullptr);

}  // namespace tetloom
