#pragma once
// Files that a user writes as JSON: their members, judged one by one, with their places in messages. All functions
// throw Error(InvalidArgument).
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "apps/tetloom/quantities.hpp"
#include "tetloom/error.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::app {

[[noreturn]] void refuse_json(const std::string& message);

/// The content of the file that `option` names.
std::string read_text(const std::filesystem::path& path, const char* option);

/// `path` is for messages, which name line and column.
nlohmann::json parse_json(const std::string& text, const std::string& path);

/// Reads the members of one JSON object, and knows how to name it in messages.
class JsonEntry {
 public:
  JsonEntry(const nlohmann::json& json, std::string place, std::initializer_list<std::string_view> known)
      : json_(json), place_(std::move(place)) {
    if (!json.is_object()) refuse_json(place_ + " must be an object");
    for (const auto& [key, value] : json.items()) {
      if (std::find(known.begin(), known.end(), key) == known.end())
        refuse_json(place_ + " has an unknown key '" + key + "'");
    }
  }

  double size() const {
    const double value = number("size");
    if (value <= 0) refuse_json(place_ + ": 'size' must be positive, not " + format_number(value));
    return value;
  }

  double number(const char* key) const {
    if (!json_.contains(key)) refuse_json(place_ + " has no '" + key + "'");
    return finite(json_[key], key);
  }

  std::optional<std::int64_t> integer(const char* key, std::int64_t low, std::int64_t high) const {
    if (!json_.contains(key)) return std::nullopt;
    const nlohmann::json& value = json_[key];
    if (value.is_number_integer() && value >= low && value <= high) return value.get<std::int64_t>();
    refuse_json(place_ + ": '" + key + "' must be a whole number from " + std::to_string(low) + " to " +
                std::to_string(high));
  }

  std::string text(const char* key) const {
    if (!json_.contains(key)) return {};
    if (!json_[key].is_string() || json_[key].get_ref<const std::string&>().empty()) {
      refuse_json(place_ + ": '" + key + "' must be a text that is not empty");
    }
    return json_[key].get<std::string>();
  }

  Vec3 point(const char* key) const {
    if (!json_.contains(key) || !json_[key].is_array() || json_[key].size() != 3) {
      refuse_json(place_ + ": '" + key + "' must be three numbers");
    }
    return {finite(json_[key][0], key), finite(json_[key][1], key), finite(json_[key][2], key)};
  }

  const std::string& place() const { return place_; }

 private:
  double finite(const nlohmann::json& value, const char* key) const {
    if (!value.is_number() || !std::isfinite(value.get<double>())) {
      refuse_json(place_ + ": '" + key + "' must be a number");
    }
    return value.get<double>();
  }

  const nlohmann::json& json_;
  std::string place_;
};

/// Calls `parse(item, place)` for each item of the list `key`, which may be missing.
template <class Parse>
void for_each_item(const nlohmann::json& root, const std::string& path, const char* key, const Parse& parse) {
  if (!root.contains(key)) return;
  if (!root[key].is_array()) refuse_json("'" + path + "': \"" + key + "\" must be a list");
  for (std::size_t i = 0; i < root[key].size(); ++i) {
    parse(root[key][i], "'" + path + "': " + key + "[" + std::to_string(i) + "]");
  }
}

}  // namespace tetloom::app
