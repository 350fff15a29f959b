#pragma once
// What a part tells those of its neighbours that it concerns.
#include <vector>

#include "mesher/parts/part_state.hpp"

namespace tetloom::parts {

/// Sends to every neighbour, as one array, what `find(neighbour, its box, found)` appends; nothing where it finds none.
template <class T, class Find>
void send_found(const SharedInput& input, PartTask& task, Find&& find) {
  for (const PartId other : input.decomposition.neighbors(task.part())) {
    std::vector<T> found;
    find(other, input.decomposition.box(other), found);
    if (found.empty()) continue;
    MessageWriter writer;
    writer.put_array<T>(found);
    task.send(other, writer.take());
  }
}

}  // namespace tetloom::parts
