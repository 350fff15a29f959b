#pragma once
// Families of models with random parameters, made of nothing but a seed: CAD models of OpenCASCADE and triangle
// surfaces with the troubles that real ones have. Every model is written as a file and comes with what is known of it.
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace tetloom::test {

/// How large models may become: Small ones are meshed in some tenths of a second.
enum class FamilyScale { Small, Full };

struct FamilyModel {
  std::filesystem::path file;
  std::string what;               ///< the parameters, for messages
  double volume = 0;              ///< of all solids, model length³
  double volume_tolerance = .01;  ///< by how much of it a mesh may differ
  std::size_t solids = 1;
  bool sound = true;           ///< a proper model, which must be meshed; else it may be refused with a place
  double relative_size = 0.1;  ///< a size, as a share of the diagonal, that does not make many tets of it
  double most_tets = 0;        ///< that the model itself gives reason for; 0: whatever the sizes ask for
  double curvature = 30;       ///< edges per turn that keep the volume well within the tolerance; 0: off
};

struct Family {
  const char* name;  ///< one word
  /// The same files for the same seed. Throws std::runtime_error where the model cannot be made.
  FamilyModel (*make)(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder);
};

std::span<const Family> all_families();

/// Throws std::runtime_error where there is none of this name.
const Family& family_named(const std::string& name);

}  // namespace tetloom::test
