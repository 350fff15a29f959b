#include "bench/support/command_line.hpp"

#include <CLI/CLI.hpp>
#include <utility>

namespace tetloom::bench {
namespace {

CLI::Option& of(void* option) { return *static_cast<CLI::Option*>(option); }

bool is_told(const std::string& value) { return !value.empty(); }
bool is_told(double value) { return value != 0; }
template <class Item>
bool is_told(const std::vector<Item>& values) {
  return !values.empty();
}

template <class Value>
constexpr bool kIsList = false;
template <class Item>
constexpr bool kIsList<std::vector<Item>> = true;

}  // namespace

struct CommandLine::Parser {
  CLI::App app;
};

const CommandLine::Option& CommandLine::Option::positive() const {
  of(option_).check(CLI::PositiveNumber);
  return *this;
}

const CommandLine::Option& CommandLine::Option::not_negative() const {
  of(option_).check(CLI::NonNegativeNumber);
  return *this;
}

const CommandLine::Option& CommandLine::Option::in_range(double least, double most) const {
  of(option_).check(CLI::Range(least, most));
  return *this;
}

const CommandLine::Option& CommandLine::Option::existing_file() const {
  of(option_).check(CLI::ExistingFile);
  return *this;
}

const CommandLine::Option& CommandLine::Option::one_of(std::vector<std::string> values) const {
  of(option_).check(CLI::IsMember(std::move(values)));
  return *this;
}

const CommandLine::Option& CommandLine::Option::separated_by(char separator) const {
  of(option_).delimiter(separator);
  return *this;
}

const CommandLine::Option& CommandLine::Option::hidden() const {
  of(option_).group("");
  return *this;
}

CommandLine::CommandLine(const std::string& description, const std::string& name)
    : parser_(new Parser{CLI::App(description, name)}) {}

CommandLine::~CommandLine() = default;

template <class Value>
CommandLine::Option CommandLine::add(const std::string& name, Value& value, const std::string& help) {
  CLI::Option* const option = parser_->app.add_option(name, value, help);
  if (kIsList<Value>) option->delimiter(',');
  if (is_told(value)) option->capture_default_str();
  return Option(option);
}

template CommandLine::Option CommandLine::add(const std::string&, int&, const std::string&);
template CommandLine::Option CommandLine::add(const std::string&, double&, const std::string&);
template CommandLine::Option CommandLine::add(const std::string&, std::string&, const std::string&);
template CommandLine::Option CommandLine::add(const std::string&, std::vector<int>&, const std::string&);
template CommandLine::Option CommandLine::add(const std::string&, std::vector<double>&, const std::string&);
template CommandLine::Option CommandLine::add(const std::string&, std::vector<std::string>&, const std::string&);

void CommandLine::add_flag(const std::string& name, bool& value, const std::string& help) {
  parser_->app.add_flag(name, value, help);
}

std::optional<int> CommandLine::parse(int argc, char** argv) {
  try {
    parser_->app.parse(argc, argv);
  } catch (const CLI::ParseError& end) {
    return parser_->app.exit(end);
  }
  return std::nullopt;
}

}  // namespace tetloom::bench
