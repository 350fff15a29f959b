#pragma once
// Values from the command line, judged one by one. All functions throw UsageError, which names the option.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/tetloom/options.hpp"

namespace tetloom::app {

inline constexpr int kMostThreads = 4096;
inline constexpr int kMostParts = 1 << 20;
inline constexpr double kFewestTetsPerPart = 1000;

void require(bool condition, const std::string& message);

double positive(const char* option, std::optional<double> value, double otherwise);
double not_negative(const char* option, std::optional<double> value, double otherwise);
/// Between 1 and `most`; 0 where there is none.
int count_between(const char* option, std::optional<int> value, int most);

/// The items between commas; a single empty one of an empty text.
std::vector<std::string> items_of(const std::string& list);
/// A tag of a model entity; nothing for other texts.
std::optional<std::uint32_t> tag_of(std::string_view text);

std::string lower_extension(const std::filesystem::path& path);
/// Whether both name the same file, which need not be there. Two empty paths do not.
bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);
/// Whether writing `output` replaces `path`: the same file, or one in the folder of pieces of a list.
bool would_replace(const std::filesystem::path& output, const std::filesystem::path& path);
/// Whether the output holds parts, which it does where it is a list of pieces or where `parts` are asked for.
bool is_in_parts(const std::filesystem::path& output, std::optional<int> parts);

}  // namespace tetloom::app
