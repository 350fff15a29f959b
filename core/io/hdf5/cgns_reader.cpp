// CGNS 2.5 to 4 in HDF5: the one unstructured zone of the first base. Sections are groups of elements by their names;
// those of faces that are in boundary conditions by the names of families, or of the conditions.
#include <algorithm>
#include <optional>

#include "core/io/hdf5/cgns_detail.hpp"
#include "core/io/hdf5/hdf5_reader_detail.hpp"
#include "core/io/mid_node_reader_detail.hpp"
#include "core/io/solver/group_tags.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kItemsBetweenLooks = std::size_t{1} << 16;

struct ElementType {
  Block block;
  bool is_second;
};

std::optional<ElementType> find_cgns_type(std::int64_t number) {
  for (std::size_t i = 0; i < kBlocks; ++i)
    for (const bool is_second : {false, true})
      if (number == (is_second ? kCgnsKinds[i].second_type : kCgnsKinds[i].type))
        return ElementType{static_cast<Block>(i), is_second};
  return {};
}

// Of a section of our own: "wall.quad" are more elements of "wall".
std::string_view group_in(std::string_view section) {
  const std::size_t dot = section.rfind('.');
  for (const CgnsKind& kind : kCgnsKinds)
    if (dot != std::string_view::npos && section.substr(dot + 1) == kind.name) return section.substr(0, dot);
  return section;
}

class CgnsReader {
 public:
  explicit CgnsReader(const InputFile& file) : file_(file), in_(file) {}

  Mesh read() {
    find_zone();
    read_points();
    for (const std::string& section : members(zone_, "Elements_t")) read_section(section);
    std::ranges::sort(faces_, {}, &Face::number);
    for (const std::string& conditions : members(zone_, "ZoneBC_t"))
      for (const std::string& condition : members(conditions, "BC_t")) read_condition(condition);
    assign_entities();
    check_read_mesh(file_, mesh_);
    classify_points(mesh_, {});
    mids_.finish(file_, mesh_, true);
    return std::move(mesh_);
  }

 private:
  struct Face {
    std::int64_t number;  // of the element in the file
    Block block;
    std::uint32_t place;
  };

  // Paths of the nodes below another that have a label.
  std::vector<std::string> members(const std::string& parent, std::string_view label) {
    std::vector<std::string> found;
    for (const std::string& name : in_.names_in(parent.empty() ? "/" : parent)) {
      const std::string path = parent + "/" + name;
      if (in_.has_attribute(path, "label") && in_.text_attribute(path, "label") == label) found.push_back(path);
    }
    return found;
  }
  static std::string name_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }
  std::string text(const std::string& node) {
    if (!in_.has(node + "/ data")) return {};
    std::string joined;
    for (const std::int64_t c : in_.integers(node + "/ data")) joined += static_cast<char>(c);
    return joined.substr(0, joined.find('\0'));
  }

  void find_zone() {
    const std::vector<std::string> bases = members("", "CGNSBase_t");
    if (bases.empty()) file_.fail(ErrorCode::InputUnreadable, "the file has no CGNS base");
    const std::vector<std::string> zones = members(bases[0], "Zone_t");
    if (zones.size() != 1)
      file_.fail(ErrorCode::InputUnsuitable,
                 "the file has " + std::to_string(zones.size()) + " zones; only files with one zone are read");
    zone_ = zones[0];
    if (text(zone_ + "/ZoneType") == "Structured")
      file_.fail(ErrorCode::InputUnsuitable, "the zone is structured; only unstructured ones are read");
  }

  void read_points() {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string path = zone_ + "/GridCoordinates/Coordinate" + "XYZ"[axis] + "/ data";
      if (!in_.has(path))
        file_.fail(ErrorCode::InputUnsuitable, "the zone has no CoordinateX, CoordinateY and CoordinateZ");
      const std::vector<double> values = in_.reals(path);
      if (axis == 0) mesh_.points.resize(values.size());
      if (values.size() != mesh_.points.size())
        file_.fail(ErrorCode::InputUnreadable, "the coordinates have different lengths");
      for (std::size_t v = 0; v < values.size(); ++v) mesh_.points[v][axis] = values[v];
    }
    if (mesh_.points.size() >= kNone) file_.fail(ErrorCode::InputUnsuitable, "the file has too many points");
  }

  void read_section(const std::string& path) {
    const std::vector<std::int64_t> types = in_.integers(path + "/ data");
    const std::vector<std::int64_t> range = in_.integers(path + "/ElementRange/ data");
    if (types.empty() || range.size() != 2) file_.fail(ErrorCode::InputUnreadable, "'" + path + "' is no section");
    if (types[0] == kCgnsNode) return;
    const std::vector<std::int64_t> nodes = in_.integers(path + "/ElementConnectivity/ data");
    std::span<const std::int64_t> left = nodes;
    std::int64_t number = range[0];
    Section section{std::string(group_in(name_of(path))), {kNone, kNone, kNone, kNone}};
    for (std::size_t e = 0; !left.empty(); ++e) {
      if (e % kItemsBetweenLooks == 0) file_.check_cancelled();
      std::int64_t type = types[0];
      if (type == kCgnsMixed) {
        type = left[0];
        left = left.subspan(1);
      }
      const std::optional<ElementType> known = find_cgns_type(type);
      if (!known) refuse_elements(file_, "ElementType_t " + std::to_string(type));
      const std::size_t size = vertices_of(known->block) + (known->is_second ? edges_of(known->block).size() : 0);
      if (size > left.size()) file_.fail(ErrorCode::InputUnreadable, "'" + path + "' ends within an element");
      add_element(*known, left.first(size), section, number++);
      left = left.subspan(size);
    }
  }

  // The number of a group is asked for when its first element of a dimension comes.
  struct Section {
    std::string group;
    std::array<std::uint32_t, 4> number_in_dim;
  };

  void add_element(ElementType type, std::span<const std::int64_t> nodes, Section& section, std::int64_t number) {
    const auto dim = static_cast<std::size_t>(dimension_of(type.block));
    std::uint32_t& group = section.number_in_dim[dim];
    if (group == kNone) group = groups_[dim].find(section.group);
    visit_block(mesh_, type.block, [&](auto& elements, auto& entities) {
      typename std::remove_reference_t<decltype(elements)>::value_type verts;
      const auto index = [&](std::size_t i) { return stored_index(static_cast<std::uint64_t>(nodes[i]) - 1); };
      for (std::size_t i = 0; i < verts.size(); ++i) verts[i] = index(i);
      if (type.is_second) add_mids(type.block, verts, index);
      if (dim == 2) faces_.push_back({number, type.block, static_cast<std::uint32_t>(elements.size())});
      elements.push_back(verts);
      entities.push_back(group);
    });
  }

  template <class Element, class Index>
  void add_mids(Block block, const Element& verts, const Index& index) {
    std::array<std::uint32_t, kMostNodes> mids{};
    const std::span<const LocalEdge> edges = edges_up_first(block);
    for (std::size_t i = 0; i < edges.size(); ++i) mids[i] = index(verts.size() + i);
    mids_.add(verts, edges, std::span(mids).first(edges.size()));
  }

  // Conditions at vertices say nothing about faces.
  void read_condition(const std::string& path) {
    file_.check_cancelled();
    const std::string location = text(path + "/GridLocation");
    const bool in_range = in_.has(path + "/PointRange/ data"), in_list = in_.has(path + "/PointList/ data");
    const bool old_range = in_.has(path + "/ElementRange/ data"), old_list = in_.has(path + "/ElementList/ data");
    const bool of_elements = old_range || old_list || location == "FaceCenter" || location == "CellCenter";
    if (!of_elements) return;
    const std::string family = text(path + "/FamilyName");
    const std::uint32_t group = groups_[2].find(family.empty() ? name_of(path) : family);
    if (in_range || old_range) {
      const auto range = in_.integers(path + (in_range ? "/PointRange/ data" : "/ElementRange/ data"));
      if (range.size() == 2) set_group(range[0], range[1], group);
    } else if (in_list || old_list) {
      for (const std::int64_t number : in_.integers(path + (in_list ? "/PointList/ data" : "/ElementList/ data")))
        set_group(number, number, group);
    }
  }

  void set_group(std::int64_t first, std::int64_t last, std::uint32_t group) {
    for (auto at = std::ranges::lower_bound(faces_, first, {}, &Face::number); at != faces_.end() && at->number <= last;
         ++at)
      (at->block == Block::Triangle ? mesh_.tri_to_entity : mesh_.quad_to_entity)[at->place] = group;
  }

  // Elements of groups that are called "face_0" and the like have no entity. Numbers of groups become entities.
  void assign_entities() {
    std::array<std::vector<std::uint32_t>, 4> indices;
    std::array<std::uint32_t, 4> none{};
    for (std::size_t dim = 1; dim < 4; ++dim) {
      constexpr std::array<const char*, 4> names{"", "edge_0", "face_0", "region_0"};
      none[dim] = groups_[dim].find(names[dim]);
      indices[dim] = groups_[dim].assign(mesh_.entities);
    }
    for_each_block(mesh_, [&](Block block, const auto&, auto& entities) {
      const auto dim = static_cast<std::size_t>(dimension_of(block));
      for (std::uint32_t& entity : entities) entity = entity == none[dim] ? kNone : indices[dim][entity];
    });
  }

  const InputFile& file_;
  Hdf5Reader in_;
  std::string zone_;
  std::array<GroupTags, 4> groups_{GroupTags(0), GroupTags(1), GroupTags(2), GroupTags(3)};
  std::vector<Face> faces_;  // by their numbers, once all are read
  MidNodeReader mids_;
  Mesh mesh_;
};

}  // namespace

Mesh read_cgns(const InputFile& file) { return CgnsReader(file).read(); }

}  // namespace tetloom::detail
