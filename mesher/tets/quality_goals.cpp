#include "mesher/tets/quality_goals.hpp"

#include "tetloom/error.hpp"

namespace tetloom {

void check_goals(const QualityGoals& goals) {
  const auto refuse = [](const char* why) { throw Error(ErrorCode::InvalidArgument, why); };
  if (!(goals.dihedral >= 0 && goals.dihedral <= 60))
    refuse("the goal for dihedral angles must lie between 0 and 60 degrees");
  if (!(goals.mean_ratio >= 0 && goals.mean_ratio <= 0.9))
    refuse("the goal for mean ratios must lie between 0 and 0.9");
  if (goals.rounds < 0 || goals.rounds > 100) refuse("the rounds for the goals must lie between 0 and 100");
}

}  // namespace tetloom
