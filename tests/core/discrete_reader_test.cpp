// Reading STL and OBJ files, good and bad.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <random>

#include "tests/core/discrete_shapes.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::shapes;

namespace {

ErrorCode code_of(const std::filesystem::path& path, const ReadOptions& options = {}) {
  try {
    read_discrete_model(path, options);
  } catch (const Error& error) {
    INFO(error.what());
    CHECK(std::string(error.what()).size() > 10);
    return error.code();
  }
  FAIL("read without an error: " << path);
  return ErrorCode::Internal;
}

std::size_t healed(const ModelDocument& document, const std::string& word) {
  for (const HealingStep& step : document.healing) {
    if (step.what.find(word) != std::string::npos) return step.count;
  }
  return 0;
}

const Facets kBox = make_box({0, 0, 0}, {1, 2, 3}, 2);

}  // namespace

TEST_CASE("binary and ASCII STL of a box give 6 faces, 12 edges, 8 vertices and one region") {
  const TemporaryFolder folder;
  const std::string name = GENERATE("a.stl", "b.STL", "c.stl", "d.stl");
  const std::string bytes = name == "a.stl"   ? ascii_stl(kBox, "my box")
                            : name == "c.stl" ? binary_stl(kBox, "solid but binary")
                            : name == "d.stl" ? binary_stl(kBox) + "trailer"
                                              : binary_stl(kBox);
  const std::filesystem::path path = folder.write(name, bytes);
  const ModelDocument document = read_discrete_model(path);
  CHECK(document.format == "STL");
  const ModelTopology& topology = document.model->topology();
  CHECK(topology.face_count() == 6);
  CHECK(topology.edge_count() == 12);
  CHECK(topology.vertex_count == 8);
  REQUIRE(topology.region_count() == 1);
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(6));
  CHECK(document.healing.empty());
  for (const FaceSides& sides : topology.face_to_sides) {
    CHECK(sides.back == ModelRegionId(0));
    CHECK(!sides.front.valid());
  }
  if (name == "a.stl") CHECK(document.model->attributes(ModelRegionId(0)).name == "my box");
  if (name == "d.stl") CHECK(document.warnings.size() == 1);
}

TEST_CASE("the solids of an ASCII STL file bound and name faces") {
  const TemporaryFolder folder;
  Facets low = kBox, high = kBox;
  low.triangles.resize(low.triangles.size() / 2);
  high.triangles.erase(high.triangles.begin(), high.triangles.begin() + high.triangles.size() / 2);
  const auto document = read_discrete_model(folder.write("two.stl", ascii_stl(low, "low") + ascii_stl(high, "high")));
  REQUIRE(document.model->topology().region_count() == 1);
  REQUIRE(document.model->topology().face_count() == 6);
  CHECK(document.model->attributes(ModelFaceId(0)).name == "low");
  CHECK(document.model->attributes(ModelFaceId(5)).name == "high");
}

TEST_CASE("an OBJ file with quads, a concave polygon, groups, negative indices and continued lines is read") {
  const TemporaryFolder folder;
  // A prism over an L, its top and bottom six-cornered, its two flat sides in the plane y = 0 of different groups.
  const std::string text =
      "# a prism\nmtllib x.mtl\no prism\n"
      "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n"
      "v 0 0 1\nv 2 0 1\nv 2 1 1\nv 1 1 1\nv 1 2 1\nv 0 2 1 1.0\nvn 0 0 1\nvt 0 0\n"
      "g bottom\nusemtl steel\nf 6 5 4 3 2 1\ng top\nf -6/1/1 -5//1 -4/1 \\\n -3 -2 -1\n"
      "g sides\ns off\nf 1 2 8 7\nf 2 3 9 8\r\nf 3 4 10 9\nf 4 5 11 10\nf 5 6 12 11\nf 6 1 7 12";
  const ModelDocument document = read_discrete_model(folder.write("prism.obj", text));
  CHECK(document.format == "OBJ");
  const GeometricModel& model = *document.model;
  CHECK(model.topology().face_count() == 8);
  CHECK(model.topology().edge_count() == 18);
  REQUIRE(model.topology().region_count() == 1);
  CHECK(model.volume(ModelRegionId(0)) == Approx(3));
  CHECK(model.area(ModelFaceId(0)) == Approx(3));
  CHECK(model.attributes(ModelFaceId(0)).name == "bottom");
  CHECK(model.attributes(ModelFaceId(1)).name == "top");
  CHECK(model.attributes(ModelFaceId(7)).name == "sides");
}

TEST_CASE("groups of an OBJ file divide a flat side") {
  const TemporaryFolder folder;
  const std::string text =
      "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 0 1 0\ng left\nf 1 2 5 6\ng right\nf 2 3 4 5\n";
  const ModelDocument document = read_discrete_model(folder.write("plate.obj", text));
  const GeometricModel& model = *document.model;
  REQUIRE(model.topology().face_count() == 2);
  CHECK(model.topology().edge_count() == 7);
  CHECK(model.topology().vertex_count == 6);
  CHECK(model.topology().region_count() == 0);
  CHECK(model.attributes(ModelFaceId(1)).name == "right");
}

TEST_CASE("a file that is missing, a directory, empty or of an unknown kind is refused") {
  const TemporaryFolder folder;
  CHECK(code_of(folder.path() / "none.stl") == ErrorCode::InputUnreadable);
  std::filesystem::create_directory(folder.path() / "folder.stl");
  CHECK(code_of(folder.path() / "folder.stl") == ErrorCode::InputUnreadable);
  CHECK(code_of(folder.write("empty.stl", "")) == ErrorCode::InputUnreadable);
  CHECK(code_of(folder.write("empty.obj", "")) == ErrorCode::InputUnreadable);
  CHECK(code_of(folder.write("box.ply", "ply")) == ErrorCode::InvalidArgument);
  CHECK(code_of("/dev/zero.stl") == ErrorCode::InputUnreadable);
}

TEST_CASE("an STL file cut off anywhere is unreadable, never half a model") {
  const TemporaryFolder folder;
  const std::string whole = GENERATE(binary_stl(kBox), ascii_stl(kBox, "box"));
  for (const std::size_t size : {std::size_t{1}, std::size_t{20}, std::size_t{83}, std::size_t{84}, std::size_t{100},
                                 whole.size() / 2 + 20, whole.size() - 15}) {
    INFO("cut to " << size << " bytes of " << whole.size());
    CHECK(code_of(folder.write("cut.stl", whole.substr(0, size))) == ErrorCode::InputUnreadable);
  }
}

TEST_CASE("text STL is read whatever its end, its case and its number of solids") {
  const TemporaryFolder folder;
  const std::string whole = ascii_stl(kBox, "box"), body = whole.substr(0, whole.rfind("endsolid"));
  Facets high;
  append(high, make_box({5, 0, 0}, {6, 2, 3}, 2));
  std::string upper = whole;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  struct Variant {
    std::string text;
    std::size_t regions, remarks;
  };
  for (const Variant& variant :
       {Variant{body + "end solid", 1, 0}, Variant{body + "endsolid", 1, 0}, Variant{body + "end\n", 1, 0},
        Variant{body, 1, 1}, Variant{upper, 1, 0}, Variant{"\xef\xbb\xbf" + whole, 1, 0},
        Variant{whole + "written by nobody\n\x1a", 1, 1}, Variant{body + ascii_stl(high, "high"), 2, 1}}) {
    INFO(variant.text.substr(0, 20) << " … " << variant.text.substr(variant.text.size() - 20));
    const ModelDocument document = read_discrete_model(folder.write("variant.stl", variant.text));
    CHECK(document.model->topology().region_count() == variant.regions);
    CHECK(document.warnings.size() == variant.remarks);
    CHECK(document.model->volume(ModelRegionId(0)) == Approx(6));
  }
}

TEST_CASE("random bytes give an error, whatever they are") {
  const TemporaryFolder folder;
  const unsigned seed = GENERATE(range(1u, 30u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::string bytes(200 + random() % 4000, '\0');
  for (char& c : bytes) c = static_cast<char>(seed % 2 ? random() % 256 : 32 + random() % 95);
  if (seed % 3 == 0) bytes.replace(0, 6, "solid ");
  if (seed % 5 == 0) bytes.replace(0, 4, "v 1\n");
  CHECK(code_of(folder.write("noise.stl", bytes)) == ErrorCode::InputUnreadable);
  CHECK(code_of(folder.write("noise.obj", bytes)) == ErrorCode::InputUnreadable);
}

TEST_CASE("bits flipped in a good file give a model or an error, never a crash") {
  const TemporaryFolder folder;
  const unsigned seed = GENERATE(range(1u, 60u));
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::string bytes = seed % 2 ? binary_stl(kBox) : ascii_stl(kBox, "box");
  for (int flip = 0; flip < 8; ++flip) bytes[random() % bytes.size()] ^= static_cast<char>(1 << random() % 8);
  const auto path = folder.write("flipped.stl", bytes);
  try {
    const std::size_t faces = read_discrete_model(path).model->topology().face_count();
    CHECK(faces > 0);
  } catch (const Error& error) {
    CHECK((error.code() == ErrorCode::InputUnreadable || error.code() == ErrorCode::InputUnsuitable));
  }
}

TEST_CASE("files without a usable facet are unsuitable") {
  const TemporaryFolder folder;
  CHECK(code_of(folder.write("none.stl", binary_stl({}))) == ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("none2.stl", "solid nothing\nendsolid nothing\n")) == ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("none.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")) == ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n")) ==
        ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("nan.stl", binary_stl({{{0, 0, 0}, {1, 0, NAN}, {0, 1, 0}}, {{0, 1, 2}}, {}}))) ==
        ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("inf.obj", "v 0 0 0\nv 1e999 0 0\nv 0 1 0\nf 1 2 3\n")) == ErrorCode::InputUnsuitable);
  CHECK(code_of(folder.write("huge.obj", "v 0 0 0\nv 1e200 0 0\nv 0 1 0\nf 1 2 3\n")) == ErrorCode::InputUnsuitable);
}

TEST_CASE("broken OBJ lines are unreadable") {
  const TemporaryFolder folder;
  const std::string points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* line : {"f 1 2", "f 1 2 4", "f 1 2 0", "f 1 2 -4", "f a b c", "f 1 2 99999999999999999999", "v 1 2",
                           "v 1 2 x", "f 1 2 3 9", "f"}) {
    INFO(line);
    CHECK(code_of(folder.write("broken.obj", points + line + "\n")) == ErrorCode::InputUnreadable);
  }
}

TEST_CASE("a feature angle outside of its range is refused") {
  const TemporaryFolder folder;
  const auto path = folder.write("box.stl", binary_stl(kBox));
  ReadOptions options;
  for (const double angle : {0.0, -1.0, 3.2, std::nan("")}) {
    options.feature_angle = angle;
    CHECK(code_of(path, options) == ErrorCode::InvalidArgument);
  }
}

TEST_CASE("a cancelled read throws Cancelled") {
  const TemporaryFolder folder;
  CancelToken token;
  token.cancel();
  try {
    read_discrete_model(folder.write("box.stl", binary_stl(kBox)), {}, &token);
    FAIL("not cancelled");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::Cancelled);
  }
}

TEST_CASE("facets turned over, repeated and degenerate are healed and reported") {
  const TemporaryFolder folder;
  Facets facets = kBox;
  std::swap(facets.triangles[3][0], facets.triangles[3][1]);
  std::swap(facets.triangles[17][0], facets.triangles[17][1]);
  facets.triangles.push_back(facets.triangles[5]);
  facets.triangles.push_back({facets.triangles[5][1], facets.triangles[5][0], facets.triangles[5][2]});
  facets.triangles.push_back({1, 1, 2});
  const ModelDocument document = read_discrete_model(folder.write("dirty.stl", binary_stl(facets)));
  CHECK(healed(document, "turned over") == 2);
  CHECK(healed(document, "duplicate") == 2);
  CHECK(healed(document, "degenerate") == 1);
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(6));
}

TEST_CASE("a box inside out is turned over") {
  const TemporaryFolder folder;
  Facets facets;
  append(facets, kBox, true);
  const ModelDocument document = read_discrete_model(folder.write("inside_out.stl", binary_stl(facets)));
  CHECK(healed(document, "turned over") == kBox.triangles.size());
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(6));
}

TEST_CASE("cracks as wide as the digits of an ASCII file are closed") {
  const TemporaryFolder folder;
  const unsigned seed = 7;
  INFO("seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> noise(-4e-7, 4e-7);
  Facets soup;  // every facet with points of its own, each a little off
  const Facets sphere = make_sphere({0.3, 0.2, 0.1}, 1, 2);
  for (const Triangle& t : sphere.triangles) {
    for (const std::uint32_t v : t)
      soup.points.push_back(sphere.points[v] + Vec3{noise(random), noise(random), noise(random)});
    const auto end = static_cast<std::uint32_t>(soup.points.size());
    soup.triangles.push_back({end - 3, end - 2, end - 1});
  }
  const ModelDocument document = read_discrete_model(folder.write("cracked.stl", ascii_stl(soup, "cracked", "%.8f")));
  CHECK(healed(document, "cracks") > 0);
  REQUIRE(document.model->topology().region_count() == 1);
  CHECK(document.model->topology().face_count() == 1);
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(volume_of(sphere)).epsilon(1e-4));
}

TEST_CASE("a sliver facet with its corner on its neighbour's side is swapped away") {
  const TemporaryFolder folder;
  Facets facets = make_box({0, 0, 0}, {1, 1, 1});
  // Replace a facet (a, b, c) by (a, m, c), (m, b, c) and the sliver (a, b, m) with m in the middle of a–b.
  const Triangle t = facets.triangles[0];
  const auto m = static_cast<std::uint32_t>(facets.points.size());
  facets.points.push_back(0.5 * (facets.points[t[0]] + facets.points[t[1]]));
  facets.triangles[0] = {t[0], m, t[2]};
  facets.triangles.push_back({m, t[1], t[2]});
  facets.triangles.push_back({t[0], t[1], m});
  const ModelDocument document = read_discrete_model(folder.write("sliver.stl", binary_stl(facets)));
  CHECK(healed(document, "slivers") == 1);
  CHECK(document.model->topology().face_count() == 6);
  CHECK(document.model->topology().edge_count() == 12);
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(1));
}

TEST_CASE("corners of facets on the sides of others are joined to them") {
  const TemporaryFolder folder;
  // A box whose sides have different numbers of facets: the rows of one end on the long sides of the next.
  Facets box;
  const Facets coarse = make_box({0, 0, 0}, {1, 1, 1}, 1), fine = make_box({0, 0, 0}, {1, 1, 1}, 4);
  for (const Facets* from : {&coarse, &fine}) {
    const auto first = static_cast<std::uint32_t>(box.points.size());
    box.points.insert(box.points.end(), from->points.begin(), from->points.end());
    for (std::size_t tri = 0; tri < from->triangles.size(); ++tri) {
      if ((from->groups[tri] % 2 == 1) != (from == &fine)) continue;
      Triangle t = from->triangles[tri];
      for (std::uint32_t& v : t) v += first;
      box.triangles.push_back(t);
    }
  }
  const ModelDocument document = read_discrete_model(folder.write("junctions.stl", binary_stl(box)));
  CHECK(healed(document, "corners lie on") > 0);
  CHECK(document.warnings.empty());
  REQUIRE(document.model->topology().region_count() == 1);
  CHECK(document.model->topology().face_count() == 6);
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(1));
}

TEST_CASE("holes are filled up to the width asked for, and where the surface stays open is said") {
  const TemporaryFolder folder;
  Facets sphere = make_sphere({0, 0, 0}, 1, 4);
  const double whole = volume_of(sphere);
  const auto remove_near = [&](const Vec3& place, double radius) {
    std::erase_if(sphere.triangles, [&](const Triangle& t) {
      return std::any_of(t.begin(), t.end(),
                         [&](std::uint32_t v) { return distance(sphere.points[v], place) < radius; });
    });
  };
  remove_near({0, 0, 1}, 0.15);
  remove_near({1, 0, 0}, 0.3);
  const auto path = folder.write("holes.stl", binary_stl(sphere));
  ReadOptions options;
  const ModelDocument open = read_discrete_model(path, options);
  CHECK(open.model->topology().region_count() == 0);
  CHECK(open.model->topology().face_count() == 1);
  REQUIRE(open.warnings.size() == 1);
  CHECK(open.warnings[0].code == ErrorCode::OpenShell);
  CHECK(open.warnings[0].message.find("2 rims") != std::string::npos);
  REQUIRE(open.warnings[0].point);
  CHECK(open.warnings[0].point->x > 0.8);
  options.fill_holes = 0.6;
  const ModelDocument half_open = read_discrete_model(path, options);
  CHECK(healed(half_open, "holes filled") == 1);
  CHECK(half_open.model->topology().region_count() == 0);
  options.fill_holes = 2;
  const ModelDocument closed = read_discrete_model(path, options);
  CHECK(healed(closed, "holes filled") == 2);
  CHECK(closed.warnings.empty());
  REQUIRE(closed.model->topology().region_count() == 1);
  CHECK(closed.model->volume(ModelRegionId(0)) == Approx(whole).epsilon(0.01));
  options.fill_holes = -1;
  CHECK(code_of(path, options) == ErrorCode::InvalidArgument);
}

TEST_CASE("needles between points that are nearly one are collapsed, and the surface stays closed") {
  const TemporaryFolder folder;
  // Every column of a cylinder twice, a hair apart: half of its side are needles, and two edges of every third facet.
  const std::uint32_t columns = 24;
  const Facets cylinder = make_cylinder(1, 2, 2 * columns, 4);
  Facets facets = cylinder;
  for (std::size_t p = 0; p + 2 < facets.points.size(); ++p) {
    const std::size_t column = p % (2 * columns);
    const double angle = 2 * M_PI * static_cast<double>(column / 2) / columns + (column % 2 ? 1e-5 : 0);
    facets.points[p] = {std::cos(angle), std::sin(angle), facets.points[p].z};
  }
  const ModelDocument document = read_discrete_model(folder.write("needles.stl", binary_stl(facets)));
  CHECK(healed(document, "needles") == 5 * columns);
  CHECK(document.model->topology().region_count() == 1);
  CHECK(document.model->topology().face_count() == 3);
  CHECK(document.warnings.empty());
  CHECK(document.model->volume(ModelRegionId(0)) == Approx(volume_of(facets)).epsilon(1e-4));
}

TEST_CASE("arrays that do not fit together are refused") {
  const Facets box = make_box({0, 0, 0}, {1, 1, 1});
  const std::vector<std::uint32_t> short_groups(3, 0);
  CHECK_THROWS_AS(make_discrete_model(box.points, box.triangles, 0.7, short_groups), Error);
  CHECK_THROWS_AS(make_discrete_model({}, box.triangles, 0.7), Error);
  CHECK_THROWS_AS(make_discrete_model(box.points, {}, 0.7), Error);
  CHECK_THROWS_AS(make_discrete_model(box.points, box.triangles, -1), Error);
}
