#pragma once
// What the tetrahedra of a mesh are to reach, and how long to try.

namespace tetloom {

/// Tets that miss a goal get other points, and another surface where that may change, until no more of that helps or
/// the rounds are over. A goal is no promise: what stays below it is reported, with the reason.
struct QualityGoals {
  double dihedral = 15;     ///< degrees, 0 to 60: the smallest dihedral angle
  double mean_ratio = 0.5;  ///< 0 to .9
  int rounds = 2;           ///< 0 to 100: at most so many inside, and four times as many with the surface
};

/// Throws Error(InvalidArgument) for values out of range.
void check_goals(const QualityGoals& goals);

}  // namespace tetloom
