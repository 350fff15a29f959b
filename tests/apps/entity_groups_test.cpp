// Groups of model entities: --group and the file of --groups.
#include <catch2/catch.hpp>

#include "apps/tetloom/entity_groups.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/with_attributes.hpp"

using namespace tetloom;
using namespace tetloom::app;
using test::error_of;
using test_models::WithAttributes;

namespace {

std::vector<std::uint32_t> tags_of(const std::vector<std::string>& groups, const GeometricModel& model) {
  std::vector<GroupWish> wishes;
  for (const std::string& text : groups) wishes.push_back(parse_group(text));
  std::vector<std::uint32_t> tags;
  for (const GroupMember& member : find_members(wishes, model)) tags.push_back(member.entity.tag());
  return tags;
}

WithAttributes named_box() {
  WithAttributes model(test_models::make_box({0, 0, 0}, {1, 2, 3}));
  model.change(2, 0).name = "bolt 1";
  model.change(2, 3).name = "bolt 12";
  model.change(2, 4).name = "base";
  model.change(2, 5).color = Color{1, 0, 0};
  return model;
}

using Tags = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("faces are meant by tags, ranges, names, colours and directions") {
  const WithAttributes box = named_box();
  CHECK(tags_of({"a=faces:3,5-6,1"}, box) == Tags{1, 3, 5, 6});
  CHECK(tags_of({"a=faces:bolt*"}, box) == Tags{1, 4});
  CHECK(tags_of({"a=faces:bolt ??"}, box) == Tags{4});
  CHECK(tags_of({"a=faces:b*e,2"}, box) == Tags{2, 5});
  CHECK(tags_of({"a=faces:#FF0000"}, box) == Tags{6});
  CHECK(tags_of({"a=faces:+x"}, box) == Tags{2});
  CHECK(tags_of({"a=faces:-x,+z"}, box) == Tags{1, 6});
  CHECK(tags_of({"a=edges:2", "b=regions:1", "c=vertices:8"}, box) == Tags{8, 2, 1});
}

TEST_CASE("a curved face points somewhere only within the angle") {
  const auto cylinder = test_models::make_cylinder(1, 2);  // side, bottom, top
  CHECK(tags_of({"a=faces:-z"}, *cylinder) == Tags{2});
  const auto with_angle = [&](double angle) {
    const auto wishes = parse_groups(
        R"({"groups": [{"name": "a", "faces": [{"normal": [0, 0, 2], "angle": )" + std::to_string(angle) + "}]}]}",
        "g");
    Tags tags;
    for (const GroupMember& member : find_members(wishes, *cylinder)) tags.push_back(member.entity.tag());
    return tags;
  };
  CHECK(with_angle(5) == Tags{3});
  CHECK(with_angle(95) == Tags{1, 3});
}

TEST_CASE("groups that make no sense are refused with their place") {
  const auto reason = [](const std::string& text) { return error_of([&] { parse_group(text); }).message; };
  for (const char* text : {"load", "=faces:1", "load=faces", "load:faces=3"})
    CHECK_THAT(reason(text), Catch::Contains("NAME=faces"));
  CHECK_THAT(reason("load=solids:1"), Catch::Contains("solids"));
  CHECK_THAT(reason("load=faces:1,,2"), Catch::Contains("empty"));
  CHECK_THAT(reason("load=faces:"), Catch::Contains("empty"));
  CHECK_THAT(reason("load=faces:7-3"), Catch::Contains("backwards"));
  CHECK_THAT(reason("load=edges:+z"), Catch::Contains("only faces"));

  const auto json_reason = [](const std::string& text) {
    return error_of([&] { parse_groups(text, "g.json"); }).message;
  };
  CHECK_THAT(json_reason("{"), Catch::Contains("g.json") && Catch::Contains("line 1"));
  CHECK_THAT(json_reason(R"({"groups": [{"faces": [1]}]})"), Catch::Contains("groups[0]") && Catch::Contains("name"));
  CHECK_THAT(json_reason(R"({"groups": [{"name": "a"}]})"), Catch::Contains("one of"));
  CHECK_THAT(json_reason(R"({"groups": [{"name": "a", "faces": []}]})"), Catch::Contains("no items"));
  CHECK_THAT(json_reason(R"({"groups": [{"name": "a", "faces": [{"normal": [0, 0, 0]}]}]})"),
             Catch::Contains("direction"));
  CHECK_THAT(json_reason(R"({"groups": [{"name": "a", "faces": [{"normal": [0, 0, 1], "angle": 0}]}]})"),
             Catch::Contains("angle"));
  CHECK_THAT(json_reason(R"({"groups": [{"name": "a", "tags": [1]}]})"), Catch::Contains("tags"));
}

TEST_CASE("what the model does not have, and what two groups want, is refused by name") {
  const WithAttributes box = named_box();
  const Diagnostic missing = error_of([&] { tags_of({"load=faces:9,blot*", "top=edges:#00ff00"}, box); });
  CHECK(missing.code == ErrorCode::InvalidArgument);
  CHECK_THAT(missing.message, Catch::Contains("'9'") && Catch::Contains("'blot*'") && Catch::Contains("'#00ff00'") &&
                                  Catch::Contains("'load'"));
  CHECK_THAT(error_of([&] {
               tags_of({"a=faces:1-3", "b=faces:3"}, box);
             }).message,
             Catch::Contains("'a'") && Catch::Contains("'b'") && Catch::Contains("faces 3"));
}

TEST_CASE("groups are noted at the entities of the mesh, which may know none yet") {
  const WithAttributes box = named_box();
  EntityTable entities;
  apply_groups(find_members({parse_group("load=faces:2,4")}, box), box, entities);
  REQUIRE(entities[2].size() == 6);
  CHECK(entities[2][1].group == "load");
  CHECK(entities[2][2].group.empty());
  std::vector<PartEntity> known{{ModelFaceId(1), false, {}, {}}, {ModelFaceId(2), true, {}, {}}};
  apply_groups(find_members({parse_group("load=faces:2,4")}, box), known);
  CHECK(known[0].attributes.group == "load");
  CHECK(known[0].has_attributes);
  CHECK(known[1].attributes.group.empty());
}
