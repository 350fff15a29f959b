#pragma once
// Meshes in parts: how they are made, dealt anew, measured, checked, read and written.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"
#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/part_mesh.hpp"
#include "tetloom/tasks.hpp"

// A mesh in parts: each part a serial mesh, and for everything on part boundaries where its copies are.

namespace tetloom {

/// The same vertex, edge or face in another part: its place in that part's own list for vertices the local vertex,
/// for edges and faces the position in `PartBoundary::edges` or `faces` there.
struct Copy {
  PartId part;
  std::uint32_t local = 0;
  friend constexpr auto operator<=>(const Copy&, const Copy&) = default;
};

/// The entities of one dimension that other parts have too, each with its copies elsewhere.
template <class Entity>
struct SharedEntities {
  GrowingArray<Entity> entities;      ///< ascending
  GrowingArray<std::uint32_t> first;  ///< of the copies of each; one longer than `entities`, or empty
  GrowingArray<Copy> copies;          ///< ascending for each entity
  std::size_t size() const { return entities.size(); }
  std::span<const Copy> copies_of(std::size_t i) const {
    return copies.span().subspan(first[i], first[i + 1] - first[i]);
  }
};

/// The lowest part that has a copy owns the entity.
inline PartId owner_of(std::span<const Copy> copies, PartId self) {
  return copies.empty() ? self : std::min(self, copies.front().part);
}

/// What a part shares with others.
struct PartBoundary {
  SharedEntities<std::uint32_t> vertices;              ///< local vertices
  SharedEntities<std::array<std::uint32_t, 2>> edges;  ///< local vertices, ascending
  SharedEntities<CellPlace> faces;                     ///< faces of this part's cells
  std::vector<PartId> neighbors;                       ///< parts with a copy of anything here, ascending
};

/// A part with its boundary.
struct Part {
  PartMesh mesh;
  PartBoundary boundary;
};

/// A field that all parts have.
struct FieldInfo {
  std::string name;
  int components = 1;
};

/// A mesh in `part_count` parts, those of this rank in memory. All ranks hold the same number of parts and the same
/// fields; parts may be empty.
///
/// Invariants, checked by validate_parts: links name each other from both sides; copies agree in global id,
/// coordinates and classification; all parts together are one conforming mesh.
struct PartitionedMesh {
  PartitionedMesh(Communicator& given, std::size_t part_count)
      : communicator(&given), parts(part_count, given.parts_of_rank(part_count)) {}

  std::size_t part_count() const { return parts.part_count(); }
  std::span<const PartId> local() const { return parts.local(); }

  Communicator* communicator;
  PerPart<Part> parts;
  std::vector<FieldInfo> vertex_fields, cell_fields;  ///< of every part, in this order
};

/// Links between neighbours; valid as long as `mesh` is.
Links links_of_neighbors(const PartitionedMesh& mesh);

/// Finds all copies anew from the global ids of vertices: everything in `PartBoundary`. A collective call.
/// Vertices on open faces meet at a home rank that follows from their global id; neighbours then match their lists of
/// shared vertices, edges and faces, which are ordered alike on both sides (the rendezvous of Tautges et al. 2012
/// finds vertices in the same way; edges and faces need no rendezvous then).
void link_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace = nullptr);

// Between a mesh in one piece and a mesh in parts.

/// `mesh` as part 0 of a mesh in one part, which lives on rank 0; what the other ranks give is not looked at. A
/// collective call. Errors: those of make_part, on all ranks.
PartitionedMesh distribute_mesh(const Mesh& mesh, Communicator& communicator);

/// Moves all cells to part 0 of one part. A collective call; errors as for migrate.
void gather_in_one_part(PartitionedMesh& mesh, const TaskRunner& runner);

/// The whole mesh on rank 0, and an empty one on the others. Points stand by global id; cells by part, then in the
/// order of their part. A collective call; takes the memory of the whole mesh, several times over, on rank 0.
Mesh gather_mesh(const PartitionedMesh& mesh, const TaskRunner& runner);

// Moving cells between parts, with everything that belongs to them.

/// Where each cell of a part goes: tets, then pyramids, prisms and hexahedra, in the order of their blocks.
using Destinations = std::vector<std::uint32_t>;

/// What a migration has sent.
struct MigrationFigures {
  std::uint64_t cells_sent = 0;  ///< to another part, on all ranks
  std::uint64_t bytes_sent = 0;  ///< of all packets, on all ranks
};

/// Deals all cells anew: each goes to the part that `destinations` names for it, of `part_count` parts, which may be
/// fewer or (many) more than before. What travels: vertices with global ids, coordinates and classification, boundary
/// elements, values of all fields, and the model entities that the receiver needs. Links are found anew. A collective
/// call; `destinations` is emptied, to save memory.
///
/// Laws: the mesh as a whole is unchanged. The parts depend on the old parts and the destinations only: within a new
/// part the cells stand by old part, then in their old order, and vertices in the order in which cells use them.
/// Memory: the packets beside the cells' vertices, at the peak 1.41 times the mesh from 1 part to 16, and up to 1.7
/// times from 64 to 16,384; neighbours are dropped first and computed by the receiver.
///
/// Errors: InvalidArgument (a destination beyond `part_count`, a list of the wrong length), Cancelled, OutOfMemory.
/// After an error before the packets are complete, `mesh` is as it was, though its neighbours were computed anew. From
/// then on cancellation waits for the end.
MigrationFigures migrate(PartitionedMesh& mesh, PerPart<Destinations> destinations, std::size_t part_count,
                         const TaskRunner& runner, Trace* trace = nullptr);

// Where the cells of a partitioned mesh should go.

/// How cells are dealt to parts.
enum class PartitionMethod {
  Multilevel,  ///< by the graph of tets, through clusters (multilevel.hpp), where a part of tets is cut on its own;
               ///< otherwise, and for small parts, as Rcb
  Rcb,         ///< recursive bisection by planes; part boundaries are smoothed then
  Sfc,         ///< along a Hilbert curve
  Scotch       ///< graph partitioning: by Scotch, or by Zoltan where parts that are dealt anew lie on several ranks
};

std::string_view to_string(PartitionMethod method);

/// The cell field, of one component, that says which stack of a boundary layer a cell belongs to: a positive integer,
/// the same for all cells above one wall triangle; 0 for none.
inline constexpr std::string_view kStackField = "stack";

/// How many parts, and how equal they are to be.
struct BalanceOptions {
  std::size_t part_count = 1;
  PartitionMethod method = PartitionMethod::Multilevel;
  std::string weights;      ///< a cell field of one positive component; empty: 1 for each cell
  double imbalance = 0.03;  ///< how much heavier than the mean a part may become for a smaller boundary
  bool smooth = true;       ///< smooth part boundaries after Rcb
};

/// The destinations for `migrate`. Where the number of parts grows by a whole factor and the parts are in balance, each
/// part is cut on its own, and its pieces get neighbouring numbers; otherwise all cells are dealt anew.
///
/// Where the mesh has the field kStackField, all cells of a stack go to one part, also those that came in several.
///
/// A collective call. The result depends on the parts and the options only. Boundaries are smoothed where all cells of
/// a target lie in one part, and all cells are tets without stacks.
/// Errors: InvalidArgument (no part, a field that is not there or has values that are not positive), OutOfMemory,
/// Cancelled.
PerPart<Destinations> compute_destinations(const PartitionedMesh& mesh, const BalanceOptions& options,
                                           const TaskRunner& runner);

/// Computes the destinations and moves the cells there. A collective call; errors are those of both.
void deal_cells(PartitionedMesh& mesh, const BalanceOptions& options, const TaskRunner& runner);

// How large the parts of a mesh are, and how much of them lies on part boundaries.

/// Imbalance is the greatest value of a part over the mean, less one.
struct PartsFigures {
  struct Row {
    std::int64_t elements = 0, vertices = 0;
    std::int64_t shared_vertices = 0;  ///< those that other parts have too
    std::int64_t neighbours = 0;       ///< parts that it shares a face with
    double weight = 0;
  };
  std::vector<Row> parts;
  std::int64_t elements = 0, vertices = 0;  ///< of the whole mesh, each once
  std::int64_t cut_faces = 0;               ///< faces between parts, each once
  std::int64_t edges = 0;                   ///< of the graph of parts: pairs that share a face
  double element_imbalance = 0, vertex_imbalance = 0, weight_imbalance = 0;
};

/// Figures of all parts, the same on all ranks. Weights are the values of a cell field added up in the order of the
/// cells; without a name, each cell weighs 1. A collective call. Errors: InvalidArgument when the field is not there,
/// has more than one component or values that are not positive and finite.
PartsFigures measure_parts(const PartitionedMesh& mesh, const std::string& weights = {});

/// Throws the error that measure_parts would, on all ranks. A collective call.
void require_weights(const PartitionedMesh& mesh, const std::string& weights);

// The executable invariant of a partitioned mesh.

/// All problems of one sort in one part.
struct PartProblem {
  PartId part;
  std::string message;        ///< one sentence
  std::uint64_t count = 0;    ///< how many there are
  std::optional<Vec3> point;  ///< at the first of them
};

/// What is wrong with a mesh in parts.
struct PartsReport {
  std::vector<PartProblem> problems;  ///< of the parts of this rank, ascending by part
  std::uint64_t total = 0;            ///< problems on all ranks
  bool valid() const { return total == 0; }
};

/// Checks that arrays fit together; that neighbours inside a part name each other at the same face, and vertices name
/// corners of their own; that global ids are distinct within a part; that the copies listed for every shared
/// vertex are exactly the parts that have its global id; that links of vertices, edges and faces name each other from
/// both sides, and agree in global ids, coordinates and classification; that every face without a cell behind it is
/// either shared with exactly one part, where nothing is behind it either, or, in meshes with boundary elements, a
/// boundary element. So a mesh that passes, made of a conforming mesh, is one. Cells' volumes are left to
/// validate_mesh.
///
/// A collective call; never throws for a bad mesh. Linear in the cells, messages only between neighbours and for
/// finding global ids.
PartsReport validate_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace = nullptr);

// Partitioned meshes in files:
//
//   .pvtu  a list of pieces, and beside it a folder of its stem with one <stem>_<part>.vtu for each part, which
//          ParaView opens; every rank reads and writes the pieces of its own parts. Holds everything that a
//          PartitionedMesh holds.
//   .foam  written only: a case of OpenFOAM with the mesh of part 3 in processor3, by the rank that has the part.
//   .msh   Gmsh 4.1 with $PartitionedEntities, in one file, which rank 0 reads and writes: it has to hold the mesh as a
//          whole. Global ids are the order of the nodes.

/// Whether `path` ends in .pvtu, .foam or .msh.
bool is_writable_parts_format(const std::filesystem::path& path);
/// Whether `path` ends in .pvtu: a file that read_parts reads and read_mesh does not.
bool is_piece_list(const std::filesystem::path& path);

/// Whether `path` is a list of pieces by its name, or an MSH file with partitions. A collective call.
bool is_partitioned_file(const std::filesystem::path& path, Communicator& communicator);

/// Writes `mesh`, completely or not at all: a file or a folder that is there already is replaced only when everything
/// has been written, and nothing half-written stays after an error. A folder with anything but pieces in it is not
/// replaced. A process that is killed leaves its temporaries, and the old files as they were; only between the renaming
/// of the folder and that of the list, two calls next to each other, the old list would stand beside new pieces.
///
/// A collective call; with the same mesh, it makes the same bytes on any number of ranks and threads. Errors, the same
/// on all ranks: InvalidArgument (unknown extension, field names that the format cannot hold), OutputFailed, Cancelled,
/// OutOfMemory.
void write_parts(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                 const CancelToken* cancel = nullptr);

/// Reads what write_parts wrote, into as many parts, and links them; any other file that read_mesh reads becomes a mesh
/// in one part. Within a part, cells come in the order of the file and vertices by global id.
///
/// A collective call. Errors, the same on all ranks, with the file at fault and a point where there is one:
/// InputUnreadable (missing, truncated or damaged files, pieces of other sizes or with other fields than the list
/// says), InputUnsuitable (lists of others, without global ids; pieces that do not fit together as validate_parts and
/// the totals of the list see it; what make_part refuses), OutOfMemory, Cancelled.
PartitionedMesh read_parts(const std::filesystem::path& path, Communicator& communicator, const TaskRunner& runner,
                           const CancelToken* cancel = nullptr);

/// What a partitioned file holds, whether its pieces fit together or not.
struct PartsAsTheyAre {
  PartitionedMesh mesh;
  std::optional<Diagnostic> misfit;  ///< what does not fit, the same on all ranks; `mesh` is good for figures only then
};

/// The same for those who judge: pieces that do not fit together are no error.
PartsAsTheyAre read_parts_as_they_are(const std::filesystem::path& path, Communicator& communicator,
                                      const TaskRunner& runner, const CancelToken* cancel = nullptr);

/// A mesh of one file, and how many points the file has.
struct SlicedMesh {
  PartitionedMesh mesh;
  std::uint64_t points = 0;
};

/// The mesh of tets of one file, .vtu, .mesh or .meshb, in a part of consecutive tets for each rank, which has no more
/// of it while it reads: see read_mesh for what it is. Global ids are numbers of points in the file. Nothing, on all
/// ranks, for files of other names, for a mesh that read_mesh or make_part would refuse, and for one that has other
/// cells, quadrilaterals or mid nodes, or fewer tets than there are ranks. In a .vtu, arrays that are text, compressed
/// or in base64 are decoded as a whole, up to three at once. The file must not become shorter meanwhile.
/// A collective call. Errors, the same on all ranks: InputUnreadable, OutOfMemory, Cancelled.
std::optional<SlicedMesh> read_slices(const std::filesystem::path& path, Communicator& communicator,
                                      const TaskRunner& runner, const CancelToken* cancel = nullptr);

// A geometric model for several ranks.

/// The document that `read` gives, which is called on the first rank alone where the model can be stored
/// (`store_model`), and on all ranks where not. A stored model lies in a file in the folder for temporary files, one on
/// each machine, which is removed from there before this returns. Each rank has the topology, names and measures of all
/// entities, and holds the shapes that it was asked for last: those of one and a half times its share, of a quarter of
/// a megabyte at least. Questions are answered as by the model that `read` gave, to the last bit. A collective call, of
/// the library `tetloom::geometry`. Errors: of `read`, on all ranks alike; InputUnreadable where the file is lost
/// meanwhile.
ModelDocument read_model_on_ranks(const std::function<ModelDocument()>& read, Communicator& communicator,
                                  const BlockLoop& loop = serial_loop());

}  // namespace tetloom
