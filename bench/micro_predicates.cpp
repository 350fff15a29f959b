// The exact predicates: where the filter decides, and where it cannot.
#include <benchmark/benchmark.h>

#include <cstddef>
#include <random>
#include <vector>

#include "core/predicates/predicates.hpp"

namespace tetloom::bench {
namespace {

constexpr std::size_t kPoints = 4096;  // a power of two; fits in the cache

std::vector<double> random_coordinates(std::size_t count) {
  std::mt19937_64 random(20100614);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<double> values(count);
  for (double& value : values) value = uniform(random);
  return values;
}

Vec2 random_point2(const std::vector<double>& values, std::size_t i) { return {values[2 * i], values[2 * i + 1]}; }
Vec2 point_on_line(const std::vector<double>& values, std::size_t i) { return {values[i], values[i]}; }
Vec2 corner_of_square(const std::vector<double>&, std::size_t i) {
  return {static_cast<double>(i % 2), static_cast<double>(i / 2 % 2)};
}
Vec3 random_point3(const std::vector<double>& values, std::size_t i) {
  return {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
}
Vec3 point_on_plane(const std::vector<double>& values, std::size_t i) {
  return {values[2 * i], values[2 * i + 1], values[2 * i]};
}
Vec3 corner_of_cube(const std::vector<double>&, std::size_t i) {
  return {static_cast<double>(i % 2), static_cast<double>(i / 2 % 2), static_cast<double>(i / 4 % 2)};
}

/// Points at random, or such that the determinant is zero.
template <class Point>
std::vector<Point> make_points(bool degenerate, Point (*at_random)(const std::vector<double>&, std::size_t),
                               Point (*in_special_place)(const std::vector<double>&, std::size_t)) {
  const std::vector<double> values = random_coordinates(3 * kPoints);
  std::vector<Point> points;
  for (std::size_t i = 0; i < kPoints; ++i) points.push_back((degenerate ? in_special_place : at_random)(values, i));
  return points;
}

template <class Points, class Predicate>
void run_predicate(benchmark::State& state, const Points& points, const Predicate& predicate) {
  std::size_t i = 0;
  const auto at = [&](std::size_t k) -> const auto& { return points[(i + k) % kPoints]; };
  for (auto _ : state) {
    benchmark::DoNotOptimize(predicate(at));
    ++i;
  }
  state.SetItemsProcessed(state.iterations());
}

void orient2d_sign(benchmark::State& state) {
  run_predicate(state, make_points(state.range(0) != 0, random_point2, point_on_line),
                [](const auto& at) { return orient2d(at(0), at(1), at(2)); });
}
void incircle_sign(benchmark::State& state) {
  run_predicate(state, make_points(state.range(0) != 0, random_point2, corner_of_square),
                [](const auto& at) { return incircle(at(0), at(1), at(2), at(3)); });
}
void orient3d_sign(benchmark::State& state) {
  run_predicate(state, make_points(state.range(0) != 0, random_point3, point_on_plane),
                [](const auto& at) { return orient3d(at(0), at(1), at(2), at(3)); });
}
void insphere_sign(benchmark::State& state) {
  run_predicate(state, make_points(state.range(0) != 0, random_point3, corner_of_cube),
                [](const auto& at) { return insphere(at(0), at(1), at(2), at(3), at(4)); });
}

BENCHMARK(orient2d_sign)->ArgName("degenerate")->Arg(0)->Arg(1);
BENCHMARK(incircle_sign)->ArgName("degenerate")->Arg(0)->Arg(1);
BENCHMARK(orient3d_sign)->ArgName("degenerate")->Arg(0)->Arg(1);
BENCHMARK(insphere_sign)->ArgName("degenerate")->Arg(0)->Arg(1);

}  // namespace
}  // namespace tetloom::bench
