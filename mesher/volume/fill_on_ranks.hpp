#pragma once
// Complexes filled by several ranks together.
#include "mesher/volume/fill_complex.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::volume {

/// On several ranks, large complexes are filled in parts, one complex after the other, by all of them; those that are
/// filled in one part are dealt to the ranks. A single rank fills the complexes side by side. All ranks know errors,
/// warnings, figures and numbers of all complexes in the end, and have the parts that they made. All ranks call it, in
/// `together`, and give the same.
std::vector<VolumeParts> fill_on_ranks(const FillingPlan& plan, std::span<const Complex> complexes,
                                       std::span<FillingProgress> progress, const SharedWork& work);

/// A part of the whole volume.
struct NumberedPart {
  PartId number;
  PartMesh part;
};

/// Sends parts to the ranks that host them, of `part_count`; returns those of this rank, ascending. A collective call.
std::vector<PartMesh> send_home(std::vector<NumberedPart>&& parts, std::size_t part_count, Communicator& communicator);

}  // namespace tetloom::volume
