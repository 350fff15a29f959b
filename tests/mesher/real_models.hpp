#pragma once
// The real CAD models that some tests use, where they are.
#include <algorithm>
#include <filesystem>
#include <vector>

namespace tetloom::test {

inline const std::filesystem::path kRealModels = std::filesystem::path(TETLOOM_SHARED_DIR) / "cad";

/// In order of their names; none where there are none.
inline std::vector<std::filesystem::path> list_real_models() {
  std::vector<std::filesystem::path> models;
  if (!std::filesystem::is_directory(kRealModels)) return models;
  for (const auto& entry : std::filesystem::directory_iterator(kRealModels))
    if (entry.path().extension() != ".md") models.push_back(entry.path());
  std::sort(models.begin(), models.end());
  return models;
}

}  // namespace tetloom::test
