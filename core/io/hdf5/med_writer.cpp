// MED 4.1: one mesh, with a family and a group for each model entity. Families of elements are called
// "tetloom_<dimension>_<tag>", those of points "tetloom_point_<dimension>_<tag>"; they bring the classification back.
#include <limits>
#include <map>

#include "core/io/hdf5/hdf5_writer_detail.hpp"
#include "core/io/hdf5/med_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

constexpr const char* kNoProfile = "MED_NO_PROFILE_INTERNAL";
const std::string kMeshPath = "/ENS_MAA/mesh";
const std::string kStep = kMeshPath + "/-0000000000000000001-0000000000000000001";
const std::string kFamilies = "/FAS/mesh";

class MedWriter {
 public:
  MedWriter(const Mesh& mesh, const BlockLoop& loop)
      : mesh_(mesh), loop_(loop), groups_(make_groups(mesh)), nodes_(mesh) {}

  void write(AtomicFile& file) {
    write_heads();
    write_families();
    write_points();
    out_.add_group(kStep + "/MAI");
    out_.put(kStep + "/MAI", "CGT", 1);
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto& entities) {
      if (!elements.empty()) write_elements(block, elements, entities);
    });
    out_.write(file);
  }

 private:
  void write_heads() {
    out_.add_group("/INFOS_GENERALES");
    out_.put("/INFOS_GENERALES", "MAJ", 4);
    out_.put("/INFOS_GENERALES", "MIN", 1);
    out_.put("/INFOS_GENERALES", "REL", 0);
    out_.add_group(kMeshPath);
    for (const char* name : {"DIM", "ESP"}) out_.put(kMeshPath, name, 3);
    for (const char* name : {"NXI", "NXT"}) out_.put(kMeshPath, name, -1);
    for (const char* name : {"REP", "SRT", "TYP"}) out_.put(kMeshPath, name, 0);
    out_.put(kMeshPath, "DES", std::string());
    out_.put(kMeshPath, "UNT", std::string());
    out_.put(kMeshPath, "NOM", std::string("X               Y               Z               "));
    out_.put(kMeshPath, "UNI", std::string(48, ' '));
    out_.add_group(kStep);
    out_.put(kStep, "CGT", 1);
    for (const char* name : {"NDT", "NOR", "NXI", "NXT", "PVI", "PVT"}) out_.put(kStep, name, -1);
    out_.put(kStep, "PDT", 0.0);
  }

  void write_family(const std::string& path, std::int32_t number, const std::string& group) {
    out_.add_group(path);
    out_.put(path, "NUM", number);
    if (group.empty()) return;
    out_.add_group(path + "/GRO");
    out_.put(path + "/GRO", "NBR", 1);
    out_.add_characters(path + "/GRO/NOM", {group}, kMedNameBytes);
  }

  void write_families() {
    write_family(kFamilies + "/FAMILLE_ZERO", 0, "");
    std::int32_t number = 0;
    for (const std::size_t dim : {3, 2, 1})
      for (const Group& group : groups_[dim])
        for (const std::uint32_t tag : group.tags) {
          if (tag == 0) continue;
          families_[dim][tag] = --number;
          write_family(kFamilies + "/ELEME/tetloom_" + std::to_string(dim) + "_" + std::to_string(tag), number,
                       group.name);
        }
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      const ModelEntity entity = entity_of_point(mesh_, v);
      if (entity.valid()) point_families_.try_emplace(entity, 0);
    }
    std::map<std::uint32_t, std::string> corners;
    for (const Group& group : groups_[0])
      for (const std::uint32_t tag : group.tags) corners[tag] = group.name;
    number = 0;
    for (auto& [entity, family] : point_families_) {
      family = ++number;
      // meshio wants a group in every family.
      const std::string name = "tetloom_point_" + std::to_string(entity.dim) + "_" + std::to_string(entity.tag());
      write_family(kFamilies + "/NOEUD/" + name, family, entity.dim == 0 ? corners[entity.tag()] : name);
    }
  }

  void put_count(const std::string& array, std::size_t count) {
    out_.put(array, "CGT", 1);
    out_.put(array, "NBR", static_cast<std::int32_t>(count));
  }

  void write_points() {
    const std::string path = kStep + "/NOE";
    const std::size_t count = mesh_.points.size();
    out_.add_group(path);
    out_.put(path, "CGS", 1);
    out_.put(path, "CGT", 1);
    out_.put(path, "PFL", std::string(kNoProfile));
    out_.add_array(path + "/COO", Hdf5Type::Float64, {3 * count}, [this, count](AtomicFile& file) {
      for (int axis = 0; axis < 3; ++axis)
        file.put_each(
            count, [&](std::size_t v) { return mesh_.points[v][axis]; }, loop_);
    });
    put_count(path + "/COO", count);
    const auto family_of = [this](std::size_t v) {
      const ModelEntity entity = entity_of_point(mesh_, v);
      return entity.valid() ? point_families_.at(entity) : 0;
    };
    add_integers(path + "/FAM", count, family_of);
    put_count(path + "/FAM", count);
  }

  template <class ValueOf>
  void add_integers(const std::string& path, std::size_t count, const ValueOf& value) {
    out_.add_array(path, Hdf5Type::Int32, {count},
                   [this, count, value](AtomicFile& file) { file.put_each(count, value, loop_); });
  }

  template <class Elements>
  void write_elements(Block block, const Elements& elements, const std::vector<std::uint32_t>& entities) {
    const MedKind& kind = med_kind(block);
    const bool is_second = nodes_.are_second_order();
    const std::string path = kStep + "/MAI/" + (is_second ? kind.second_name : kind.name);
    const std::size_t count = elements.size();
    out_.add_group(path);
    out_.put(path, "CGS", 1);
    out_.put(path, "CGT", 1);
    out_.put(path, "GEO", is_second ? kind.second_geometry : kind.geometry);
    out_.put(path, "PFL", std::string(kNoProfile));
    const std::span<const LocalEdge> edges = edges_of(block);
    const std::size_t size = nodes_.count(block);
    out_.add_array(path + "/NOD", Hdf5Type::Int32, {count * size}, [=, this, &elements, &kind](AtomicFile& file) {
      for (std::size_t node = 0; node < size; ++node)
        file.put_each(
            count, [&](std::size_t e) { return number_of(elements[e], kind, edges, node); }, loop_);
    });
    put_count(path + "/NOD", count);
    const auto& families = families_[static_cast<std::size_t>(dimension_of(block))];
    add_integers(path + "/FAM", count, [&entities, &families](std::size_t e) {
      return entities[e] == kNone ? 0 : families.at(tag_of_index(entities[e]));
    });
    put_count(path + "/FAM", count);
  }

  // Of a node of an element, counted from 1.
  template <class Element>
  std::int32_t number_of(const Element& element, const MedKind& kind, std::span<const LocalEdge> edges,
                         std::size_t node) const {
    const auto vertex = [&](std::size_t i) { return element[kind.vert[i]]; };
    if (node < element.size()) return static_cast<std::int32_t>(vertex(node) + 1);
    const auto [a, b] = edges[node - element.size()];
    return static_cast<std::int32_t>(nodes_.mid(vertex(a), vertex(b)) + 1);
  }

  const Mesh& mesh_;
  const BlockLoop& loop_;
  Groups groups_;
  ElementNodes nodes_;
  Hdf5Writer out_;
  std::array<std::map<std::uint32_t, std::int32_t>, 4> families_;  // by dimension and tag
  std::map<ModelEntity, std::int32_t> point_families_;
};

}  // namespace

void write_med(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  std::size_t most = mesh.points.size();
  for_each_block(mesh, [&](Block, const auto& elements, const auto&) { most = std::max(most, elements.size()); });
  if (most > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument, "MED files hold at most 2^31 - 1 points and elements of a kind");
  MedWriter(mesh, loop).write(file);
}

}  // namespace tetloom::detail
