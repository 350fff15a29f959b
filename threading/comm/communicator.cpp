#include "tetloom/communicator.hpp"

namespace tetloom {

std::vector<PartId> Communicator::parts_of_rank(std::size_t part_count) const {
  const auto ranks = static_cast<std::size_t>(rank_count()), own = static_cast<std::size_t>(rank());
  const auto first_of = [&](std::size_t which) { return (which * part_count + ranks - 1) / ranks; };
  std::vector<PartId> parts;
  for (std::size_t part = first_of(own); part < first_of(own + 1); ++part) parts.push_back(PartId(part));
  return parts;
}

}  // namespace tetloom
