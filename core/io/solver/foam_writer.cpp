#include "core/io/solver/foam_writer.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <system_error>
#include <vector>

#include "core/io/atomic_file.hpp"
#include "core/io/atomic_folder.hpp"
#include "core/io/solver/foam_mesh.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

void make_folders(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(ErrorCode::OutputFailed, "cannot make the folder '" + folder.string() + "': " + error.message());
}

struct Dictionary {
  const char* name;
  std::string text;
};
/// The least that OpenFOAM's programs look for.
const std::vector<Dictionary> kDictionaries{
    {"controlDict",
     "application checkMesh;\nstartFrom startTime;\nstartTime 0;\nstopAt endTime;\nendTime 1;\ndeltaT 1;\n"
     "writeControl timeStep;\nwriteInterval 1;\nwritePrecision 16;\n"},
    {"fvSchemes",
     "ddtSchemes { default steadyState; }\ngradSchemes { default Gauss linear; }\ndivSchemes { default none; }\n"
     "laplacianSchemes { default Gauss linear corrected; }\ninterpolationSchemes { default linear; }\n"
     "snGradSchemes { default corrected; }\n"},
    {"fvSolution", "solvers {}\n"}};

void write_dictionary(const std::filesystem::path& folder, const Dictionary& dictionary, const CancelToken* cancel) {
  AtomicFile file(folder / dictionary.name, cancel);
  file.write(std::string("FoamFile\n{\n    version 2.0;\n    format ascii;\n    class dictionary;\n    object ") +
             dictionary.name + ";\n}\n\n" + dictionary.text);
  file.commit();
}

// Those that are there already stay as they are.
void write_system(const std::filesystem::path& folder, const CancelToken* cancel) {
  make_folders(folder);
  for (const Dictionary& dictionary : kDictionaries)
    if (!std::filesystem::exists(folder / dictionary.name)) write_dictionary(folder, dictionary, cancel);
}

std::string processor_name(std::size_t part) { return "processor" + std::to_string(part); }

// OpenFOAM counts the folders of processors.
void refuse_more_parts(const std::filesystem::path& folder, std::size_t part_count) {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string(),
                      number = name.substr(std::min<std::size_t>(9, name.size()));
    const bool is_processor = name.starts_with("processor") && !number.empty() && number.size() < 9 &&
                              std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c) != 0; });
    if (is_processor && std::stoul(number) >= part_count)
      throw Error(ErrorCode::OutputFailed, "the case '" + folder.string() + "' has the folder '" + name +
                                               "' of a mesh in more parts; it has to be removed first");
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

bool is_foam_case(const std::filesystem::path& path) { return without_slash(path).extension() == ".foam"; }

void write_foam(const Mesh& mesh, const std::filesystem::path& path, const CancelToken* cancel, const BlockLoop& loop) {
  if (cell_count(mesh) == 0) throw Error(ErrorCode::InvalidArgument, "OpenFOAM needs cells, and the mesh has none");
  const std::filesystem::path folder = without_slash(path);
  const bool is_case = is_foam_case(path);
  if (is_case) {
    make_folders(folder / "constant");
    write_system(folder / "system", cancel);
  } else if (folder.has_parent_path()) {
    make_folders(folder.parent_path());
  }
  AtomicFolder made(is_case ? folder / "constant" / "polyMesh" : folder, "polyMesh", FoamMesh::is_file_name);
  const FoamMesh foam(mesh, name_groups(mesh.entities, tags_with_elements(mesh)), {}, loop);
  foam.write(made.temporary(), foam.counts(), cancel);
  made.swap_in();
}

std::filesystem::path foam_part_folder(const std::filesystem::path& path, std::size_t part) {
  return without_slash(path) / processor_name(part) / "constant" / "polyMesh";
}

void prepare_foam_parts(const std::filesystem::path& path, std::size_t part_count, const CancelToken* cancel) {
  const std::filesystem::path folder = without_slash(path);
  refuse_more_parts(folder, part_count);
  for (std::size_t part = 0; part < part_count; ++part) make_folders(foam_part_folder(path, part).parent_path());
  write_system(folder / "system", cancel);
  write_dictionary(folder / "system",
                   {"decomposeParDict", "numberOfSubdomains " + std::to_string(part_count) + ";\nmethod scotch;\n"},
                   cancel);
}

}  // namespace tetloom::detail
