// Writes models of a family, to look at one that a test has named, or to run real_models over many.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "tests/support/families/family.hpp"

namespace {

namespace fs = std::filesystem;
using namespace tetloom::test;

constexpr const char* kUsage =
    "usage: make_family_models FAMILY FIRST COUNT FOLDER [full]\n"
    "Writes FOLDER/FAMILY-SEED.EXTENSION for COUNT seeds from FIRST on, large ones with 'full'. Families:\n ";

void write_one(const Family& family, std::uint64_t seed, FamilyScale scale, const fs::path& folder) {
  const FamilyModel model = family.make(seed, scale, folder);
  const fs::path path =
      folder / (std::string(family.name) + '-' + std::to_string(seed) + model.file.extension().string());
  fs::rename(model.file, path);
  std::printf("%-28s %s; %zu solids, volume %.9g%s\n", path.filename().c_str(), model.what.c_str(), model.solids,
              model.volume, model.sound ? "" : ", not sound");
}

int run(int argc, char** argv) {
  if (argc < 5) {
    std::fputs(kUsage, stderr);
    for (const Family& family : all_families()) std::fprintf(stderr, " %s", family.name);
    std::fputs("\n", stderr);
    return 2;
  }
  const Family& family = family_named(argv[1]);
  const std::uint64_t first = std::strtoull(argv[2], nullptr, 10), count = std::strtoull(argv[3], nullptr, 10);
  const FamilyScale scale = argc > 5 && argv[5] == std::string("full") ? FamilyScale::Full : FamilyScale::Small;
  fs::create_directories(argv[4]);
  int failures = 0;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    try {
      write_one(family, seed, scale, argv[4]);
    } catch (const std::exception& error) {
      std::printf("%s-%llu cannot be made: %s\n", family.name, static_cast<unsigned long long>(seed), error.what());
      ++failures;
    }
  }
  return failures > 0 ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_family_models: %s\n", error.what());
    return 1;
  }
}
