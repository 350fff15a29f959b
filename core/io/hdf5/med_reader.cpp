// MED 3 and 4: the first time step of the first mesh, its families and groups. Fields are not read.
#include <charconv>
#include <limits>
#include <map>
#include <optional>

#include "core/io/hdf5/hdf5_reader_detail.hpp"
#include "core/io/hdf5/med_detail.hpp"
#include "core/io/mid_node_reader_detail.hpp"

namespace tetloom::detail {
namespace {

/// The numbers in "<prefix>_2_17": an entity of dimension 2 with the tag 17.
std::optional<ModelEntity> entity_in(const std::string& name, std::string_view prefix) {
  if (!name.starts_with(prefix) || name.size() < prefix.size() + 3) return {};
  const char* const at = name.data() + prefix.size();
  std::uint32_t tag = 0;
  const auto end = std::from_chars(at + 2, name.data() + name.size(), tag);
  const bool fine = at[0] >= '0' && at[0] <= '3' && at[1] == '_' && end.ec == std::errc() &&
                    end.ptr == name.data() + name.size() && tag > 0;
  return fine ? std::optional(ModelEntity(at[0] - '0', tag - 1)) : std::nullopt;
}

struct Family {
  std::string group;                  // the first one; may be empty
  std::optional<ModelEntity> entity;  // of families of our own
};

class MedReader {
 public:
  explicit MedReader(const InputFile& file) : file_(file), in_(file) {}

  Mesh read() {
    find_mesh();
    read_families("ELEME", "tetloom_", families_);
    read_families("NOEUD", "tetloom_point_", point_families_);
    read_points();
    for (const std::string& name : in_.names_in(step_ + "/MAI")) read_kind(name);
    check_read_mesh(file_, mesh_);
    const bool knows_entities = classify();
    mids_.finish(file_, mesh_, !knows_entities);
    return std::move(mesh_);
  }

 private:
  void find_mesh() {
    const std::vector<std::string> meshes = in_.names_in("/ENS_MAA");
    if (meshes.empty()) file_.fail(ErrorCode::InputUnreadable, "the file has no MED mesh");
    const std::string path = "/ENS_MAA/" + meshes[0];
    if (in_.attribute(path, "ESP") != 3)
      file_.fail(ErrorCode::InputUnsuitable, "the mesh '" + meshes[0] + "' is not in space");
    families_path_ = "/FAS/" + meshes[0];
    for (const std::string& step : in_.names_in(path))
      if (step_.empty() && in_.has(path + "/" + step + "/NOE/COO")) step_ = path + "/" + step;
    if (step_.empty()) file_.fail(ErrorCode::InputUnsuitable, "the mesh '" + meshes[0] + "' has no nodes of its own");
  }

  void read_families(const char* carrier, std::string_view prefix, std::map<std::int64_t, Family>& families) {
    const std::string path = families_path_ + "/" + carrier;
    for (const std::string& name : in_.names_in(path)) {
      file_.check_cancelled();
      const std::string family = path + "/" + name;
      Family& known = families[in_.attribute(family, "NUM")];
      known.entity = entity_in(name, prefix);
      if (!in_.has(family + "/GRO/NOM")) continue;
      const std::vector<std::string> groups = in_.texts(family + "/GRO/NOM");
      if (!groups.empty()) known.group = groups[0];
      if (known.entity) keep_name(*known.entity, known.group);
    }
  }

  // A name that says no more than the tag is none. No table grows beyond what names in the file take.
  void keep_name(ModelEntity entity, const std::string& name) {
    constexpr std::array<const char*, 4> kinds{"vertex_", "edge_", "face_", "region_"};
    if (name == kinds[entity.dim] + std::to_string(entity.tag()) || name.starts_with("tetloom_point_")) return;
    if (name.empty() || entity.index >= file_.bytes().size() / kMedNameBytes) return;
    auto& names = mesh_.entities[entity.dim];
    if (names.size() <= entity.index) names.resize(entity.index + 1);
    names[entity.index].name = name;
  }

  void read_points() {
    const std::vector<double> values = in_.reals(step_ + "/NOE/COO");
    const std::size_t count = values.size() / 3;
    if (values.size() % 3 != 0) file_.fail(ErrorCode::InputUnreadable, "the coordinates are not three for each node");
    mesh_.points.resize(count);
    for (std::size_t v = 0; v < count; ++v)
      for (std::size_t axis = 0; axis < 3; ++axis) mesh_.points[v][static_cast<int>(axis)] = values[axis * count + v];
  }

  void read_kind(const std::string& name) {
    file_.check_cancelled();
    bool known = false;
    for_each_block(mesh_, [&](Block block, auto& elements, auto& entities) {
      const MedKind& kind = med_kind(block);
      const bool is_second = name == kind.second_name;
      if (name != kind.name && !is_second) return;
      known = true;
      read_elements(block, name, vertices_of(block) + (is_second ? edges_of(block).size() : 0), elements, entities);
    });
    if (!known && name != "PO1") refuse_elements(file_, name);
  }

  std::vector<std::int64_t> read_family_numbers(const std::string& path, std::size_t count) {
    if (!in_.has(path)) return std::vector<std::int64_t>(count, 0);
    std::vector<std::int64_t> numbers = in_.integers(path);
    if (numbers.size() != count)
      file_.fail(ErrorCode::InputUnreadable, "'" + path + "' has another length than its elements");
    return numbers;
  }

  // Appends them: a mesh may have elements of both orders, which is refused at the end.
  template <class Element>
  void read_elements(Block block, const std::string& name, std::size_t size, std::vector<Element>& elements,
                     std::vector<std::uint32_t>& entities) {
    const std::string path = step_ + "/MAI/" + name;
    const std::vector<std::int64_t> nodes = in_.integers(path + "/NOD");
    const std::size_t count = nodes.size() / size, first = elements.size();
    if (nodes.size() % size != 0)
      file_.fail(ErrorCode::InputUnreadable, "'" + path + "/NOD' is no whole number of elements");
    const std::vector<std::int64_t> numbers = read_family_numbers(path + "/FAM", count);
    const auto node_at = [&](std::size_t e, std::size_t node) {
      return stored_index(static_cast<std::uint64_t>(nodes[node * count + e]) - 1);
    };
    elements.resize(first + count);
    for (std::size_t e = 0; e < count; ++e) {
      std::array<std::uint32_t, kMostNodes> list{};
      for (std::size_t node = 0; node < size; ++node) list[node] = node_at(e, node);
      Element in_med_order, &element = elements[first + e];
      for (std::size_t i = 0; i < element.size(); ++i) in_med_order[i] = element[med_kind(block).vert[i]] = list[i];
      if (size > element.size())
        mids_.add(in_med_order, edges_of(block), std::span(list).subspan(element.size(), size - element.size()));
      entities.push_back(index_of(families_, numbers[e], dimension_of(block)));
    }
  }

  // That of our own family, or one for each name of a group; none where a family has neither.
  std::uint32_t index_of(const std::map<std::int64_t, Family>& families, std::int64_t number, int dim) {
    const auto found = families.find(number);
    if (number == 0 || found == families.end()) return kNone;
    const Family& family = found->second;
    if (family.entity && family.entity->dim == dim) return family.entity->index;
    if (family.entity || family.group.empty()) return kNone;
    auto& names = mesh_.entities[static_cast<std::size_t>(dim)];
    auto& known = by_name_[static_cast<std::size_t>(dim)];
    const auto [at, is_new] = known.try_emplace(family.group, static_cast<std::uint32_t>(names.size()));
    if (is_new) names.emplace_back().name = family.group;
    return at->second;
  }

  // Returns whether families say the entities of points.
  bool classify() {
    const auto numbers = read_family_numbers(step_ + "/NOE/FAM", mesh_.points.size());
    std::vector<std::pair<std::size_t, ModelEntity>> known;
    for (std::size_t v = 0; v < numbers.size(); ++v) {
      const auto found = point_families_.find(numbers[v]);
      if (found == point_families_.end() || numbers[v] == 0) continue;
      if (found->second.entity) known.emplace_back(v, *found->second.entity);
    }
    classify_points(mesh_, {});
    for (const auto& [v, entity] : known) mesh_.point_to_entity[v] = entity;
    return !known.empty();
  }

  const InputFile& file_;
  Hdf5Reader in_;
  std::string step_, families_path_;
  std::map<std::int64_t, Family> families_, point_families_;
  std::array<std::map<std::string, std::uint32_t>, 4> by_name_;
  MidNodeReader mids_;
  Mesh mesh_;
};

}  // namespace

Mesh read_med(const InputFile& file) { return MedReader(file).read(); }

}  // namespace tetloom::detail
