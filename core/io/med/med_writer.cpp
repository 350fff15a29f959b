// MED 4.1: one mesh, with a family and a group for each model entity. Families of elements are called
// "tetloom_<dimension>_<tag>", those of points "tetloom_point_<dimension>_<tag>"; they bring the classification back.
#include <limits>
#include <map>

#include "core/io/hdf5_detail.hpp"
#include "core/io/med/med_detail.hpp"
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
  MedWriter(const Mesh& mesh, AtomicFile& file) : mesh_(mesh), groups_(make_groups(mesh)), out_(file) {}

  void write() {
    write_heads();
    write_families();
    write_points();
    out_.make_group(kStep + "/MAI");
    out_.put(kStep + "/MAI", "CGT", 1);
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto& entities) {
      if (!elements.empty()) write_elements(block, elements, entities);
    });
    out_.finish();
  }

 private:
  void write_heads() {
    out_.make_group("/INFOS_GENERALES");
    out_.put("/INFOS_GENERALES", "MAJ", 4);
    out_.put("/INFOS_GENERALES", "MIN", 1);
    out_.put("/INFOS_GENERALES", "REL", 0);
    out_.make_group(kMeshPath);
    for (const char* name : {"DIM", "ESP"}) out_.put(kMeshPath, name, 3);
    for (const char* name : {"NXI", "NXT"}) out_.put(kMeshPath, name, -1);
    for (const char* name : {"REP", "SRT", "TYP"}) out_.put(kMeshPath, name, 0);
    out_.put(kMeshPath, "DES", std::string());
    out_.put(kMeshPath, "UNT", std::string());
    out_.put(kMeshPath, "NOM", std::string("X               Y               Z               "));
    out_.put(kMeshPath, "UNI", std::string(48, ' '));
    out_.make_group(kStep);
    out_.put(kStep, "CGT", 1);
    for (const char* name : {"NDT", "NOR", "NXI", "NXT", "PVI", "PVT"}) out_.put(kStep, name, -1);
    out_.put(kStep, "PDT", 0.0);
  }

  void write_family(const std::string& path, std::int32_t number, const std::string& group) {
    out_.make_group(path);
    out_.put(path, "NUM", number);
    if (group.empty()) return;
    out_.make_group(path + "/GRO");
    out_.put(path + "/GRO", "NBR", 1);
    out_.put_names(path + "/GRO/NOM", {group});
  }

  void write_families() {
    write_family(kFamilies + "/FAMILLE_ZERO", 0, "");
    std::int32_t number = 0;
    for (const std::size_t dim : {3, 2, 1})
      for (const Group& group : groups_[dim]) {
        if (group.tag == 0) continue;
        families_[dim][group.tag] = --number;
        write_family(kFamilies + "/ELEME/tetloom_" + std::to_string(dim) + "_" + std::to_string(group.tag), number,
                     group.name);
      }
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      const ModelEntity entity = entity_of_point(mesh_, v);
      if (entity.valid()) point_families_.try_emplace(entity, 0);
    }
    std::map<std::uint32_t, std::string> corners;
    for (const Group& group : groups_[0]) corners[group.tag] = group.name;
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
    out_.make_group(path);
    out_.put(path, "CGS", 1);
    out_.put(path, "CGT", 1);
    out_.put(path, "PFL", std::string(kNoProfile));
    out_.put_components<double>(path + "/COO", count, 3, [&](std::size_t axis, double* out) {
      for (std::size_t v = 0; v < count; ++v) out[v] = mesh_.points[v][static_cast<int>(axis)];
    });
    put_count(path + "/COO", count);
    std::vector<std::int32_t> families(count, 0);
    for (std::size_t v = 0; v < count; ++v) {
      const ModelEntity entity = entity_of_point(mesh_, v);
      if (entity.valid()) families[v] = point_families_.at(entity);
    }
    out_.put_array(path + "/FAM", families);
    put_count(path + "/FAM", count);
  }

  template <class Elements>
  void write_elements(Block block, const Elements& elements, const std::vector<std::uint32_t>& entities) {
    const MedKind& kind = med_kind(block);
    const std::string path = kStep + "/MAI/" + kind.name;
    out_.make_group(path);
    out_.put(path, "CGS", 1);
    out_.put(path, "CGT", 1);
    out_.put(path, "GEO", kind.geometry);
    out_.put(path, "PFL", std::string(kNoProfile));
    const auto fill = [&](std::size_t node, std::int32_t* out) {
      for (std::size_t e = 0; e < elements.size(); ++e)
        out[e] = static_cast<std::int32_t>(elements[e][kind.vert[node]] + 1);
    };
    out_.put_components<std::int32_t>(path + "/NOD", elements.size(), elements[0].size(), fill);
    put_count(path + "/NOD", elements.size());
    const auto& families = families_[static_cast<std::size_t>(dimension_of(block))];
    std::vector<std::int32_t> numbers(elements.size(), 0);
    for (std::size_t e = 0; e < elements.size(); ++e)
      if (entities[e] != kNone) numbers[e] = families.at(tag_of_index(entities[e]));
    out_.put_array(path + "/FAM", numbers);
    put_count(path + "/FAM", elements.size());
  }

  const Mesh& mesh_;
  Groups groups_;
  Hdf5Writer out_;
  std::array<std::map<std::uint32_t, std::int32_t>, 4> families_;  // by dimension and tag
  std::map<ModelEntity, std::int32_t> point_families_;
};

}  // namespace

void write_med(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  static_cast<void>(loop);  // one thread at a time writes HDF5
  std::size_t most = mesh.points.size();
  for_each_block(mesh, [&](Block, const auto& elements, const auto&) { most = std::max(most, elements.size()); });
  if (most > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument, "MED files hold at most 2^31 - 1 points and elements of a kind");
  MedWriter(mesh, file).write();
}

}  // namespace tetloom::detail
