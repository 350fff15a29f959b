#pragma once
// --group and the file of --groups: model entities that files for solvers have under one name.
//
//   --group load=faces:3,7-9,bolt*      --group walls=faces:#ff0000      --group top=faces:+z
//   {"groups": [{"name": "load", "faces": [3, "7-9", "bolt*"]},
//               {"name": "slope", "faces": [{"normal": [0, 1, 1], "angle": 10}]}]}
//
// An item is a tag, a range of tags, a name in which * stands for any characters and ? for one, a colour as #rrggbb, or
// a direction: flat or curved faces whose normal out of their region is nowhere further from it than an angle (5
// degrees).
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/part_mesh.hpp"

namespace tetloom::app {

/// Faces whose normals point somewhere.
struct NormalWish {
  Vec3 direction;
  double angle = 5;  ///< degrees
};

/// One item of a group; of several members the one that is not empty.
struct GroupItem {
  std::string text;  ///< as it was written, for messages
  std::uint32_t first_tag = 0, last_tag = 0;
  std::string pattern, color;
  NormalWish normal;  ///< with a direction of length 1
};

/// A group that files are to have, as the command was asked for it.
struct GroupWish {
  std::string name;
  int dim = 2;
  std::vector<GroupItem> items;
};

/// An item as on the command line, or in a file. Errors: InvalidArgument.
GroupItem parse_group_item(const std::string& text, int dim, const std::string& place);
GroupItem parse_group_item(const nlohmann::json& json, int dim, const std::string& place);

/// Whether the item means the entity, which has the dimension that the item was read for.
bool is_meant(const GroupItem& item, ModelEntity entity, const GeometricModel& model);

/// "NAME=KIND:ITEM,ITEM…", where KIND is regions, faces, edges or vertices. Errors: InvalidArgument.
GroupWish parse_group(const std::string& text);

/// A file of --groups. `path` is for messages. Errors: InvalidArgument with the line, or with the entry that is wrong.
std::vector<GroupWish> parse_groups(const std::string& text, const std::string& path);
std::vector<GroupWish> read_groups(const std::filesystem::path& path);

/// An entity and the group that it belongs to.
struct GroupMember {
  ModelEntity entity;
  std::string group;
};

/// The entities that the wishes mean, ascending. Errors: InvalidArgument that lists all items that mean nothing in
/// `model`, or an entity that two groups want.
std::vector<GroupMember> find_members(const std::vector<GroupWish>& wishes, const GeometricModel& model);

/// Notes the groups in `mesh.entities`.
void apply_groups(const std::vector<GroupMember>& members, const GeometricModel& model, EntityTable& entities);

/// The same in what a part knows of its entities, `PartMesh::entities`.
void apply_groups(const std::vector<GroupMember>& members, std::vector<PartEntity>& entities);

}  // namespace tetloom::app
