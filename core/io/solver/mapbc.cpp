#include "core/io/solver/mapbc.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <system_error>
#include <vector>

#include "core/io/formats_detail.hpp"
#include "core/io/solver/groups.hpp"

namespace tetloom::detail {
namespace {

constexpr std::int64_t kLargestTableTag = 10'000;  // for which a table of entities is made on the word of a small file

struct MapbcRow {
  std::int64_t tag = 0, code = 0;
  std::string name;  // may be empty
};

std::vector<MapbcRow> read_rows(const std::filesystem::path& path, const CancelToken* cancel) {
  const InputFile file(path, cancel);
  Cursor cursor(file, file.bytes());
  const auto count = cursor.parse<std::uint64_t>();
  constexpr std::size_t kLeastBytes = 3;
  cursor.line();
  cursor.expect(count, kLeastBytes);
  std::vector<MapbcRow> rows;
  rows.reserve(count);
  for (std::uint64_t i = 0; i < count; ++i) {
    MapbcRow& row = rows.emplace_back();
    row.tag = cursor.parse<std::int64_t>();
    row.code = cursor.parse<std::int64_t>();
    Cursor line(file, cursor.line());
    row.name = line.token();
  }
  return rows;
}

bool is_there(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::exists(path, ignored);
}

std::string own_name(std::int64_t tag) { return "face_" + std::to_string(tag); }

// Of the faces that have triangles or quadrilaterals.
std::set<std::int64_t> tags_of_faces(const Mesh& mesh) {
  std::set<std::int64_t> tags;
  std::uint32_t last = kNone;
  for (const auto* entities : {&mesh.tri_to_entity, &mesh.quad_to_entity})
    for (const std::uint32_t entity : *entities)
      if (entity != last && (last = entity) != kNone) tags.insert(std::int64_t{entity} + 1);
  return tags;
}

}  // namespace

std::filesystem::path mapbc_beside(const std::filesystem::path& path, std::string_view extension) {
  std::string name = path.filename().string();
  name.resize(name.size() - extension.size());
  return path.parent_path() / (name + ".mapbc");
}

void write_mapbc(const Mesh& mesh, const std::filesystem::path& path, AtomicFile& file, const CancelToken* cancel) {
  std::map<std::int64_t, std::int64_t> codes;
  if (is_there(path))
    for (const MapbcRow& row : read_rows(path, cancel)) codes[row.tag] = row.code;
  std::map<std::uint32_t, std::string> names;
  const Groups groups = make_groups(mesh);
  for (const Group& group : groups[2])
    for (const std::uint32_t tag : group.tags)
      if (tag != 0) names[tag] = group.name;
  file.write(std::to_string(names.size()) + "\n");
  for (const auto& [tag, name] : names) {
    const auto known = codes.find(tag);
    file.write(std::to_string(tag) + " " + std::to_string(known == codes.end() ? 0 : known->second) + " " + name +
               "\n");
  }
}

void read_mapbc(const std::filesystem::path& path, Mesh& mesh, const CancelToken* cancel) {
  if (!is_there(path)) return;
  const std::set<std::int64_t> tags = tags_of_faces(mesh);
  std::map<std::int64_t, std::string> names;
  std::map<std::string, std::size_t> uses;
  for (MapbcRow& row : read_rows(path, cancel)) {
    const bool is_named = !row.name.empty() && row.name != own_name(row.tag);
    if (is_named && tags.contains(row.tag) && names.emplace(row.tag, row.name).second) ++uses[row.name];
  }
  const auto largest = std::max<std::int64_t>(kLargestTableTag, static_cast<std::int64_t>(surface_count(mesh)));
  for (const auto& [tag, name] : names) {
    if (tag > largest) continue;
    std::vector<EntityAttributes>& faces = mesh.entities[2];
    if (faces.size() < static_cast<std::size_t>(tag)) faces.resize(static_cast<std::size_t>(tag));
    EntityAttributes& face = faces[static_cast<std::size_t>(tag) - 1];
    (uses[name] > 1 ? face.group : face.name) = name;
  }
}

}  // namespace tetloom::detail
