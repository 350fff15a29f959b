#pragma once
// Stacks of boundary layers go to one part each: to partitioners, a stack is one item.
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::balance_detail {

/// The cells of a part as items: first every cell that is in no stack, in the order of their numbers, then the stacks.
struct StackItems {
  std::vector<std::uint32_t> cell_to_item;  ///< by cell number; empty: there are no stacks, every cell is an item
  std::vector<std::uint64_t> stacks;        ///< their values in the field, ascending
  std::size_t count = 0;                    ///< of items

  bool has_stacks() const { return !stacks.empty(); }
  std::size_t first_stack() const { return count - stacks.size(); }
};

/// Reads the cell field kStackField of one component, where the part has it. Values that are no positive integers
/// stand for no stack.
StackItems find_stack_items(const PartMesh& part);

/// What each cell has from its item.
Destinations destinations_of_cells(const StackItems& items, Destinations item_targets);

/// Sends stacks that lie in several parts, or are bound for several, to one: where most of their cells are bound, the
/// lowest of equals. A collective call. The result depends on the parts and the destinations alone.
void unite_stacks(const PartitionedMesh& mesh, const PerPart<StackItems>& items, PerPart<Destinations>& destinations);

}  // namespace tetloom::balance_detail
