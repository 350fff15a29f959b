#pragma once
// In which parts a vertex lives, found without knowing anything but global ids.
#include <cstdint>
#include <vector>

#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// A vertex that other parts may have, too.
struct OpenVertex {
  std::uint64_t global = 0;
  std::uint32_t vert = 0;
  std::uint32_t padding = 0;
};

/// The shared vertices of one part, ascending by global id, each with the other parts that have it, ascending.
struct Residence {
  std::vector<std::uint32_t> verts;
  std::vector<std::uint32_t> first{0};  ///< one longer than `verts`
  std::vector<PartId> parts;
};

/// A collective call; `open_verts` of each part ascend by global id. They are sent to the home of their global id,
/// which answers with the parts that named the same id; the homes of one rank are buckets of ids, each sorted by a task
/// of its own.
PerPart<Residence> find_residence(const PerPart<std::vector<OpenVertex>>& open_verts, Communicator& communicator,
                                  const TaskRunner& runner);
/// The same for the vertices on open faces.
PerPart<Residence> find_residence(const PartitionedMesh& mesh, const TaskRunner& runner);

}  // namespace tetloom
