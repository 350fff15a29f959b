#pragma once
// What the tests of the size field share.
#include <memory>
#include <random>
#include <span>

#include "mesher/sizing/build_size_field.hpp"
#include "tests/support/analytic_model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::test_sizes {

inline SizeField build(const GeometricModel& model, const SizeOptions& options, int threads = 2,
                       std::span<const SizeRefinement> refinements = {}) {
  return build_size_field(model, options, refinements, TaskRunner(threads));
}

inline std::unique_ptr<GeometricModel> unit_box() { return test_models::make_box({0, 0, 0}, {1, 1, 1}); }

/// All leaves within 100 of the origin, with the sizes at their corners: the same for equal fields alone.
inline std::vector<Vec3> values_of(const SizeField& field) {
  std::vector<Vec3> values;
  field.for_each_leaf({{-100, -100, -100}, {100, 100, 100}}, [&](const SizeLeaf& leaf) {
    const auto& [lo, hi] = leaf.box;
    values.insert(values.end(), {lo, hi});
    for (const double z : {lo.z, hi.z})
      for (const double y : {lo.y, hi.y})
        values.push_back({field.size_at({lo.x, y, z}), field.size_at({hi.x, y, z}), 0});
  });
  return values;
}

inline SizedModel build_and_estimate(const GeometricModel& model, const SizeOptions& options) {
  const TaskRunner runner(2);
  return SizeFieldBuilder(model, options, runner).build({});
}

/// The option that was refused, by the error's message; empty when nothing was thrown.
inline std::string refusal(const GeometricModel& model, const SizeOptions& options, ErrorCode code,
                           std::span<const SizeRefinement> refinements = {}) {
  try {
    build(model, options, 1, refinements);
  } catch (const Error& error) {
    return error.code() == code ? error.what() : std::string("wrong code: ") + error.what();
  }
  return {};
}

class RandomPoints {
 public:
  RandomPoints(const Box3& box, unsigned seed) : box_(box), random_(seed) {}
  double unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  Vec3 point() {
    const Vec3 extent = box_.hi - box_.lo;
    return box_.lo + Vec3{extent.x * unit(), extent.y * unit(), extent.z * unit()};
  }
  Vec3 direction() {
    for (;;) {
      const Vec3 d{unit() - 0.5, unit() - 0.5, unit() - 0.5};
      if (norm(d) > 0.05 && norm(d) < 0.5) return normalized(d);
    }
  }

 private:
  Box3 box_;
  std::mt19937_64 random_;
};

}  // namespace tetloom::test_sizes
