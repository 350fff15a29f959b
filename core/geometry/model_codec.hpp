#pragma once
// What is known of a model without its shapes, packed into bytes.
#include <array>
#include <vector>

#include "tetloom/model.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

void put_topology(MessageWriter& writer, const ModelTopology& topology);
ModelTopology get_topology(MessageReader& reader);

void put_attributes(MessageWriter& writer, const EntityAttributes& attributes);
EntityAttributes get_attributes(MessageReader& reader);

}  // namespace tetloom
