#include "tetloom/model.hpp"

#include <algorithm>
#include <cctype>
#include <numbers>

#include "core/cad/detail/body_fixing.hpp"
#include "core/cad/detail/cad_model.hpp"
#include "core/cad/detail/document.hpp"
#include "core/cad/detail/faults.hpp"
#include "core/cad/detail/healing.hpp"
#include "core/cad/detail/imprint.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/rebuild.hpp"
#include "core/cad/detail/validity.hpp"

namespace tetloom {
namespace {

enum class Format { Step, Iges, Brep, Stl, Obj };

struct Extension {
  const char* text;
  Format format;
  const char* name;
};

constexpr Extension kExtensions[] = {
    {".step", Format::Step, "STEP"}, {".stp", Format::Step, "STEP"},  {".iges", Format::Iges, "IGES"},
    {".igs", Format::Iges, "IGES"},  {".brep", Format::Brep, "BREP"}, {".stl", Format::Stl, "STL"},
    {".obj", Format::Obj, "OBJ"},
};

const Extension& find_extension(const std::filesystem::path& path) {
  std::string text = path.extension().string();
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const Extension& extension : kExtensions)
    if (text == extension.text) return extension;
  throw Error(ErrorCode::InvalidArgument, "'" + path.string() + "' has the unknown extension '" + text +
                                              "'; known are .step .stp .iges .igs .brep .stl .obj");
}

void check_options(const ReadOptions& options) {
  if (!(options.feature_angle > 0 && options.feature_angle <= std::numbers::pi))
    throw Error(ErrorCode::InvalidArgument, "the feature angle must lie between 0 and pi");
}

/// What was warned of before names were known gets them.
void add_names(const GeometricModel& model, std::vector<Diagnostic>& warnings) {
  for (Diagnostic& warning : warnings)
    for (NamedEntity& entity : warning.entities) entity = model.named(entity.entity);
}

void append(std::vector<Diagnostic>& list, const std::vector<Diagnostic>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

ModelDocument read_cad(const std::filesystem::path& path, cad::CadFormat format, const ReadOptions& options,
                       const CancelToken* cancel, const BlockLoop& loop) {
  const cad::ReadingSession session;
  cad::Document document = cad::read_document(path, format, cancel);
  return cad::translate_failures({}, ErrorCode::InputUnsuitable, "preparing the model", [&] {
    ModelDocument result;
    cad::fix_raw_bodies(document, cancel, loop);
    cad::complete_geometry(document, result.healing);
    bool valid = options.heal && cad::heal(document, result.healing, cancel, loop);
    if (options.imprint && cad::imprint(document, result.healing, cancel)) valid = false, document.valid_bodies.Clear();
    if (cancel) cancel->check();
    result.rebuilt = cad::rebuild_solids(document, options.rebuild, cancel);
    cad::add_step(result.healing, "solids that crossed themselves were made anew", result.rebuilt);
    if (result.rebuilt > 0) valid = false;
    cad::ShapeTopology parts = cad::make_topology(document.root);
    if (parts.topology.face_count() == 0)
      throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' holds no face or solid");
    result.warnings = std::move(document.warnings);
    append(result.warnings, parts.warnings);
    if (!valid) append(result.warnings, cad::describe_faults(cad::suspect_bodies(document), parts.shapes, loop));
    append(result.warnings, cad::describe_open_shells(document.root, parts.shapes));
    if (cancel) cancel->check();
    result.model = std::make_unique<cad::CadModel>(std::move(parts), document, loop);
    add_names(*result.model, result.warnings);
    return result;
  });
}

}  // namespace

ModelDocument read_model(const std::filesystem::path& path, const ReadOptions& options, const CancelToken* cancel,
                         const BlockLoop& loop) {
  check_options(options);
  const Extension& extension = find_extension(path);
  if (cancel) cancel->check();
  ModelDocument document;
  switch (extension.format) {
    case Format::Step: document = read_cad(path, cad::CadFormat::Step, options, cancel, loop); break;
    case Format::Iges: document = read_cad(path, cad::CadFormat::Iges, options, cancel, loop); break;
    case Format::Brep: document = read_cad(path, cad::CadFormat::Brep, options, cancel, loop); break;
    case Format::Stl:
    case Format::Obj: document = read_discrete_model(path, options, cancel); break;
  }
  document.format = extension.name;
  return document;
}

}  // namespace tetloom
