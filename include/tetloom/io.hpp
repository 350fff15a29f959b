#pragma once
// Meshes and solutions in files; parts of a mesh are in partition.hpp.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

// Reading and writing meshes. The format follows from the file's extension, in upper or lower case:
//
//   .vtu           VTK XML unstructured grid; holds everything that a Mesh holds
//   .msh           Gmsh 4.1, binary when written; holds classification, names (up to 255 bytes), face sides and fields
//                  (as views; Gmsh itself shows those of 1, 3 and 9 components)
//   .mesh, .meshb  MEDIT, text or binary; holds the entity of every element, but no fields; points are classified from
//                  the elements. Triangles of a face with a region on one side point out of it, as FreeFEM wants
//                  them
//   .med           MED 4.1 of Salome and Code_Aster; holds the entity of every element and point, a group for each
//                  entity, see `solver_names`; no fields
//   .cgns          CGNS 3.4 in HDF5; a section for each group of `solver_names`, a boundary condition and a family for
//                  each face; no fields. Elements come back in the order of sections
//   .vtkhdf        VTKHDF 1.0, written only; what .vtu holds, but of attributes only the names
//   .stl           triangles alone, in single precision
//
// For solvers; of these, .inp, .su2, .msh and .ugrid are read as well, names of sets, surfaces and markers as those of
// entities:
//
//   .inp           Abaqus, CalculiX: an ELSET for every region, an NSET and a SURFACE for every face, NSETs for edges
//                  and vertices
//   .foam          a folder, an OpenFOAM case whose constant/polyMesh is written; a folder polyMesh is written itself.
//                  Faces are patches, regions are cell zones, faces between regions are face zones
//   .su2           SU2: a marker for every face on the boundary
//   .ugrid, .lb8.ugrid, .b8.ugrid
//                  UGRID of AFLR3 and FUN3D: text, or a stream of 32-bit integers and 64-bit reals, little- or
//                  big-endian. Cells, and faces by their tags, which point into the domain here; no regions, no edges.
//                  The .mapbc file beside it, wing.mapbc of wing.lb8.ugrid, has the tag, the code of the boundary
//                  condition and the name of every face. A code stays where the file is there already, and is 0 else
//   .bdf           Nastran: a property for every region and face, named in comments
//   .exo           Exodus II in netCDF: a block for every region, a side set and a node set for every face, node sets
//                  for edges and vertices; no fields
//   .msh           in version 2.2, see WriteOptions: a physical group for every edge, face and region
//
// Meshes of second order are held by .vtu, .vtkhdf, .msh of both versions, .inp, .bdf, .med, .cgns and .exo.
//
// Their groups have the names of the model entities, as far as these formats take them: see `solver_names`. Triangles
// of faces with a region on one side point out of it in these formats but .ugrid.
//
// What a format cannot hold is left out. In .vtu, the names entity_dim and entity_tag, and region on cells, belong to
// the classification: arrays under them are no fields, nor is the array of a file from elsewhere that stands in for
// entity_tag (see README.md); nor are 64-bit unsigned integers called global_id on points (see mesh_piece.hpp). Values
// of fields are read from any type of number and written as 64-bit reals.
//
// In all formats an entity is written as its tag (index + 1), and 0 stands for an unknown one.

namespace tetloom {

/// Whether `path` ends in an extension that `read_mesh` knows. Does not look at the file.
bool is_mesh_extension(const std::filesystem::path& path);

/// Whether `path` ends in an extension that `write_mesh` knows.
bool is_writable_mesh_format(const std::filesystem::path& path);

/// Whether `path` ends in an extension of a format that holds meshes of second order.
bool holds_second_order(const std::filesystem::path& path);

/// ".inp, .mesh, .meshb, .msh, .stl, .su2, .vtu", for messages: those that are read.
std::string known_mesh_extensions();

/// Those that are written.
std::string writable_mesh_extensions();

/// What `write_mesh` may be told of a format.
struct WriteOptions {
  bool msh_2_2 = false;  ///< .msh in version 2.2 in place of 4.1
  bool text = false;     ///< .msh of version 2.2 as text
};

/// A model entity of which a mesh has something, and what files for solvers call it.
struct NamedGroup {
  ModelEntity entity;
  std::string original;   ///< may be empty
  std::string sanitised;  ///< letters, digits and underscores, a letter first; at most 64; no two alike in any case
};

/// The names of groups in files for solvers: those of the entities with every run of other characters as an underscore,
/// and a number behind where two would be the same; "region_2", "face_12", "edge_7", "vertex_1" of entities without.
/// Ascending by dimension, then by tag. Linear.
std::vector<NamedGroup> solver_names(const Mesh& mesh);

/// Whether files of that format have groups under these names.
bool holds_solver_names(const std::filesystem::path& path, const WriteOptions& options = {});

/// Writes `mesh` to `path`, completely or not at all (see AtomicFile). What it writes, `read_mesh` reads back the same,
/// as far as the format holds it; numbers are kept bit for bit in all formats but .stl.
/// Errors: InvalidArgument (unknown extension; array lengths or indices of the mesh do not fit; fields without a name,
/// with the same one, or in .vtu with one of the classification's; .stl without triangles; a tag beyond the 31 bits
/// that .msh and old .meshb readers allow), OutputFailed with the system's reason, Cancelled. `loop` carries out the
/// work; no byte depends on it. Takes some MiB beside the mesh, and for .msh 4 bytes per point and element.
/// Thread safety: may be called by several threads, for different paths.
void write_mesh(const Mesh& mesh, const std::filesystem::path& path, const CancelToken* cancel = nullptr,
                const BlockLoop& loop = serial_loop());

/// The same, in the form that the options ask for.
void write_mesh(const Mesh& mesh, const std::filesystem::path& path, const WriteOptions& options,
                const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

/// Reads cells, quadrilaterals, triangles, edges, points and fields from `path`. Understands, beside what `write_mesh`
/// makes: VTU as text, base64 or raw, compressed by zlib or not, of any byte order and number of pieces; MSH 4.1
/// and 2.2 as text and binary; Abaqus files of one part; SU2 files of one zone; MEDIT text and binary versions 1 to 4
/// of either byte order, with any keywords; STL as text or binary. Elements without an entity get the index Id::kNone,
/// points without one an invalid ModelEntity. Where a file has entities for elements only, points are classified on the
/// lowest-dimensional elements that use them, as far as those agree. Of fields on elements those on cells are kept;
/// where an .msh file has no value for a point or a cell, that is NaN, and of several time steps it is the first that
/// counts. Vertices that an STL file repeats become one point.
///
/// Errors: InvalidArgument (unknown extension); InputUnreadable with the place in the file (missing, no regular file,
/// empty, truncated, of another format, indices out of range, fields of another length than what they hang on);
/// InputUnsuitable (elements of another kind, which it names, or a variant of a format that is not supported);
/// OutOfMemory; Cancelled. Nothing is allocated on the word of a count in the file that the size of the file does not
/// back. Thread safety: may be called from any thread.
Mesh read_mesh(const std::filesystem::path& path, const CancelToken* cancel = nullptr);

// Reading and writing solutions in files of their own, beside a mesh: .sol and .solb, MEDIT's text and binary form.
//
// A file holds values at the points of a mesh and at its tets. Solutions have no names there; when they are read they
// are called solution_1, solution_2 … for each carrier. What they are follows from their number of components, in a
// mesh of three dimensions: 1 a scalar, 3 a vector, 6 a symmetric tensor in the order xx xy yy xz yz zz (not the order
// that VTK has), 9 a matrix row by row. Values may be infinite or NaN.

/// Fields on a mesh.
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
/// What a process has of the items of a mesh.
struct SolutionShare {
  std::span<const std::uint64_t> points;  ///< numbers of points, ascending
  std::uint64_t first_tet = 0, tets = 0;  ///< tets with consecutive numbers
};
/// The same for a process that has some of the mesh: values at its points and tets alone, in their order. A few
/// megabytes of the file are in memory at once; it must not become shorter meanwhile. Errors: also InvalidArgument for
/// items that the mesh does not have.
Solution read_solution_at(const SolutionShare& share, const std::filesystem::path& path, const SolutionSize& size,
                          const CancelToken* cancel = nullptr);

/// Writes `solution` to `path`, completely or not at all (see AtomicFile); `read_solution` reads back the same values,
/// bit for bit. Errors: InvalidArgument (unknown extension; nothing to write; values of another length than `size`
/// says; a number of components that MEDIT does not know), OutputFailed with the system's reason, Cancelled. `loop`
/// carries out the work; no byte depends on it. Thread safety: may be called by several threads, for different paths.
void write_solution(const Solution& solution, const SolutionSize& size, const std::filesystem::path& path,
                    const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
