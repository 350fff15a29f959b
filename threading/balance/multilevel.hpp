#pragma once
// Deals tets to parts by their graph: through clusters of tets, and clusters of clusters.
#include <vector>

#include "tetloom/tasks.hpp"
#include "threading/balance/part_boundaries.hpp"
#include "threading/balance/partitioners.hpp"

namespace tetloom {

/// Cuts the graph of a block's tets into `tets.part_count` parts with few faces between them. Tets are joined in
/// clusters of about 20, which lie in one chunk of space each; clusters in clusters of up to 10, until about 1500 per
/// part are left (16,000 at least, 50,000 at most); Scotch cuts their graph; and on the way back the boundaries are
/// refined on each level as by smooth_part_boundaries, last those between tets. `tets.targets` is written only.
/// `points`: a place for each tet, which decides about chunks alone.
///
/// Laws: the result depends on the input and on Scotch's version, not on threads. No part is heavier than
/// (1 + imbalance) of the mean, unless corrections by diffuse_load fail to reach that: parts of few tets, or weights
/// that differ much. Cuts are about as short as Scotch's on the tets themselves from 8 parts on; for two to four parts
/// of regular shapes they may be a fifth longer. Where there are fewer tets than parts some parts stay empty. O(tets)
/// work; all of it in parallel but Scotch's, which takes about 5 microseconds per cluster and doubling of parts. Memory
/// beside `tets`, measured at the peak: 18.6 bytes per tet of 20 million, where the places (12 bytes per tet) are freed
/// early; more in small meshes with many parts, whose coarsest graphs are large beside them: 57 bytes per tet of a
/// million in 64 parts.
/// Errors: InvalidArgument (arrays that do not fit, weights that are not positive, places that are not finite, no
/// part, a bound below zero), OutOfMemory, Cancelled.
///
/// After Karypis & Kumar 1998, with refinement in bands after Chevalier & Pellegrini 2006, and the order of levels of
/// Hendrickson & Leland 1995. Departures: clusters of many tets that grow by the most shared faces, in place of pairs,
/// because each level costs a scan of memory; on each upper level nodes then move once to the cluster that they share
/// the most faces with, as compact clusters leave better places for cuts; boundaries are refined two parts at a time.
void partition_multilevel(const TargetedTets& tets, std::vector<Point3f> points, const TaskRunner& runner,
                          double imbalance = 0.03);

}  // namespace tetloom
