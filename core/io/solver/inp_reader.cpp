// Input files of Abaqus and CalculiX: nodes, elements, ELSETs and SURFACEs of element faces, of one part. Sets of cells
// become regions, surfaces become faces with a triangle or quadrilateral for each element face; in files without cells
// sets of shells become faces. An element belongs to the first set that names it. All other keywords are passed over.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <map>
#include <optional>
#include <set>

#include "core/io/formats_detail.hpp"
#include "core/io/mid_node_reader_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/group_tags.hpp"
#include "core/io/solver/inp_detail.hpp"

namespace tetloom::detail {
namespace {

struct InpType {
  Block block;
  std::size_t mid_nodes = 0;
  std::size_t nodes() const { return vertices_of(block) + mid_nodes; }
};

// Names of types by what they begin with; letters behind say how the element is integrated, mostly.
std::optional<InpType> find_type(std::string_view name) {
  struct Known {
    std::string_view begin;
    Block block;
    bool is_second_order;
  };
  static constexpr std::array<Known, 33> kTypes{{
      {"C3D10", Block::Tet, true},       {"C3D15", Block::Prism, true},     {"C3D20", Block::Hex, true},
      {"C3D4", Block::Tet, false},       {"C3D5", Block::Pyramid, false},   {"C3D6", Block::Prism, false},
      {"C3D8", Block::Hex, false},       {"DC3D10", Block::Tet, true},      {"DC3D20", Block::Hex, true},
      {"DC3D4", Block::Tet, false},      {"DC3D6", Block::Prism, false},    {"DC3D8", Block::Hex, false},
      {"STRI65", Block::Triangle, true}, {"STRI3", Block::Triangle, false}, {"S3", Block::Triangle, false},
      {"S4", Block::Quad, false},        {"S6", Block::Triangle, true},     {"S8", Block::Quad, true},
      {"CPS3", Block::Triangle, false},  {"CPS4", Block::Quad, false},      {"CPS6", Block::Triangle, true},
      {"CPS8", Block::Quad, true},       {"CPE3", Block::Triangle, false},  {"CPE4", Block::Quad, false},
      {"CPE6", Block::Triangle, true},   {"CPE8", Block::Quad, true},       {"M3D3", Block::Triangle, false},
      {"M3D4", Block::Quad, false},      {"M3D6", Block::Triangle, true},   {"T3D2", Block::Edge, false},
      {"T3D3", Block::Edge, true},       {"B31", Block::Edge, false},       {"B32", Block::Edge, true},
  }};
  for (const Known& known : kTypes)
    if (name.starts_with(known.begin))
      return InpType{known.block, known.is_second_order ? edges_of(known.block).size() : 0};
  return {};
}

// A word of a line between commas, without space around it.
std::string_view trimmed(std::string_view text) {
  while (!text.empty() && Cursor::is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && Cursor::is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::string upper_case(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper;
}

// A face of a cell on a surface, or all those of a set: `number` is that of the face.
struct SurfaceItem {
  std::uint64_t element = 0;
  std::string set;  // where it is not empty, in place of the element
  int number = 0;
  std::uint32_t group = 0;
};

class InpReader {
 public:
  explicit InpReader(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {}

  Mesh read() {
    while (next_line())
      if (line_.front() == '*')
        begin_keyword();
      else if (read_line_)
        (this->*read_line_)();
    return finish();
  }

 private:
  using ReadLine = void (InpReader::*)();

  bool next_line() {
    constexpr std::size_t kLinesBetweenLooks = std::size_t{1} << 16;
    while (cursor_.left() > 0) {
      if (++lines_ % kLinesBetweenLooks == 0) file_.check_cancelled();
      line_ = trimmed(cursor_.line());
      if (!line_.empty() && !line_.starts_with("**")) return true;
    }
    return false;
  }

  std::string_view take_word() {
    const std::size_t comma = std::min(line_.find(','), line_.size());
    const std::string_view word = trimmed(line_.substr(0, comma));
    line_.remove_prefix(std::min(comma + 1, line_.size()));
    return word;
  }
  template <class Number>
  Number number_in(std::string_view word) const {
    if (!word.empty() && word.front() == '+') word.remove_prefix(1);
    Number value{};
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool fits =
        error == std::errc() || (std::is_floating_point_v<Number> && error == std::errc::result_out_of_range);
    if (word.empty() || !fits || end != word.data() + word.size())
      file_.fail_at_line("a number is expected", cursor_.at() - 1);
    return value;
  }
  static bool is_number(std::string_view word) {
    return !word.empty() && std::isdigit(static_cast<unsigned char>(word.front())) != 0;
  }

  // "*ELEMENT, TYPE=C3D4, ELSET=body". What the lines behind it mean follows from it.
  void begin_keyword() {
    if (!pending_.empty()) file_.fail_at_line("an element has too few nodes", line_.data());
    const std::string keyword = upper_case(take_word());
    parameters_.clear();
    while (!line_.empty()) {
      const std::string_view word = take_word();
      const std::size_t equals = std::min(word.find('='), word.size());
      const std::string_view value = equals < word.size() ? trimmed(word.substr(equals + 1)) : std::string_view();
      parameters_[upper_case(trimmed(word.substr(0, equals)))] = std::string(value);
    }
    read_line_ = nullptr;
    if (keyword == "*NODE") read_line_ = &InpReader::read_node;
    if (keyword == "*ELEMENT") begin_elements();
    if (keyword == "*ELSET") begin_set();
    if (keyword == "*SURFACE") begin_surface();
    if (keyword == "*INCLUDE")
      file_.fail_at_line("*INCLUDE is not supported; put the files together", cursor_.at() - 1);
    if (keyword == "*PART" && ++parts_ > 1)
      file_.fail(ErrorCode::InputUnsuitable, "the file has several parts; only one is supported");
  }

  std::string parameter(const char* key) const {
    const auto found = parameters_.find(key);
    return found == parameters_.end() ? std::string() : found->second;
  }

  void read_node() {
    node_tags_.push_back(number_in<std::uint64_t>(take_word()));
    Vec3 x;
    for (int axis = 0; axis < 3 && !line_.empty(); ++axis)
      if (const std::string_view word = take_word(); !word.empty()) x[axis] = number_in<double>(word);
    mesh_.points.push_back(x);
  }

  void begin_elements() {
    const std::string name = parameter("TYPE");
    const std::optional<InpType> type = find_type(upper_case(name));
    if (!type) refuse_elements(file_, "'" + name + "'");
    type_ = *type;
    const std::string set = parameter("ELSET");
    numbers_ = set.empty() ? nullptr : &sets_[set];
    read_line_ = &InpReader::read_element;
  }

  // A number, then nodes, on as many lines as it takes.
  void read_element() {
    while (!line_.empty()) {
      const std::string_view word = take_word();
      if (!word.empty()) pending_.push_back(number_in<std::uint64_t>(word));
    }
    if (pending_.size() < type_.nodes() + 1) return;
    if (pending_.size() > type_.nodes() + 1) file_.fail_at_line("an element has too many nodes", cursor_.at() - 1);
    elements_.push_back({pending_[0], type_, nodes_.size()});
    nodes_.insert(nodes_.end(), pending_.begin() + 1, pending_.end());
    if (numbers_ != nullptr) numbers_->push_back(pending_[0]);
    pending_.clear();
  }

  void begin_set() {
    set_ = parameter("ELSET");
    is_generated_ = parameters_.contains("GENERATE");
    numbers_ = &sets_[set_];
    read_line_ = &InpReader::read_set;
  }

  void read_set() {
    std::vector<std::uint64_t>& set = *numbers_;
    if (is_generated_) {
      const auto first = number_in<std::uint64_t>(take_word()), last = number_in<std::uint64_t>(take_word());
      const std::string_view word = take_word();
      const std::uint64_t step = word.empty() ? 1 : number_in<std::uint64_t>(word);
      if (step == 0 || last < first) file_.fail_at_line("a range that makes no sense", cursor_.at() - 1);
      // A range may be far longer than the elements that are there.
      ranges_.push_back({set_, first, last, step});
      return;
    }
    while (!line_.empty()) {
      const std::string_view word = take_word();
      if (is_number(word))
        set.push_back(number_in<std::uint64_t>(word));
      else if (const auto other = sets_.find(word); other != sets_.end() && &other->second != &set)
        set.insert(set.end(), other->second.begin(), other->second.end());
      if (set.size() > file_.bytes().size()) file_.fail_at_line("sets of sets grow beyond the file", cursor_.at() - 1);
    }
  }

  void begin_surface() {
    const std::string type = upper_case(parameter("TYPE"));
    if (!type.empty() && type != "ELEMENT") return;
    surface_ = faces_.find(parameter("NAME"));
    read_line_ = &InpReader::read_surface;
  }

  // "17,S2" or "set,S2"; sides of shells, SPOS and SNEG, say nothing here.
  void read_surface() {
    const std::string_view item = take_word(), side = take_word();
    if (side.size() != 2 || std::toupper(static_cast<unsigned char>(side[0])) != 'S' || side[1] < '1' || side[1] > '6')
      return;
    SurfaceItem& added = surface_items_.emplace_back();
    if (is_number(item))
      added.element = number_in<std::uint64_t>(item);
    else
      added.set = item;
    added.number = side[1] - '0';
    added.group = surface_;
  }

  struct Element {
    std::uint64_t number = 0;
    InpType type;
    std::size_t first_node = 0;
    std::uint32_t place = 0;  // among those of its block
    std::uint32_t group = kNone;
  };

  // Numbers that follow each other are found at once.
  Element* find_element(std::uint64_t number) {
    if (last_found_ + 1 < elements_.size() && elements_[last_found_ + 1].number == number)
      return &elements_[++last_found_];
    const auto at = std::ranges::lower_bound(elements_, number, {}, &Element::number);
    if (at == elements_.end() || at->number != number) return nullptr;
    last_found_ = static_cast<std::size_t>(at - elements_.begin());
    return &*at;
  }

  Mesh finish() {
    if (!pending_.empty()) file_.fail_at_line("the file ends inside of an element", cursor_.at());
    mesh_.point_to_entity.resize(mesh_.points.size());
    if (mesh_.points.size() >= kNone) file_.fail(ErrorCode::InputUnsuitable, "the file has too many nodes");
    NodeTags nodes;
    nodes.finish(file_, std::move(node_tags_), mesh_.points, mesh_.point_to_entity);
    if (!std::ranges::is_sorted(elements_, {}, &Element::number))
      std::ranges::stable_sort(elements_, {}, &Element::number);
    if (std::ranges::adjacent_find(elements_, {}, &Element::number) != elements_.end())
      file_.fail(ErrorCode::InputUnreadable, "two elements have the same number");
    const bool has_cells =
        std::ranges::any_of(elements_, [](const Element& e) { return dimension_of(e.type.block) == 3; });
    group_elements(has_cells ? 3 : 2);
    for (Element& element : elements_) add(element, nodes);
    check_read_mesh(file_, mesh_);
    if (has_cells) add_surfaces();
    if (has_cells) turn_surfaces();
    classify_points(mesh_, {});
    mids_.finish(file_, mesh_, true);
    return std::move(mesh_);
  }

  // Elements of dimension `dim` get the first set that has them, in the order of names.
  void group_elements(int dim) {
    GroupTags groups(dim);
    const auto put = [&](Element* element, const std::string& name, std::uint32_t& group) {
      if (element == nullptr || element->group != kNone || dimension_of(element->type.block) != dim) return;
      if (group == kNone) group = groups.find(name);
      element->group = group;
    };
    for (const auto& [name, numbers] : sets_) {
      std::uint32_t group = kNone;
      for (const std::uint64_t number : numbers) put(find_element(number), name, group);
    }
    for (const Range& range : ranges_) {
      std::uint32_t group = kNone;
      for (auto at = std::ranges::lower_bound(elements_, range.first, {}, &Element::number);
           at != elements_.end() && at->number <= range.last; ++at)
        if ((at->number - range.first) % range.step == 0) put(&*at, range.set, group);
    }
    const std::vector<std::uint32_t> index_of = groups.assign(mesh_.entities);
    for (Element& element : elements_)
      if (element.group != kNone) element.group = index_of[element.group];
  }

  void add(Element& element, const NodeTags& nodes) {
    visit_block(mesh_, element.type.block, [&](auto& elements, auto& entities) {
      element.place = static_cast<std::uint32_t>(elements.size());
      auto& verts = elements.emplace_back();
      std::size_t next = element.first_node;
      for (std::uint32_t& v : verts) v = nodes.find(nodes_[next++]);
      entities.push_back(element.group);
      std::array<std::uint32_t, kMostNodes> mids;
      for (std::size_t i = 0; i < element.type.mid_nodes; ++i) mids[i] = nodes.find(nodes_[next++]);
      mids_.add(verts, edges_of(element.type.block).first(element.type.mid_nodes), mids);
    });
  }

  void add_surfaces() {
    const std::vector<std::uint32_t> index_of = faces_.assign(mesh_.entities);
    for (const SurfaceItem& item : surface_items_) {
      const std::uint32_t face = index_of[item.group];
      if (item.set.empty()) {
        add_face(find_element(item.element), item.number, face);
      } else if (const auto set = sets_.find(item.set); set != sets_.end()) {
        for (const std::uint64_t number : set->second) add_face(find_element(number), item.number, face);
      }
    }
  }

  // Of a face that several surfaces name, the first one counts.
  void add_face(const Element* element, int number, std::uint32_t face) {
    if (element == nullptr || dimension_of(element->type.block) != 3) return;
    const std::size_t kind = cell_kind_of(element->type.block);
    const auto* local = std::ranges::find(kInpFaceNumbers[kind], number);
    if (local == kInpFaceNumbers[kind].end()) return;
    const std::span<const std::uint32_t> cell = vertices_of({static_cast<CellKind>(kind), element->place});
    std::array<std::uint32_t, 4> verts{};
    const LocalFace& shape = kCellShapes[kind].face[static_cast<std::size_t>(local - kInpFaceNumbers[kind].begin())];
    for (std::size_t i = 0; i < shape.count; ++i) verts[i] = cell[shape.vert[i]];
    std::array<std::uint32_t, 4> key = verts;
    std::sort(key.begin(), key.begin() + shape.count);
    if (shape.count == 3) key[3] = kNone;
    if (!known_faces_.insert(key).second) return;
    if (shape.count == 3) {
      mesh_.tri_to_vert.push_back({verts[0], verts[1], verts[2]});
      mesh_.tri_to_entity.push_back(face);
    } else {
      mesh_.quad_to_vert.push_back(verts);
      mesh_.quad_to_entity.push_back(face);
    }
  }
  // Between two regions a surface may name cells of both; all its elements point out of the lower one.
  void turn_surfaces() {
    const CellFaces faces(mesh_, serial_loop(), FacesOf::Surface);
    const auto turn = [&](std::size_t number, auto& verts) {
      const std::uint32_t face = faces.find_surface(static_cast<std::uint32_t>(number));
      const std::uint32_t twin = face == kNone ? kNone : faces.twin(face);
      if (twin == kNone) return;
      const auto region_of_face = [&](std::uint32_t f) { return tetloom::region_of(mesh_, cell_of(faces, f)); };
      const std::uint32_t lower = region_of_face(twin) < region_of_face(face) ? twin : face;
      std::array<std::uint32_t, 4> outwards;
      std::ranges::copy(faces.vertices(lower, outwards), verts.begin());
    };
    for (std::size_t t = 0; t < mesh_.tri_to_vert.size(); ++t) turn(t, mesh_.tri_to_vert[t]);
    for (std::size_t q = 0; q < mesh_.quad_to_vert.size(); ++q)
      turn(mesh_.tri_to_vert.size() + q, mesh_.quad_to_vert[q]);
  }

  CellRef cell_of(const CellFaces& faces, std::uint32_t face) const {
    std::size_t number = faces.cell(face);
    CellRef cell{faces.kind_of_cell(faces.cell(face)), 0};
    for (const CellKind kind : kAllCellKinds)
      if (kind < cell.kind) number -= cell_count(mesh_, kind);
    cell.index = number;
    return cell;
  }

  std::span<const std::uint32_t> vertices_of(CellRef cell) const { return tetloom::vertices_of(mesh_, cell); }

  struct Range {
    std::string set;
    std::uint64_t first = 0, last = 0, step = 1;
  };

  const InputFile& file_;
  Cursor cursor_;
  std::string_view line_;  // what is left of it
  std::size_t lines_ = 0;
  ReadLine read_line_ = nullptr;  // of the keyword at hand; null: nothing is wanted of it
  std::map<std::string, std::string> parameters_;
  int parts_ = 0;
  InpType type_{Block::Tet};
  std::string set_;
  std::vector<std::uint64_t>* numbers_ = nullptr;  // of the set that elements or numbers are added to
  bool is_generated_ = false;
  std::uint32_t surface_ = 0;
  std::vector<std::uint64_t> pending_;  // of an element that goes on
  Mesh mesh_;
  std::vector<std::uint64_t> node_tags_, nodes_;
  std::vector<Element> elements_;
  std::size_t last_found_ = 0;
  std::map<std::string, std::vector<std::uint64_t>, std::less<>> sets_;
  std::vector<Range> ranges_;
  GroupTags faces_{2};
  std::vector<SurfaceItem> surface_items_;
  std::set<std::array<std::uint32_t, 4>> known_faces_;
  MidNodeReader mids_;
};

}  // namespace

Mesh read_inp(const InputFile& file) { return InpReader(file).read(); }

}  // namespace tetloom::detail
