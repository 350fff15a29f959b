#include "tests/support/families/family.hpp"

#include <stdexcept>

#include "tests/support/families/families.hpp"

namespace tetloom::test {
namespace {

constexpr Family kFamilies[] = {
    {"fillets", make_fillets},
    {"steps", make_steps},
    {"slivers", make_slivers},
    {"gaps", make_gaps},
    {"overlaps", make_overlaps},
    {"sewn", make_sewn},
    {"transformed", make_transformed},
    {"threads", make_threads},
    {"gears", make_gears},
    {"tubes", make_tubes},
    {"profiles", make_profiles},
    {"assemblies", make_assemblies},
    {"blobs", make_blobs},
    {"noise", make_noisy_blobs},
    {"t-junctions", make_t_junctions},
    {"holes", make_holes},
    {"dirt", make_dirt},
    {"exports", make_exports},
};

}  // namespace

std::span<const Family> all_families() { return kFamilies; }

const Family& family_named(const std::string& name) {
  for (const Family& family : kFamilies)
    if (family.name == name) return family;
  throw std::runtime_error("no family '" + name + "'");
}

}  // namespace tetloom::test
