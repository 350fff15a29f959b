// Exodus files, read back by a few lines that know netCDF.
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstring>
#include <map>
#include <numeric>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/netcdf/netcdf_writer_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using namespace tetloom::detail;
using test::file_content;
using test::TemporaryFolder;

namespace {

/// What a netCDF file of a classic form holds.
class NetcdfFile {
 public:
  explicit NetcdfFile(std::string content) : bytes_(std::move(content)) {
    REQUIRE(bytes_.starts_with("CDF"));
    form_ = bytes_[3];
    at_ = 4;
    records = count();
    for (std::size_t i = list(10); i > 0; --i) {
      const std::string name = text();
      order_.push_back(name);
      dimensions[name] = count();
    }
    read_attributes(attributes);
    for (std::size_t i = list(11); i > 0; --i) read_variable();
  }

  std::size_t records = 0;
  std::map<std::string, std::size_t> dimensions;
  std::map<std::string, std::string> attributes;  // raw
  std::map<std::string, std::map<std::string, std::string>> attributes_of;

  bool has(const std::string& name) const { return begins_.contains(name); }
  std::vector<std::int32_t> integers(const std::string& name) const { return numbers<std::int32_t>(name, 4); }
  std::vector<double> reals(const std::string& name) const { return numbers<double>(name, 6); }
  std::vector<std::string> texts(const std::string& name) const {
    const auto& [type, shape, begin] = begins_.at(name);
    REQUIRE(type == 2);
    REQUIRE(shape.size() == 2);
    std::vector<std::string> result;
    for (std::size_t i = 0; i < shape[0]; ++i) {
      const std::string line = bytes_.substr(begin + i * shape[1], shape[1]);
      result.push_back(line.substr(0, line.find('\0')));
    }
    return result;
  }
  /// Where the variable that ends last does.
  std::size_t end() const { return end_; }

 private:
  struct Variable {
    std::size_t type;
    std::vector<std::size_t> shape;
    std::size_t begin;
  };

  template <class Number>
  Number number_at(std::size_t at) const {
    std::array<char, sizeof(Number)> raw;
    REQUIRE(at + sizeof(Number) <= bytes_.size());
    std::reverse_copy(bytes_.begin() + static_cast<std::ptrdiff_t>(at),
                      bytes_.begin() + static_cast<std::ptrdiff_t>(at + sizeof(Number)), raw.begin());
    return std::bit_cast<Number>(raw);
  }
  template <class Number>
  Number next() {
    at_ += sizeof(Number);
    return number_at<Number>(at_ - sizeof(Number));
  }
  std::size_t count() { return form_ == 5 ? next<std::uint64_t>() : next<std::uint32_t>(); }
  std::size_t list(std::uint32_t kind) {
    const auto found = next<std::uint32_t>();
    const std::size_t length = count();
    REQUIRE(found == (length > 0 ? kind : 0));
    return length;
  }
  std::string take(std::size_t size) {
    const std::string taken = bytes_.substr(at_, size);
    at_ += (size + 3) / 4 * 4;
    return taken;
  }
  std::string text() { return take(count()); }
  static std::size_t size_of(std::size_t type) { return type == 2 ? 1 : type == 6 ? 8 : 4; }

  void read_attributes(std::map<std::string, std::string>& into) {
    for (std::size_t i = list(12); i > 0; --i) {
      const std::string name = text();
      const auto type = next<std::uint32_t>();
      into[name] = take(count() * size_of(type));
    }
  }
  void read_variable() {
    const std::string name = text();
    Variable variable{0, {}, 0};
    for (std::size_t i = count(); i > 0; --i) variable.shape.push_back(dimensions.at(order_.at(count())));
    read_attributes(attributes_of[name]);
    variable.type = next<std::uint32_t>();
    const std::size_t stated = count();
    variable.begin = next<std::uint64_t>();
    std::size_t size = size_of(variable.type);
    const bool grows = !variable.shape.empty() && variable.shape[0] == 0;
    for (const std::size_t length : variable.shape) size *= std::max<std::size_t>(length, 1);
    CHECK(stated == (size + 3) / 4 * 4);
    if (!grows) end_ = std::max(end_, variable.begin + stated);
    begins_.emplace(name, variable);
  }
  template <class Number>
  std::vector<Number> numbers(const std::string& name, std::size_t expected_type) const {
    const auto& [type, shape, begin] = begins_.at(name);
    REQUIRE(type == expected_type);
    const std::size_t size = std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
    std::vector<Number> values;
    for (std::size_t i = 0; i < size; ++i) values.push_back(number_at<Number>(begin + i * sizeof(Number)));
    return values;
  }

  std::string bytes_;
  char form_ = 0;
  std::size_t at_ = 0, end_ = 0;
  std::vector<std::string> order_;
  std::map<std::string, Variable> begins_;
};

NetcdfFile written(const Mesh& mesh) {
  const TemporaryFolder folder;
  write_mesh(mesh, folder / "a.exo");
  NetcdfFile file(file_content(folder / "a.exo"));
  CHECK(file.end() == file_content(folder / "a.exo").size());
  return file;
}

struct Side {
  std::size_t corners;
  std::array<int, 4> vert;
};
/// "Element side numbering" of Exodus II (Schoof, Yarberry 1994), from 1.
const std::map<std::string, std::vector<Side>> kSides{
    {"TETRA", {{3, {1, 2, 4}}, {3, {2, 3, 4}}, {3, {1, 4, 3}}, {3, {1, 3, 2}}}},
    {"PYRAMID", {{3, {1, 2, 5}}, {3, {2, 3, 5}}, {3, {3, 4, 5}}, {3, {1, 5, 4}}, {4, {1, 4, 3, 2}}}},
    {"WEDGE", {{4, {1, 2, 5, 4}}, {4, {2, 3, 6, 5}}, {4, {1, 4, 6, 3}}, {3, {1, 3, 2}}, {3, {4, 5, 6}}}},
    {"HEX",
     {{4, {1, 2, 6, 5}},
      {4, {2, 3, 7, 6}},
      {4, {3, 4, 8, 7}},
      {4, {1, 5, 8, 4}},
      {4, {1, 4, 3, 2}},
      {4, {5, 6, 7, 8}}}}};

Vec3 point_of(const NetcdfFile& file, std::int32_t node) {
  const auto at = static_cast<std::size_t>(node - 1);
  return {file.reals("coordx").at(at), file.reals("coordy").at(at), file.reals("coordz").at(at)};
}

/// The area vectors of all sides of all side sets, added up, and how often each block's type was met.
struct SideSums {
  std::map<std::string, double> areas;  // by name of the set
  std::size_t sides = 0;
};

SideSums add_sides(const NetcdfFile& file) {
  struct Element {
    std::string type;
    std::vector<std::int32_t> nodes;
  };
  std::vector<Element> elements;
  for (std::size_t block = 1; block <= file.dimensions.at("num_el_blk"); ++block) {
    const std::string number = std::to_string(block);
    const auto nodes = file.integers("connect" + number);
    const std::size_t size = file.dimensions.at("num_nod_per_el" + number);
    for (std::size_t first = 0; first < nodes.size(); first += size)
      elements.push_back({file.attributes_of.at("connect" + number).at("elem_type"),
                          {nodes.begin() + static_cast<std::ptrdiff_t>(first),
                           nodes.begin() + static_cast<std::ptrdiff_t>(first + size)}});
  }
  REQUIRE(elements.size() == file.dimensions.at("num_elem"));
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < file.dimensions.at("num_nodes"); ++i)
    points.push_back(point_of(file, static_cast<std::int32_t>(i + 1)));
  SideSums sums;
  const auto names = file.texts("ss_names");
  for (std::size_t set = 1; set <= names.size(); ++set) {
    const auto of = file.integers("elem_ss" + std::to_string(set)),
               side = file.integers("side_ss" + std::to_string(set));
    Vec3 area;
    for (std::size_t i = 0; i < of.size(); ++i, ++sums.sides) {
      const Element& element = elements.at(static_cast<std::size_t>(of[i] - 1));
      const Side& local = kSides.at(element.type).at(static_cast<std::size_t>(side[i] - 1));
      const auto at = [&](std::size_t k) {
        return points.at(static_cast<std::size_t>(element.nodes.at(static_cast<std::size_t>(local.vert[k] - 1)) - 1));
      };
      for (std::size_t k = 2; k < local.corners; ++k) area += 0.5 * cross(at(k - 1) - at(0), at(k) - at(0));
    }
    sums.areas[names[set - 1]] = norm(area);
  }
  return sums;
}

}  // namespace

TEST_CASE("Exodus: blocks have the cells of their regions, side sets the sides of the cells on their faces") {
  Mesh mesh = test::make_mixed_box(4, 3, 5, 7, true);
  mesh.entities[3].resize(2);
  mesh.entities[3][0].name = mesh.entities[3][1].name = "steel part";
  const NetcdfFile file = written(mesh);
  CHECK(file.dimensions.at("num_nodes") == mesh.points.size());
  CHECK(file.dimensions.at("num_elem") == cell_count(mesh));
  CHECK(file.records == 0);
  const auto names = file.texts("eb_names");
  CHECK(std::set<std::string>(names.begin(), names.end()).size() == names.size());
  CHECK(std::ranges::count(names, "steel_part") == 1);
  CHECK(std::ranges::count(names, "steel_part_2_prisms") == 1);
  // Faces of a box are flat: their sides' areas add up to the face's.
  const SideSums sums = add_sides(file);
  CHECK(sums.sides == surface_count(mesh));
  double total = 0;
  for (const auto& [name, area] : sums.areas) total += area;
  CHECK(total == Approx(2 * (4 * 3 + 4 * 5 + 3 * 5) + 3 * 5));
}

TEST_CASE("Exodus: cells come back with their vertices, by group") {
  const Mesh mesh = test::make_box(4, 2, 2, true);
  const NetcdfFile file = written(mesh);
  const Groups groups = make_groups(mesh);
  REQUIRE(file.dimensions.at("num_el_blk") == 2);
  for (std::size_t block = 0; block < 2; ++block) {
    const auto nodes = file.integers("connect" + std::to_string(block + 1));
    const std::vector<std::uint32_t>& members = groups[3][block].elements;
    REQUIRE(nodes.size() == 4 * members.size());
    for (std::size_t i = 0; i < members.size(); ++i)
      for (std::size_t k = 0; k < 4; ++k)
        CHECK(static_cast<std::uint32_t>(nodes[4 * i + k]) == mesh.tet_to_vert[members[i]][k] + 1);
  }
  const auto x = file.reals("coordx"), z = file.reals("coordz");
  for (std::size_t v = 0; v < mesh.points.size(); ++v) CHECK((x[v] == mesh.points[v].x && z[v] == mesh.points[v].z));
}

TEST_CASE("Exodus: node sets have the points of faces, edges and vertices under their names") {
  Mesh mesh = test::make_box(4, 2, 2, true);
  test::decorate(mesh);
  const NetcdfFile file = written(mesh);
  const Groups groups = make_groups(mesh);
  const ElementNodes nodes(mesh);
  const auto names = file.texts("ns_names");
  REQUIRE(names.size() == groups[0].size() + groups[1].size() + groups[2].size());
  for (const std::size_t dim : {0, 1, 2})
    for (const Group& group : groups[dim]) {
      const auto found = std::ranges::find(names, group.name);
      REQUIRE(found != names.end());
      std::vector<std::uint32_t> points;
      for (const std::int32_t node : file.integers("node_ns" + std::to_string(found - names.begin() + 1)))
        points.push_back(static_cast<std::uint32_t>(node - 1));
      CHECK(points == points_of(mesh, nodes, static_cast<int>(dim), group));
    }
}

TEST_CASE("Exodus: mid nodes stand behind the vertices, those of edges up before those of the top") {
  Mesh mesh = test::with_mid_nodes(test::make_mixed_box(4, 3, 5, 7, true));
  const NetcdfFile file = written(mesh);
  // Edges by the order of Exodus, from 1.
  const std::map<std::string, std::vector<std::pair<int, int>>> edges{
      {"TETRA10", {{1, 2}, {2, 3}, {1, 3}, {1, 4}, {2, 4}, {3, 4}}},
      {"PYRAMID13", {{1, 2}, {2, 3}, {3, 4}, {4, 1}, {1, 5}, {2, 5}, {3, 5}, {4, 5}}},
      {"WEDGE15", {{1, 2}, {2, 3}, {3, 1}, {1, 4}, {2, 5}, {3, 6}, {4, 5}, {5, 6}, {6, 4}}},
      {"HEX20", {{1, 2}, {2, 3}, {3, 4}, {4, 1}, {1, 5}, {2, 6}, {3, 7}, {4, 8}, {5, 6}, {6, 7}, {7, 8}, {8, 5}}}};
  const auto x = file.reals("coordx"), y = file.reals("coordy"), z = file.reals("coordz");
  const auto at = [&](std::int32_t node) {
    const auto i = static_cast<std::size_t>(node - 1);
    return Vec3{x[i], y[i], z[i]};
  };
  std::set<std::string> types;
  for (std::size_t block = 1; block <= file.dimensions.at("num_el_blk"); ++block) {
    const std::string number = std::to_string(block);
    const std::string type = file.attributes_of.at("connect" + number).at("elem_type");
    types.insert(type);
    const auto nodes = file.integers("connect" + number);
    const std::size_t size = file.dimensions.at("num_nod_per_el" + number), corners = size - edges.at(type).size();
    double worst = 0;
    for (std::size_t first = 0; first < nodes.size(); first += size)
      for (std::size_t k = 0; k < edges.at(type).size(); ++k) {
        const auto [a, b] = edges.at(type)[k];
        const Vec3 middle = 0.5 * (at(nodes[first + static_cast<std::size_t>(a) - 1]) +
                                   at(nodes[first + static_cast<std::size_t>(b) - 1]));
        worst = std::max(worst, distance(middle, at(nodes[first + corners + k])));
      }
    CHECK(worst == 0);
  }
  CHECK(types.size() == 4);
}

TEST_CASE("Exodus: a surface has blocks of triangles for its faces, and no side sets") {
  Mesh mesh = test::make_box(4, 2, 2, true);
  mesh.tet_to_vert.clear(), mesh.tet_to_entity.clear();
  const NetcdfFile file = written(mesh);
  CHECK(file.dimensions.at("num_elem") == mesh.tri_to_vert.size());
  CHECK(file.dimensions.at("num_el_blk") == 11);
  CHECK_FALSE(file.has("ss_prop1"));
  CHECK(file.has("ns_prop1"));
}

TEST_CASE("netCDF: the form for large variables says the same in longer numbers") {
  const TemporaryFolder folder;
  NetcdfWriter writer;
  const auto rows = writer.add_dimension("rows", 3), width = writer.add_dimension("width", 5);
  writer.put("title", std::string("five!"));
  writer.put("version", 8.0f);
  writer.add_texts("names", rows, width, {"a", "bcde", ""});
  writer.add_integers("numbers", rows, {1, -2, 3});
  writer.put_on_variable("name", "ID");
  CHECK(writer.needed_form() == NetcdfForm::Offset64);
  for (const NetcdfForm form : {NetcdfForm::Offset64, NetcdfForm::Data64}) {
    AtomicFile file(folder / "a.nc");
    writer.write(file, form);
    file.commit();
    const NetcdfFile read(file_content(folder / "a.nc"));
    CHECK(read.texts("names") == std::vector<std::string>{"a", "bcde", ""});
    CHECK(read.integers("numbers") == std::vector<std::int32_t>{1, -2, 3});
    CHECK(read.attributes.at("title") == "five!");
    CHECK(read.attributes_of.at("numbers").at("name") == "ID");
  }
  writer.add_variable("large", NetcdfType::Float64, {writer.add_dimension("many", 600'000'000)});
  CHECK(writer.needed_form() == NetcdfForm::Data64);
}

TEST_CASE("Exodus files are read by meshio, where it is installed") {
  if (!test::has_meshio() || !test::succeeds("/usr/bin/python3 -c 'import netCDF4'")) return;
  const TemporaryFolder folder;
  const Mesh mesh = test::make_box(4, 2, 2, true);
  write_mesh(mesh, folder / "a.exo");
  const std::string script = "import meshio; m = meshio.read('" + (folder / "a.exo").string() +
                             "'); assert len(m.points) == " + std::to_string(mesh.points.size()) +
                             " and sum(len(c.data) for c in m.cells) == " + std::to_string(mesh.tet_to_vert.size());
  CHECK(test::succeeds("/usr/bin/python3 -c \"" + script + "\"", folder / "log"));
}
