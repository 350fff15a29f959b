#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace tetloom::bench {

/// The models in folders, and files named themselves, in the order of their paths: those whose names match the regular
/// expression `only`, in any case. Throws std::runtime_error for what is not there.
std::vector<std::filesystem::path> find_models(const std::vector<std::string>& folders, const std::string& only);

}  // namespace tetloom::bench
