#include "threading/parts/group_names.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "core/base/codec.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::detail {
namespace {

using NamesByEntity = std::map<ModelEntity, std::array<std::string, 2>>;  // name, group

void note_elements(const PartMesh& part, std::array<std::set<std::uint32_t>, 4>& tags) {
  for (const PackedEntity packed : part.vert_to_entity) {
    const ModelEntity entity = packed.unpack();
    if (entity.valid() && entity.dim == 0) tags[0].insert(entity.tag());
  }
  const auto note = [](const GrowingArray<std::uint32_t>& entities, std::set<std::uint32_t>& seen) {
    std::optional<std::uint32_t> last;
    for (const std::uint32_t entity : entities) {
      const std::uint32_t tag = entity + 1;  // 0 for none
      if (tag != last) seen.insert(tag);
      last = tag;
    }
  };
  note(part.block(BoundaryKind::Edge).to_entity, tags[1]);
  for (const BoundaryKind kind : {BoundaryKind::Triangle, BoundaryKind::Quad})
    note(part.block(kind).to_entity, tags[2]);
  for (const CellBlock& block : part.cells) note(block.to_region, tags[3]);
}

void note_names(const PartMesh& part, NamesByEntity& names) {
  for (const PartEntity& known : part.entities)
    if (known.has_attributes) names[known.entity] = {known.attributes.name, known.attributes.group};
}

void put_names(MessageWriter& writer, const NamesByEntity& names) {
  writer.put(static_cast<std::uint64_t>(names.size()));
  for (const auto& [entity, texts] : names) {
    writer.put(static_cast<std::uint32_t>(entity.dim));
    writer.put(entity.index);
    for (const std::string& text : texts) put_text(writer, text);
  }
}

void take_names(MessageReader& reader, EntityTable& entities) {
  const auto count = reader.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    auto& table = entities[reader.get<std::uint32_t>()];
    const auto index = reader.get<std::uint32_t>();
    if (table.size() <= index) table.resize(std::size_t{index} + 1);
    table[index].name = get_text(reader);
    table[index].group = get_text(reader);
  }
}

}  // namespace

GroupNames gather_group_names(const PartitionedMesh& mesh) {
  std::array<std::set<std::uint32_t>, 4> tags;
  NamesByEntity names;
  for (const PartId part : mesh.local()) {
    note_elements(mesh.parts.at(part).mesh, tags);
    note_names(mesh.parts.at(part).mesh, names);
  }
  GroupNames all;
  std::array<std::set<std::uint32_t>, 4> all_tags;
  const auto put = [&](MessageWriter& writer) {
    for (const auto& own : tags) writer.put_array<std::uint32_t>(std::vector<std::uint32_t>(own.begin(), own.end()));
    put_names(writer, names);
  };
  const auto take = [&](MessageReader& reader) {
    for (auto& known : all_tags)
      for (const std::uint32_t tag : reader.get_array<std::uint32_t>()) known.insert(tag);
    take_names(reader, all.entities);
  };
  gather(*mesh.communicator, put, take);
  TagsByDim lists;
  for (std::size_t dim = 0; dim < lists.size(); ++dim) lists[dim].assign(all_tags[dim].begin(), all_tags[dim].end());
  all.groups = name_groups(all.entities, lists);
  return all;
}

}  // namespace tetloom::detail
