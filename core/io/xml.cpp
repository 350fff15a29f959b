// As much of XML as VTK files use: elements with attributes and text, comments and declarations; entities only where
// a reader asks for them.
#include <algorithm>

#include "core/io/vtu_detail.hpp"

namespace tetloom::detail {
namespace {

class XmlParser {
 public:
  explicit XmlParser(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {}

  std::vector<XmlElement> parse() {
    std::vector<std::size_t> open;
    for (;;) {
      const std::string_view text = text_up_to('<');
      if (!open.empty() && elements_[open.back()].text.data() == nullptr) elements_[open.back()].text = text;
      const std::string_view rest = cursor_.rest();
      if (rest.empty()) break;
      if (rest.starts_with("<!--")) {
        skip_past("-->");
      } else if (rest.starts_with("<?") || rest.starts_with("<!")) {
        skip_past(">");
      } else if (rest.starts_with("</")) {
        skip_past(">");
        if (open.empty()) fail("a tag is closed that was not opened");
        open.pop_back();
        if (open.empty()) return std::move(elements_);
      } else if (!read_start_tag(open)) {
        return std::move(elements_);
      }
    }
    if (elements_.empty()) fail("no XML document");
    fail("the document ends too early");
  }

 private:
  [[noreturn]] void fail(const char* what) { file_.fail_at_line(what, cursor_.at()); }

  std::string_view text_up_to(char stop) {
    const std::string_view rest = cursor_.rest();
    const std::size_t length = std::min(rest.find(stop), rest.size());
    cursor_.jump(cursor_.at() + length);
    return rest.substr(0, length);
  }
  void skip_past(std::string_view end) {
    const std::size_t place = cursor_.rest().find(end);
    if (place == std::string_view::npos) fail("the document ends too early");
    cursor_.jump(cursor_.at() + place + end.size());
  }
  static bool ends_name(char c) { return Cursor::is_space(c) || c == '=' || c == '>' || c == '/' || c == '<'; }
  std::string_view name() {
    const std::string_view rest = cursor_.rest();
    std::size_t length = 0;
    while (length < rest.size() && !ends_name(rest[length])) ++length;
    if (length == 0) fail("a name is expected");
    cursor_.jump(cursor_.at() + length);
    return rest.substr(0, length);
  }
  bool accept(char c) {
    cursor_.skip_space();
    if (cursor_.left() == 0 || *cursor_.at() != c) return false;
    cursor_.jump(cursor_.at() + 1);
    return true;
  }

  /// Adds an element; false when it was raw appended data, which ends the document.
  bool read_start_tag(std::vector<std::size_t>& open) {
    if (open.empty() && !elements_.empty()) fail("a second document");
    cursor_.jump(cursor_.at() + 1);
    const std::size_t index = elements_.size();
    elements_.push_back({name(), {}, {}, {}});
    if (!open.empty()) elements_[open.back()].children.push_back(index);
    for (;;) {
      if (accept('>')) break;
      if (accept('/')) {
        if (!accept('>')) fail("'>' is expected");
        elements_[index].text = std::string_view(cursor_.at(), 0);
        return true;
      }
      const std::string_view key = name();
      if (!accept('=')) fail("'=' is expected");
      const char quote = accept('"') ? '"' : accept('\'') ? '\'' : '\0';
      if (quote == '\0') fail("a quoted value is expected");
      const std::string_view value = text_up_to(quote);
      if (!accept(quote)) fail("a quoted value has no end");
      elements_[index].attributes.emplace_back(key, value);
    }
    if (elements_[index].name == "AppendedData" && elements_[index].attribute("encoding") == "raw") {
      elements_[index].text = cursor_.rest();
      return false;
    }
    open.push_back(index);
    return true;
  }

  const InputFile& file_;
  Cursor cursor_;
  std::vector<XmlElement> elements_;
};

struct XmlEntity {
  char character;
  std::string_view text;
};
constexpr std::array<XmlEntity, 8> kEntities{{{'&', "&amp;"},
                                              {'<', "&lt;"},
                                              {'>', "&gt;"},
                                              {'"', "&quot;"},
                                              {'\'', "&apos;"},
                                              {'\'', "&#39;"},
                                              {'"', "&#34;"},
                                              {'&', "&#38;"}}};

}  // namespace

std::string xml_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    const auto* found =
        std::find_if(kEntities.begin(), kEntities.end(), [&](const XmlEntity& e) { return e.character == c; });
    if (found == kEntities.end())
      escaped += c;
    else
      escaped += found->text;
  }
  return escaped;
}

std::string xml_unescaped(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const auto* found =
        std::find_if(kEntities.begin(), kEntities.end(), [&](const XmlEntity& e) { return text.starts_with(e.text); });
    plain += found == kEntities.end() ? text.front() : found->character;
    text.remove_prefix(found == kEntities.end() ? 1 : found->text.size());
  }
  return plain;
}

std::vector<XmlElement> parse_xml(const InputFile& file) { return XmlParser(file).parse(); }

}  // namespace tetloom::detail
