#include "core/cad/detail/step_text.hpp"

#include <cstring>
#include <limits>
#include <string_view>

namespace tetloom::cad {
namespace {

constexpr const char* kNoIdent = "#0";
constexpr const char* kListType = "/* (SUB) */";  // by which OpenCASCADE knows lists without a type

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_word(char c) { return is_digit(c) || is_upper(c) || (c >= 'a' && c <= 'z') || c == '_'; }

/// Every function that returns false has met something unusual.
class Parser {
 public:
  explicit Parser(StepText& out) : out_(out), at_(out.buffer.data()), end_(at_ + out.buffer.size()), now_(*at_) {}

  bool parse() {
    if (!keyword("ISO-10303-21;") || !keyword("HEADER;") || !header()) return false;
    out_.header_count = out_.records.size();
    return keyword("DATA;") && data() && keyword("END-ISO-10303-21;");
  }

 private:
  struct OpenList {
    const char *ident, *type;
    std::size_t first_pending;
  };

  void next() { now_ = *++at_; }
  /// What was read so far ends here, as a string of C; the character under the cursor is still known.
  void end_text() { *at_ = '\0'; }

  bool skip_blank() {
    for (;;) {
      while (now_ == ' ' || now_ == '\t' || now_ == '\n' || now_ == '\r') next();
      if (now_ != '/') return true;
      if (at_[1] != '*') return false;
      char* close = std::strstr(at_ + 2, "*/");
      if (close == nullptr) return false;
      at_ = close + 1;
      next();
    }
  }

  bool keyword(std::string_view word) {
    if (!skip_blank()) return false;
    for (const char c : word) {
      if (now_ != c) return false;
      next();
    }
    return true;
  }

  bool expect(char c) {
    if (!skip_blank() || now_ != c) return false;
    next();
    return true;
  }

  const char* word() {
    const char* start = at_;
    while (is_word(now_)) next();
    if (at_ == start) return nullptr;
    end_text();
    return start;
  }

  bool header() {
    for (;;) {
      if (!skip_blank()) return false;
      const char* type = word();
      if (type == nullptr) return false;
      if (now_ == ';') return end_of_section(type);
      if (!entity_part(kNoIdent, type) || !expect(';')) return false;
    }
  }

  bool data() {
    for (;;) {
      if (!skip_blank()) return false;
      if (now_ != '#') {
        const char* type = word();
        return type != nullptr && now_ == ';' && end_of_section(type);
      }
      if (!entity()) return false;
    }
  }

  bool end_of_section(const char* text) {
    if (std::string_view(text) != "ENDSEC") return false;
    next();
    return true;
  }

  const char* reference() {
    const char* start = at_;
    next();
    while (is_digit(now_)) next();
    if (at_ == start + 1) return nullptr;
    end_text();
    return start;
  }

  bool entity() {
    const char* ident = reference();
    if (ident == nullptr) return false;
    while (now_ == ' ' || now_ == '\t') next();
    if (now_ != '=') return false;
    next();
    if (!skip_blank()) return false;
    return (now_ == '(' ? complex_entity(ident) : simple_entity(ident)) && expect(';');
  }

  bool simple_entity(const char* ident) {
    const char* type = word();
    return type != nullptr && entity_part(ident, type);
  }

  bool complex_entity(const char* ident) {
    next();
    do {
      if (!skip_blank() || !simple_entity(ident) || !skip_blank()) return false;
      ident = kNoIdent;
    } while (now_ != ')');
    next();
    return true;
  }

  // Without recursion: files may nest lists as deeply as they like.
  bool entity_part(const char* ident, const char* type) {
    lists_in_entity_ = 0;
    if (!expect('(')) return false;
    open(ident, type);
    bool wants_argument = false;
    while (!open_.empty()) {
      if (!skip_blank()) return false;
      if (now_ == ')' && !wants_argument) {
        next();
        close();
      } else if (now_ == '(') {
        next();
        open(list_name(), kListType);
        wants_argument = false;
        continue;
      } else if (is_word(now_) && !is_digit(now_)) {
        if (!typed_list()) return false;
        wants_argument = false;
        continue;
      } else if (!argument()) {
        return false;
      }
      if (open_.empty()) return true;
      if (!skip_blank()) return false;
      wants_argument = now_ == ',';
      if (wants_argument) {
        next();
      } else if (now_ != ')') {
        return false;
      }
    }
    return true;
  }

  bool typed_list() {
    const char* type = word();
    if (!expect('(')) return false;
    open(list_name(), type);
    return true;
  }

  const char* list_name() {
    while (out_.list_names.size() < lists_in_entity_)
      out_.list_names.push_back("$" + std::to_string(out_.list_names.size() + 1));
    return out_.list_names[lists_in_entity_ - 1].c_str();
  }

  void open(const char* ident, const char* type) {
    open_.push_back({ident, type, pending_.size()});
    ++lists_in_entity_;
  }

  void close() {
    const OpenList list = open_.back();
    open_.pop_back();
    const std::size_t count = pending_.size() - list.first_pending;
    out_.records.push_back(
        {list.ident, list.type, static_cast<std::uint32_t>(out_.arguments.size()), static_cast<std::uint32_t>(count)});
    out_.arguments.insert(out_.arguments.end(), pending_.end() - static_cast<std::ptrdiff_t>(count), pending_.end());
    pending_.resize(list.first_pending);
    if (!open_.empty()) pending_.push_back({list.ident, Interface_ParamSub});
  }

  bool add(const char* text, Interface_ParamType type) {
    end_text();
    pending_.push_back({text, type});
    return true;
  }

  bool argument() {
    const char* start = at_;
    switch (now_) {
      case '#': return reference() != nullptr && add(start, Interface_ParamIdent);
      case '\'': return quoted();
      case '$': return next(), add(start, Interface_ParamVoid);
      case '*': return next(), add(start, Interface_ParamMisc);
      case '"': return binary();
      case '.': return is_upper(at_[1]) || at_[1] == '_' ? enumeration() : number();
      default: return number();
    }
  }

  // Ends at the quote before a comma or parenthesis, as OpenCASCADE has it.
  bool quoted() {
    const char* start = at_;
    for (;;) {
      char* quote = static_cast<char*>(std::memchr(at_ + 1, '\'', static_cast<std::size_t>(end_ - at_ - 1)));
      if (quote == nullptr || std::memchr(at_, '\0', static_cast<std::size_t>(quote - at_)) != nullptr) return false;
      at_ = quote;
      const char* after = quote + 1;
      while (*after == '"' || *after == ' ' || *after == '\n' || *after == '\r') ++after;
      if (*after != ',' && *after != ')') continue;
      next();
      return add(start, Interface_ParamText);
    }
  }

  bool binary() {
    const char* start = at_;
    next();
    while (is_digit(now_) || (now_ >= 'A' && now_ <= 'F')) next();
    if (now_ != '"' || at_ == start + 1) return false;
    next();
    return add(start, Interface_ParamHexa);
  }

  bool enumeration() {
    const char* start = at_;
    next();
    while (is_digit(now_) || is_upper(now_) || now_ == '_') next();
    if (now_ != '.') return false;
    next();
    return add(start, Interface_ParamEnum);
  }

  bool number() {
    const char* start = at_;
    if (now_ != '-' && now_ != '+' && now_ != '.' && !is_digit(now_)) return false;
    bool is_real = now_ == '.', has_digit = is_digit(now_);
    for (next(); is_digit(now_) || now_ == '.'; next()) (now_ == '.' ? is_real : has_digit) = true;
    if (!has_digit) return false;
    if (now_ == 'E') {
      if (at_ < start + 2) return false;
      is_real = true;
      next();
      if (now_ == '-' || now_ == '+') next();
      if (!is_digit(now_)) return false;
      while (is_digit(now_)) next();
    }
    return add(start, is_real ? Interface_ParamReal : Interface_ParamInteger);
  }

  StepText& out_;
  char* at_;
  const char* end_;
  char now_;  ///< the character at the cursor, even where a text was ended there
  std::vector<OpenList> open_;
  std::vector<StepArgument> pending_;  ///< of the open lists, one after the other
  std::size_t lists_in_entity_ = 0;
};

}  // namespace

std::optional<StepText> parse_step_text(std::string text) {
  if (text.size() >= std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  std::optional<StepText> result(std::in_place);
  result->buffer = std::move(text);
  if (!Parser(*result).parse()) return std::nullopt;
  return result;
}

}  // namespace tetloom::cad
