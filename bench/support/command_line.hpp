#pragma once
// The command line of a bench. What parses it takes seconds to compile: it stands behind this, once for all benches.
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tetloom::bench {

class CommandLine {
 public:
  /// An option that was added, to say what it takes.
  class Option {
   public:
    const Option& positive() const;
    const Option& not_negative() const;
    const Option& in_range(double least, double most) const;
    const Option& existing_file() const;
    const Option& one_of(std::vector<std::string> values) const;
    const Option& separated_by(char separator) const;  ///< items of a list
    const Option& hidden() const;                      ///< not in the help

   private:
    friend class CommandLine;
    explicit Option(void* option) : option_(option) {}
    void* option_;
  };

  /// What --help tells of the bench and its name.
  explicit CommandLine(const std::string& description, const std::string& name = {});
  ~CommandLine();

  /// An option that sets `value`, or what stands without an option where the name has no dashes. The value until then
  /// is told as the default, unless it is zero or empty. Lists have commas between their items, unless another
  /// separator is given.
  template <class Value>
  Option add(const std::string& name, Value& value, const std::string& help = {});
  void add_flag(const std::string& name, bool& value, const std::string& help);

  /// The exit status where the program ends here: --help, or a wrong command line, which is told.
  std::optional<int> parse(int argc, char** argv);

 private:
  struct Parser;
  std::unique_ptr<Parser> parser_;
};

extern template CommandLine::Option CommandLine::add(const std::string&, int&, const std::string&);
extern template CommandLine::Option CommandLine::add(const std::string&, double&, const std::string&);
extern template CommandLine::Option CommandLine::add(const std::string&, std::string&, const std::string&);
extern template CommandLine::Option CommandLine::add(const std::string&, std::vector<int>&, const std::string&);
extern template CommandLine::Option CommandLine::add(const std::string&, std::vector<double>&, const std::string&);
extern template CommandLine::Option CommandLine::add(const std::string&, std::vector<std::string>&, const std::string&);

}  // namespace tetloom::bench
