#include "core/io/solver/foam_writer.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <system_error>

#include "core/io/atomic_folder.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

const std::set<std::string> kFiles{"points",   "faces",     "owner",     "neighbour",
                                   "boundary", "cellZones", "faceZones", "pointZones"};

std::string header(const char* type, const char* object, const std::string& note = {}) {
  std::string text = "FoamFile\n{\n    version 2.0;\n    format ascii;\n    class ";
  text += type;
  if (!note.empty()) text += ";\n    note \"" + note + "\"";
  text += ";\n    location \"constant/polyMesh\";\n    object ";
  return text + object + ";\n}\n\n";
}

/// The faces of an OpenFOAM mesh: first those between cells, then the patches.
struct FoamFaces {
  struct Patch {
    std::string name;
    std::size_t first = 0, count = 0;
  };
  struct Zone {
    std::string name;
    std::vector<std::uint32_t> faces;  // numbers of faces here
  };
  std::vector<std::uint32_t> faces;  // of the owners, in CellFaces
  std::size_t internal_count = 0;
  std::vector<Patch> patches;
  std::vector<Zone> zones;
};

class FaceOrder {
 public:
  FaceOrder(const CellFaces& faces, const Groups& groups)
      : faces_(faces), groups_(groups), place_(faces.size(), kNone) {}

  FoamFaces run() {
    put_internal();
    for (const Group& group : groups_[2]) put_group(group);
    put_rest();
    return std::move(result_);
  }

 private:
  void put(std::uint32_t face) {
    place_[face] = static_cast<std::uint32_t>(result_.faces.size());
    result_.faces.push_back(face);
  }

  // By the lower of the two cells, then by the higher one.
  void put_internal() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> above;  // cell, face
    for (std::uint32_t cell = 0; cell < faces_.cell_count(); ++cell) {
      above.clear();
      const std::uint32_t first = faces_.first_face(cell);
      const std::uint32_t count = kCellShapes[static_cast<std::size_t>(faces_.kind_of_cell(cell))].face_count;
      for (std::uint32_t face = first; face < first + count; ++face)
        if (faces_.twin(face) != kNone && faces_.cell(faces_.twin(face)) > cell)
          above.emplace_back(faces_.cell(faces_.twin(face)), face);
      std::ranges::sort(above);
      for (const auto& [other, face] : above) put(face);
    }
    result_.internal_count = result_.faces.size();
  }

  void put_group(const Group& group) {
    const std::size_t begin = result_.faces.size();
    std::vector<std::uint32_t> between;
    for (const std::uint32_t element : group.elements) {
      const std::uint32_t face = faces_.find_surface(element);
      if (face == kNone) continue;
      if (place_[face] != kNone)
        between.push_back(place_[face]);
      else if (faces_.twin(face) == kNone)
        put(face);
    }
    if (result_.faces.size() > begin) result_.patches.push_back({group.name, begin, result_.faces.size() - begin});
    if (!between.empty()) result_.zones.push_back({group.name, std::move(between)});
  }

  void put_rest() {
    const std::size_t begin = result_.faces.size();
    for (std::uint32_t face = 0; face < faces_.size(); ++face)
      if (faces_.twin(face) == kNone && place_[face] == kNone) put(face);
    if (result_.faces.size() > begin) result_.patches.push_back({"no_face", begin, result_.faces.size() - begin});
  }

  const CellFaces& faces_;
  const Groups& groups_;
  std::vector<std::uint32_t> place_;  // of a face of a cell among the result's
  FoamFaces result_;
};

class FoamWriter {
 public:
  FoamWriter(const Mesh& mesh, const std::filesystem::path& folder, const CancelToken* cancel, const BlockLoop& loop)
      : mesh_(mesh),
        folder_(folder),
        cancel_(cancel),
        loop_(loop),
        cell_faces_(mesh, loop),
        groups_(make_groups(mesh)),
        faces_(FaceOrder(cell_faces_, groups_).run()) {}

  void write() {
    write_points();
    write_faces();
    write_owners();
    write_boundary();
    write_cell_zones();
    write_face_zones();
  }

 private:
  /// A file of `count` items of at most `bytes`, each printed by `print_item(out, i)`.
  template <class PrintItem>
  void write_list(const char* type, const char* name, std::size_t count, std::size_t bytes, const PrintItem& print_item,
                  const std::string& note = {}) {
    AtomicFile file(folder_ / name, cancel_);
    file.write(header(type, name, note) + std::to_string(count) + "\n(\n");
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) out = print_item(out, i);
      return out;
    };
    file.write_lines(count, bytes, print_block, loop_);
    file.write(")\n");
    file.commit();
  }

  void write_points() {
    write_list("vectorField", "points", mesh_.points.size(), 3 * kRealBytes + 4, [&](char* out, std::size_t v) {
      *out++ = '(';
      for (int axis = 0; axis < 3; ++axis) out = print(out, mesh_.points[v][axis], axis < 2 ? ' ' : ')');
      *out++ = '\n';
      return out;
    });
  }

  void write_faces() {
    write_list("faceList", "faces", faces_.faces.size(), 4 * kIntegerBytes + 4, [&](char* out, std::size_t i) {
      std::array<std::uint32_t, 4> buffer;
      const auto verts = cell_faces_.vertices(faces_.faces[i], buffer);
      out = print(out, verts.size(), '(');
      for (std::size_t k = 0; k < verts.size(); ++k) out = print(out, verts[k], k + 1 < verts.size() ? ' ' : ')');
      *out++ = '\n';
      return out;
    });
  }

  void write_owners() {
    const std::string note =
        "nPoints:" + std::to_string(mesh_.points.size()) + "  nCells:" + std::to_string(cell_faces_.cell_count()) +
        "  nFaces:" + std::to_string(faces_.faces.size()) + "  nInternalFaces:" + std::to_string(faces_.internal_count);
    const auto print_owner = [&](char* out, std::size_t i) {
      return print(out, cell_faces_.cell(faces_.faces[i]), '\n');
    };
    const auto print_neighbour = [&](char* out, std::size_t i) {
      return print(out, cell_faces_.cell(cell_faces_.twin(faces_.faces[i])), '\n');
    };
    write_list("labelList", "owner", faces_.faces.size(), kIntegerBytes, print_owner, note);
    write_list("labelList", "neighbour", faces_.internal_count, kIntegerBytes, print_neighbour, note);
  }

  void write_boundary() {
    AtomicFile file(folder_ / "boundary", cancel_);
    file.write(header("polyBoundaryMesh", "boundary") + std::to_string(faces_.patches.size()) + "\n(\n");
    for (const FoamFaces::Patch& patch : faces_.patches)
      file.write("    " + patch.name + "\n    {\n        type patch;\n        nFaces " + std::to_string(patch.count) +
                 ";\n        startFace " + std::to_string(patch.first) + ";\n    }\n");
    file.write(")\n");
    file.commit();
  }

  void begin_zone(AtomicFile& file, const std::string& name, const char* type, const char* labels, std::size_t count) {
    file.write(name + "\n{\n    type " + type + ";\n    " + labels + " List<label>\n" + std::to_string(count) +
               "\n(\n");
  }

  void write_numbers(AtomicFile& file, const std::vector<std::uint32_t>& numbers) {
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) out = print(out, numbers[i], '\n');
      return out;
    };
    file.write_lines(numbers.size(), kIntegerBytes, print_block, loop_);
  }

  void write_cell_zones() {
    AtomicFile file(folder_ / "cellZones", cancel_);
    file.write(header("regIOobject", "cellZones") + std::to_string(groups_[3].size()) + "\n(\n");
    for (const Group& group : groups_[3]) {
      begin_zone(file, group.name, "cellZone", "cellLabels", group.elements.size());
      write_numbers(file, group.elements);
      file.write(");\n}\n");
    }
    file.write(")\n");
    file.commit();
  }

  // None is flipped: the owner is the cell behind.
  void write_face_zones() {
    AtomicFile file(folder_ / "faceZones", cancel_);
    file.write(header("regIOobject", "faceZones") + std::to_string(faces_.zones.size()) + "\n(\n");
    for (const FoamFaces::Zone& zone : faces_.zones) {
      begin_zone(file, zone.name, "faceZone", "faceLabels", zone.faces.size());
      write_numbers(file, zone.faces);
      file.write(");\n    flipMap List<bool> " + std::to_string(zone.faces.size()) + "{0};\n}\n");
    }
    file.write(")\n");
    file.commit();
  }

  const Mesh& mesh_;
  const std::filesystem::path folder_;
  const CancelToken* cancel_;
  const BlockLoop& loop_;
  CellFaces cell_faces_;
  Groups groups_;
  FoamFaces faces_;
};

void make_folders(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::OutputFailed, "cannot make the folder '" + folder.string() + "': " + error.message());
}

// What checkMesh and others note of the mesh that is replaced.
constexpr std::string_view kSets = "sets/";

struct Dictionary {
  const char* name;
  const char* text;
};
/// The least that OpenFOAM's programs look for.
constexpr std::array<Dictionary, 3> kDictionaries{
    {{"controlDict",
      "application checkMesh;\nstartFrom startTime;\nstartTime 0;\nstopAt endTime;\nendTime 1;\ndeltaT 1;\n"
      "writeControl timeStep;\nwriteInterval 1;\n"},
     {"fvSchemes",
      "ddtSchemes { default steadyState; }\ngradSchemes { default Gauss linear; }\ndivSchemes { default none; }\n"
      "laplacianSchemes { default Gauss linear corrected; }\ninterpolationSchemes { default linear; }\n"
      "snGradSchemes { default corrected; }\n"},
     {"fvSolution", "solvers {}\n"}}};

// Those that are there already stay as they are.
void write_system(const std::filesystem::path& folder, const CancelToken* cancel) {
  make_folders(folder);
  for (const Dictionary& dictionary : kDictionaries) {
    if (std::filesystem::exists(folder / dictionary.name)) continue;
    AtomicFile file(folder / dictionary.name, cancel);
    file.write(std::string("FoamFile\n{\n    version 2.0;\n    format ascii;\n    class dictionary;\n    object ") +
               dictionary.name + ";\n}\n\n" + dictionary.text);
    file.commit();
  }
}

std::filesystem::path without_slash(const std::filesystem::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

bool is_foam_folder(const std::filesystem::path& path) {
  const std::filesystem::path folder = without_slash(path);
  return folder.filename() == "polyMesh" || folder.extension() == ".foam";
}

void write_foam(const Mesh& mesh, const std::filesystem::path& path, const CancelToken* cancel, const BlockLoop& loop) {
  if (cell_count(mesh) == 0) throw Error(ErrorCode::InvalidArgument, "OpenFOAM needs cells, and the mesh has none");
  const std::filesystem::path folder = without_slash(path);
  const bool is_case = folder.extension() == ".foam";
  if (is_case) {
    make_folders(folder / "constant");
    write_system(folder / "system", cancel);
  } else if (folder.has_parent_path()) {
    make_folders(folder.parent_path());
  }
  AtomicFolder made(is_case ? folder / "constant" / "polyMesh" : folder, "polyMesh",
                    [](const std::string& name) { return kFiles.contains(name) || name == kSets; });
  FoamWriter(mesh, made.temporary(), cancel, loop).write();
  made.swap_in();
}

}  // namespace tetloom::detail
