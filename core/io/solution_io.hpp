#pragma once
// Reading and writing solutions in files of their own, beside a mesh: .sol and .solb, MEDIT's text and binary form.
//
// A file holds values at the points of a mesh and at its tets. Solutions have no names there; when they are read they
// are called solution_1, solution_2 … for each carrier. What they are follows from their number of components, in a
// mesh of three dimensions: 1 a scalar, 3 a vector, 6 a symmetric tensor in the order xx xy yy xz yz zz (not the order
// that VTK has), 9 a matrix row by row. Values may be infinite or NaN.
#include <filesystem>
#include <string>
#include <vector>

#include "core/base/block_loop.hpp"
#include "core/base/progress.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom {

struct Solution {
  std::vector<MeshField> point_fields;  ///< one tuple per point
  std::vector<MeshField> tet_fields;    ///< one tuple per tet
};

/// How many items the mesh has on which a solution hangs.
struct SolutionSize {
  std::size_t points = 0;
  std::size_t tets = 0;
};
inline SolutionSize solution_size(const Mesh& mesh) { return {mesh.points.size(), mesh.tet_to_vert.size()}; }

/// Whether `path` ends in .sol or .solb, in upper or lower case.
bool is_solution_extension(const std::filesystem::path& path);

/// Reads the solutions of a file that belongs to a mesh of `size`: MEDIT text and binary versions 1 to 4, of either
/// byte order. Values on other elements than tets are skipped.
/// Errors: InvalidArgument (unknown extension); InputUnreadable with the place in the file (missing, no regular file,
/// empty, truncated, of another format); InputUnsuitable (no values at points or tets, or for another number of them
/// than the mesh has; a kind of value that is unknown); OutOfMemory; Cancelled. Nothing is allocated on the word of a
/// count in the file that the size of the file does not back. Thread safety: may be called from any thread.
Solution read_solution(const std::filesystem::path& path, const SolutionSize& size,
                       const CancelToken* cancel = nullptr);

/// Writes `solution` to `path`, completely or not at all (see AtomicFile); `read_solution` reads back the same values,
/// bit for bit. Errors: InvalidArgument (unknown extension; nothing to write; values of another length than `size`
/// says; a number of components that MEDIT does not know), OutputFailed with the system's reason, Cancelled. `loop`
/// carries out the work; no byte depends on it. Thread safety: may be called by several threads, for different paths.
void write_solution(const Solution& solution, const SolutionSize& size, const std::filesystem::path& path,
                    const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
