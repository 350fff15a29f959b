#pragma once
// Meshes in parts for tests, ways of dealing their cells, and what must not change when they are dealt.
#include <cstdint>
#include <string>
#include <vector>

#include "core/part/adjacency.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::test {

/// A box of tets or of all kinds of cells, with fields whose values name their vertex or cell; for most seeds its model
/// entities have names, colours and tolerances.
Mesh make_case(unsigned seed);

/// Calls visit(cell, position in the part's list of destinations).
template <class Visit>
void for_each_cell(const PartMesh& part, const Visit& visit) {
  std::size_t position = 0;
  for (const CellKind kind : kAllCellKinds)
    for (std::uint32_t i = 0; i < part.block(kind).size(); ++i) visit(CellId{kind, i}, position++);
}

enum class Dealing { Scatter, Slabs, Strip, AllToOne, Last };
Dealing dealing_of(std::uint64_t number);

/// Depends on the parts' contents alone, so that all ranks and all kinds of communicators deal alike.
PerPart<Destinations> deal(const PartitionedMesh& mesh, std::size_t part_count, Dealing dealing, std::uint64_t seed);

/// What stays the same of a mesh, however it is dealt.
struct Whole {
  std::string digest, fields;
  double volume = 0;
  std::string entities;
};
Whole describe_whole(const Mesh& mesh);

/// Gathers the mesh and compares, on rank 0. A collective call.
void check_whole(const PartitionedMesh& mesh, const TaskRunner& runner, const Whole& expected);
/// validate_parts finds nothing. A collective call.
void check_links(PartitionedMesh& mesh, const TaskRunner& runner);

/// For each part, in order and on all ranks, a hash over all of its arrays. A collective call.
std::vector<std::uint64_t> hash_parts(const PartitionedMesh& mesh);

}  // namespace tetloom::test
