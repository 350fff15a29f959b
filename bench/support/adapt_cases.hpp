#pragma once
// The metrics that meshers are compared by, and what they are asked of: the unit cube.
#include <functional>
#include <string>
#include <vector>

#include "tetloom/metric.hpp"

namespace tetloom::bench {

using AnalyticMetric = std::function<adapt::Tensor(const Vec3&)>;

/// By name:
///   iso:H              the size H everywhere
///   cube-linear        sizes along z from 0.001 at z = 1/2 to 0.1 at both ends, 0.1 along x and y
///   polar-1, polar-2   the same along the distance from the z axis; 0.1 around it, with polar-2 down to 0.025 where
///                      that distance is 1/2
///   shock:R[,HN,HT]    across the sphere of radius R about the origin the size HN (0.002), along it HT (0.02), both
///                      growing by 0.2 per distance from it, up to 0.1
/// and any of them with *F at the end: all sizes divided by F. The second and third are those of the Unstructured Grid
/// Adaptation Working Group (Ibanez et al. 2017). Throws std::invalid_argument for other names and for no numbers.
AnalyticMetric analytic_metric(const std::string& name);

/// One case: metrics that follow each other, each of which the mesh made for the one before is adapted to.
struct AdaptCase {
  std::string name;
  std::vector<std::string> metrics;
};

/// iso, cube-linear, polar-2, shock and moving-shock, or any metric, which is a case of its own. Throws
/// std::invalid_argument.
AdaptCase find_adapt_case(const std::string& name);
/// The five.
std::vector<std::string> adapt_case_names();
/// Of a fraction of a second each.
std::vector<std::string> quick_adapt_case_names();

}  // namespace tetloom::bench
