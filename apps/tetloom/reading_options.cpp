#include "apps/tetloom/reading_options.hpp"

#include <cstdint>
#include <numbers>

#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/quantities.hpp"

namespace tetloom::app {
namespace {

double angle_from_degrees(std::optional<double> degrees) {
  if (!degrees) return ReadOptions{}.feature_angle;
  require(*degrees > 0 && *degrees <= 180,
          "--feature-angle must lie between 0 and 180 degrees, not be " + format_number(*degrees));
  return *degrees * std::numbers::pi / 180;
}

std::vector<ModelRegionId> solids_from(const std::string& list) {
  std::vector<ModelRegionId> solids;
  for (const std::string& item : items_of(list)) {
    const std::optional<std::uint32_t> tag = tag_of(item);
    require(tag.has_value(), "--rebuild takes tags of solids, separated by commas, not '" + list + "'");
    solids.push_back(ModelRegionId(*tag - 1));
  }
  return solids;
}

}  // namespace

void add_reading_options(CLI::App& command, RawReading& raw) {
  const std::string group = "Reading";
  command.add_flag("--imprint", raw.imprint, "Fuse touching solids first, so that they share faces")->group(group);
  command.add_flag("--no-heal", raw.no_heal, "Leave the geometry as it is in the file")->group(group);
  command
      .add_option("--feature-angle", raw.feature_angle,
                  "STL and OBJ: cut into faces where facets turn by more; default: 40")
      ->type_name("DEG")
      ->group(group);
  command.add_option("--fill-holes", raw.fill_holes, "STL and OBJ: close holes up to W wide; default: 0, none")
      ->type_name("W")
      ->group(group);
  command
      .add_option(
          "--rebuild", raw.rebuild,
          "Make these solids anew from the space that they enclose, as mesh does where solids cross themselves; "
          "may be repeated, in the order of the report")
      ->type_name("TAG,...")
      ->allow_extra_args(false)
      ->group(group);
}

ReadOptions make_read_options(const RawReading& raw) {
  ReadOptions options{!raw.no_heal,
                      raw.imprint,
                      angle_from_degrees(raw.feature_angle),
                      not_negative("--fill-holes", raw.fill_holes, 0),
                      {}};
  for (const std::string& tags : raw.rebuild) options.rebuilt.push_back(solids_from(tags));
  return options;
}

}  // namespace tetloom::app
