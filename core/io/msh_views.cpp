// Views of Gmsh: fields on nodes and elements (Gmsh reference manual, "MSH file format").
#include <limits>
#include <map>
#include <optional>

#include "core/io/msh_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

/// Fields may take so many times the size of the file: a view that leaves most carriers out is given NaN there.
constexpr std::size_t kLargestRatioOfViews = 64;
constexpr std::size_t kMostComponents = 1'000'000;

/// The cells of a mesh by their tags in the file.
class CellTags {
 public:
  explicit CellTags(const std::array<std::vector<std::uint64_t>, kBlocks>& element_tags) {
    std::size_t cell = 0;
    for (std::size_t block = static_cast<std::size_t>(Block::Tet); block < kBlocks; ++block)
      for (const std::uint64_t tag : element_tags[block]) cells_.emplace_back(tag, cell++);
    if (!std::is_sorted(cells_.begin(), cells_.end())) std::sort(cells_.begin(), cells_.end());
  }
  std::optional<std::size_t> find(std::uint64_t tag) const {
    const auto place = std::lower_bound(cells_.begin(), cells_.end(), std::pair{tag, std::size_t{0}});
    return place == cells_.end() || place->first != tag ? std::nullopt : std::optional(place->second);
  }

 private:
  std::vector<std::pair<std::uint64_t, std::size_t>> cells_;
};

/// One number for each of the tags of a view's head, of which there must be at least `least`.
template <class Number>
std::vector<Number> read_head(Cursor& cursor, std::size_t least) {
  const auto count = cursor.parse<std::uint64_t>();
  cursor.expect(count, 2);
  if (count < least) cursor.file().fail_at_line("a view with too few tags", cursor.at());
  std::vector<Number> tags(count);
  for (Number& tag : tags) tag = cursor.parse<Number>();
  return tags;
}

std::string read_title(Cursor& cursor) {
  const auto count = cursor.parse<std::uint64_t>();
  cursor.expect(count, 1);
  cursor.line();
  std::string title;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::string_view line = cursor.line();
    if (i > 0) continue;
    const std::size_t open = line.find('"'), close = line.rfind('"');
    if (open != std::string_view::npos && open != close) line = line.substr(open + 1, close - open - 1);
    title = line;
  }
  return title;
}

/// Gives fields their values, as long as the file is large enough for them.
struct FieldSpace {
  const InputFile& file;
  std::uint64_t bytes = 0;

  void take(MeshField& field, std::size_t carriers) {
    const std::size_t size = static_cast<std::size_t>(field.components) * carriers;
    bytes += 8 * size;
    if (bytes / kLargestRatioOfViews > file.bytes().size())
      file.fail(ErrorCode::InputUnreadable, "the views are too large for what the file has of them");
    field.values.assign(size, std::numeric_limits<double>::quiet_NaN());
  }
};

/// Puts the values of a view where `find` finds the carriers of its tags, into the field that another part of the view
/// has made or a new one. Those beyond the last carrier belong to other slices.
template <class Find>
void fill(const MshView& view, FieldSpace& space, std::vector<MeshField>& fields, std::size_t carriers,
          const Find& find) {
  MeshField* field = find_field(fields, view.name);
  if (field != nullptr && static_cast<std::size_t>(field->components) != view.components)
    space.file.fail(ErrorCode::InputUnreadable, "the parts of the view '" + view.name + "' do not agree");
  Cursor cursor = view.numbers;
  MshNumbers numbers(cursor, view.binary);
  for (std::uint64_t i = 0; i < view.count; ++i) {
    const std::optional<std::size_t> carrier = find(static_cast<std::uint64_t>(numbers.integer()));
    if (carrier && field == nullptr) {
      field = &fields.emplace_back(MeshField{view.name, static_cast<int>(view.components), {}});
      space.take(*field, carriers);
    }
    for (std::size_t c = 0; c < view.components; ++c) {
      const double value = numbers.real();
      if (carrier && *carrier < carriers) field->values[*carrier * view.components + c] = value;
    }
  }
}

}  // namespace

void MshViews::read_section(Cursor& cursor, bool binary, std::string_view section) {
  const char* const place = cursor.at();
  std::string name = read_title(cursor);
  read_head<double>(cursor, 0);
  const std::vector<std::int64_t> integers = read_head<std::int64_t>(cursor, 3);
  cursor.line();
  const std::int64_t components = integers[1], count = integers[2];
  if (components < 1 || components > static_cast<std::int64_t>(kMostComponents) || count < 0)
    file_.fail_at_line(
        "a view of " + std::to_string(components) + " components and " + std::to_string(count) + " values", place);
  const auto numbers = static_cast<std::size_t>(components);
  cursor.expect(static_cast<std::uint64_t>(count), binary ? 4 + 8 * numbers : 2 * (1 + numbers));
  if (name.empty()) name = "view " + std::to_string(views_.size() + 1);
  views_.push_back({std::move(name), section == "NodeData", binary, integers[0], numbers,
                    static_cast<std::uint64_t>(count), cursor});
  if (binary) cursor.jump(cursor.at() + static_cast<std::size_t>(count) * (4 + 8 * numbers));
}

void MshViews::add_fields(Mesh& mesh, const MshCarriers& carriers) const {
  const bool has_element_data = std::any_of(views_.begin(), views_.end(), [](const MshView& v) { return !v.on_nodes; });
  const CellTags cells(has_element_data ? carriers.element_tags : std::array<std::vector<std::uint64_t>, kBlocks>{});
  std::map<std::pair<bool, std::string>, std::int64_t> first_step;
  FieldSpace space{file_};
  for (const MshView& view : views_) {
    file_.check_cancelled();
    if (first_step.try_emplace({view.on_nodes, view.name}, view.step).first->second != view.step) continue;
    if (view.on_nodes)
      fill(view, space, mesh.point_fields, mesh.points.size(), [&](std::uint64_t tag) {
        const std::optional<std::size_t> point = carriers.find_point(tag);
        if (!point)
          file_.fail(ErrorCode::InputUnreadable, "the view '" + view.name + "' has a value on node " +
                                                     std::to_string(tag) + ", which is not there");
        return point;
      });
    else
      fill(view, space, mesh.cell_fields, cell_count(mesh), [&](std::uint64_t tag) {
        const std::optional<std::size_t> cell = cells.find(tag);
        return cell || !carriers.is_cell_elsewhere(tag) ? cell : std::optional(cell_count(mesh));
      });
  }
}

}  // namespace tetloom::detail
