#include "bench/support/model_files.hpp"

#include <algorithm>
#include <cctype>
#include <regex>
#include <stdexcept>

namespace tetloom::bench {

namespace fs = std::filesystem;

namespace {

bool is_model_file(const fs::path& path) {
  static const std::vector<std::string> known{".step", ".stp", ".iges", ".igs", ".brep", ".stl", ".obj"};
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::count(known, extension) > 0;
}

}  // namespace

std::vector<fs::path> find_models(const std::vector<std::string>& folders, const std::string& only) {
  std::vector<fs::path> models;
  for (const fs::path folder : folders) {
    if (!fs::exists(folder)) throw std::runtime_error("no such folder: '" + folder.string() + "'");
    if (!fs::is_directory(folder)) models.push_back(folder);
    if (!fs::is_directory(folder)) continue;
    for (const auto& entry : fs::directory_iterator(folder))
      if (is_model_file(entry.path())) models.push_back(entry.path());
  }
  const std::regex wanted(only, std::regex::icase);
  std::erase_if(models, [&](const fs::path& path) { return !std::regex_search(path.filename().string(), wanted); });
  std::ranges::sort(models);
  return models;
}

}  // namespace tetloom::bench
