#include "tetloom/model.hpp"

#include <algorithm>
#include <cctype>
#include <numbers>
#include <TopExp_Explorer.hxx>

#include "core/cad/detail/body_fixing.hpp"
#include "core/cad/detail/cad_model.hpp"
#include "core/cad/detail/document.hpp"
#include "core/cad/detail/faults.hpp"
#include "core/cad/detail/healing.hpp"
#include "core/cad/detail/imprint.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/rebuild.hpp"
#include "core/cad/detail/validity.hpp"
#include "core/discrete/discrete_builder.hpp"

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

/// The model of a document that is complete. `valid`: whether all of its bodies are known to be.
ModelDocument make_model(cad::Document document, std::vector<HealingStep> healing, bool valid,
                         const CancelToken* cancel, const BlockLoop& loop) {
  ModelDocument result;
  result.healing = std::move(healing);
  cad::ShapeTopology parts = cad::make_topology(document.root);
  result.warnings = document.warnings;
  append(result.warnings, parts.warnings);
  if (!valid) append(result.warnings, cad::describe_faults(cad::suspect_bodies(document), parts.shapes, loop));
  append(result.warnings, cad::describe_open_shells(document.root, parts.shapes));
  if (cancel) cancel->check();
  result.model = std::make_unique<cad::CadModel>(std::move(parts), std::move(document), loop);
  add_names(*result.model, result.warnings);
  return result;
}

ModelDocument read_cad(const std::filesystem::path& path, cad::CadFormat format, const ReadOptions& options,
                       const CancelToken* cancel, const BlockLoop& loop) {
  const cad::ReadingSession session;
  cad::Document document = cad::read_document(path, format, cancel);
  return cad::translate_failures({}, ErrorCode::InputUnsuitable, "preparing the model", [&] {
    std::vector<HealingStep> healing;
    cad::fix_raw_bodies(document, cancel, loop);
    cad::complete_geometry(document, healing);
    bool valid = options.heal && cad::heal(document, healing, cancel, loop);
    if (options.imprint && cad::imprint(document, healing, cancel)) valid = false, document.valid_bodies.Clear();
    if (!TopExp_Explorer(document.root, TopAbs_FACE).More())
      throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' holds no face or solid");
    if (cancel) cancel->check();
    return make_model(std::move(document), std::move(healing), valid, cancel, loop);
  });
}

std::string cannot_rebuild(const std::filesystem::path& path, const std::vector<ModelRegionId>& solids) {
  std::string message = "of '" + path.string() + "' no solid can be made anew that is one of these:";
  for (const ModelRegionId solid : solids) message += " " + std::to_string(ModelEntity(solid).tag());
  return message;
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
  for (const std::vector<ModelRegionId>& solids : options.rebuilt) {
    std::optional<ModelDocument> again = rebuild_solids(document, solids, cancel, loop);
    if (!again) throw Error(ErrorCode::InputUnsuitable, cannot_rebuild(path, solids));
    document = std::move(*again);
  }
  return document;
}

std::optional<ModelDocument> rebuild_solids(const ModelDocument& document, const std::vector<ModelRegionId>& solids,
                                            const CancelToken* cancel, const BlockLoop& loop) {
  const auto* model = dynamic_cast<const cad::CadModel*>(document.model.get());
  if (!model) return detail::rebuild_regions(document, solids, cancel);
  if (solids.empty()) return {};
  const cad::ReadingSession session;
  return cad::translate_failures({}, ErrorCode::InputUnsuitable, "making solids anew", [&] {
    cad::Document changed = model->document();
    const std::size_t count = cad::rebuild_solids(changed, solids, cancel);
    if (count == 0) return std::optional<ModelDocument>();
    std::vector<HealingStep> healing = document.healing;
    cad::add_step(healing, "solids that crossed themselves were made anew", count);
    std::optional<ModelDocument> result = make_model(std::move(changed), std::move(healing), false, cancel, loop);
    result->format = document.format;
    return result;
  });
}

}  // namespace tetloom
