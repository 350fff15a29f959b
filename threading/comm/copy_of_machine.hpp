#pragma once
// What all ranks have alike, once for each machine.
#include "core/base/fixed_array.hpp"
#include "tetloom/communicator.hpp"

namespace tetloom {

/// Where several ranks share a machine, one copy of the bytes that all of them have: in a file in the folder for
/// temporary files, of which each rank of the machine writes a piece, and which all of them map. Its name is gone
/// before the call returns. What fills less than kLeastKept bytes, and all that a rank has alone on its machine or for
/// which there is no room in that folder, is not kept: the ranks of that machine go on with what they have.
///
/// The file lies in the memory that the system has for files, where each page is once for all ranks, and only those
/// that somebody has looked at of late need to be.
///
/// Making it and calling it are collective calls, the latter for the same bytes on all ranks. Refers to `ranks`.
KeepBytes copy_of_machine(Communicator& ranks);

inline constexpr std::size_t kLeastKept = std::size_t{1} << 16;

}  // namespace tetloom
