#include "apps/tetloom/json_entry.hpp"

#include <fstream>
#include <iterator>

namespace tetloom::app {

void refuse_json(const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); }

std::string read_text(const std::filesystem::path& path, const char* option) {
  std::ifstream file(path, std::ios::binary);
  std::error_code error;
  if (!file || !std::filesystem::is_regular_file(path, error))
    refuse_json("cannot read the file of " + std::string(option) + ", '" + path.string() + "'");
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

nlohmann::json parse_json(const std::string& text, const std::string& path) {
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    // "[json.exception.parse_error.101] parse error at line 3, column 5: …": the bracket is for programmers.
    const std::string message = error.what();
    const std::size_t bracket = message.find("] ");
    refuse_json("'" + path + "': " + (bracket == std::string::npos ? message : message.substr(bracket + 2)));
  }
}

}  // namespace tetloom::app
