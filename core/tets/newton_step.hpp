#pragma once
// Where a vertex goes so that the tets around it become better: one damped Newton step on the sum of 1/q^3, convex and
// with a gradient and a Hessian in closed form (Freitag & Knupp 2002 use other exponents). Departures: the step is
// over-relaxed by 1.2, and where meshes are adapted sizes count as well. The metric is the caller's: a star measured in
// it gives a step in it.
#include <span>

#include "core/tets/star_tet.hpp"

namespace tetloom::tets {

/// A step of a vertex from 0 that lowers the sum of 1/q^3 over `star`, leaves every tet surely positive and
/// lowers the smallest q^3 only to what is at least `floor`; the zero vector when there is none. `x` is where 0 is: the
/// step ends at a point that is a sum of doubles. `size_weight`: of `size_badness`, which is added to that sum. Pre:
/// all tets are positive.
Vec3 find_newton_step(std::span<const StarTet> star, const Vec3& x, double floor, double size_weight = 0);

/// How far the sizes of a star's tets are from those with edges of length 1, with its vertex at `d`: the sum of
/// (s / 6 - 1)^2, s the sum of a tet's squared edges, times the weight.
double size_badness(std::span<const StarTet> star, const Vec3& d, double size_weight);

}  // namespace tetloom::tets
