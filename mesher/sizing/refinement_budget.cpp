#include "mesher/sizing/refinement_budget.hpp"

#include <algorithm>

namespace tetloom {
namespace {

// Tets per triangle of a layer with the size on it, on either side and with what gradation adds.
constexpr double kTetsPerTriangle = 4;

struct Place {
  Misfit misfit;
  double present = 0;  ///< size
  double area = 0;     ///< of the triangle

  /// The size at which the width is `share` sizes; the present one where that is smaller.
  double size_for(double share) const { return std::min(misfit.size * kLeastWidth / share, present); }
  double cost(double share) const {
    const double size = size_for(share);
    return kTetsPerTriangle * kTrianglesPerSquare * area * (1 / (size * size) - 1 / (present * present));
  }
};

std::vector<Place> locate(const std::vector<Misfit>& misfits, const Mesh& surface, const SizeField& sizes) {
  std::vector<Place> places;
  places.reserve(misfits.size());
  for (const Misfit& misfit : misfits) {
    const auto& [a, b, c] = surface.tri_to_vert[misfit.triangle];
    const Vec3 &x = surface.points[a], &y = surface.points[b], &z = surface.points[c];
    places.push_back({misfit, sizes.size_at((x + y + z) / 3.0), 0.5 * norm(cross(y - x, z - x))});
  }
  return places;
}

double total_cost(const std::vector<Place>& places, double share) {
  double sum = 0;
  for (const Place& place : places) sum += place.cost(share);
  return sum;
}

/// The largest width in sizes, up to kLeastWidth, that the budget allows for all.
double affordable_share(const std::vector<Place>& places, double budget) {
  if (total_cost(places, kLeastWidth) <= budget) return kLeastWidth;
  double low = 0, high = kLeastWidth;
  constexpr int kSteps = 30;
  for (int step = 0; step < kSteps; ++step) {
    const double middle = 0.5 * (low + high);
    (total_cost(places, middle) <= budget ? low : high) = middle;
  }
  return low;
}

}  // namespace

double most_elements(double first, double factor) {
  return factor > 1 ? std::max({first, factor * first, kFewElements}) : first;
}

AffordableMisfits choose_affordable(const std::vector<Misfit>& misfits, const Mesh& surface, const SizeField& sizes,
                                    double budget) {
  const std::vector<Place> places = locate(misfits, surface, sizes);
  const double share = affordable_share(places, budget);
  AffordableMisfits result;
  for (const Place& place : places) {
    if (share < kLeastWidth) ++result.left;
    const double size = share > 0 ? place.size_for(share) : place.present;
    if (!(size < kWorthwhileSize * place.present)) continue;
    result.refined.push_back({place.misfit.triangle, size});
    result.cost += place.cost(share);
  }
  return result;
}

}  // namespace tetloom
