#include <memory>
#include <system_error>
#include <utility>

#include "core/base/codec.hpp"
#include "core/cad/detail/stored_cad_model.hpp"
#include "core/discrete/stored_facet_model.hpp"
#include "core/geometry/shape_file.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

namespace {

enum class StoredKind : std::uint8_t { Cad, Facets };

/// False for a kind of model that cannot be stored.
bool store_any(const GeometricModel& model, const BlockLoop& loop, ShapeFileWriter& file, MessageWriter& skeleton) {
  if (const auto* shapes = dynamic_cast<const cad::CadModel*>(&model)) {
    skeleton.put(StoredKind::Cad);
    cad::store_shapes(*shapes, loop, file, skeleton);
    return true;
  }
  skeleton.put(StoredKind::Facets);
  return detail::store_facets(model, loop, file, skeleton);
}

}  // namespace

bool store_model(const ModelDocument& document, const std::filesystem::path& path, const BlockLoop& loop) {
  try {
    ShapeFileWriter file(path);
    MessageWriter skeleton;
    if (!store_any(*document.model, loop, file, skeleton)) {
      std::filesystem::remove(path);
      return false;
    }
    skeleton.put(static_cast<std::uint64_t>(document.healing.size()));
    for (const HealingStep& step : document.healing) {
      put_text(skeleton, step.what);
      skeleton.put(static_cast<std::uint64_t>(step.count));
    }
    put_diagnostics(skeleton, document.warnings);
    put_text(skeleton, document.format);
    file.finish(skeleton.take());
  } catch (...) {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
    throw;
  }
  return true;
}

ModelDocument open_stored_model(const std::filesystem::path& path, std::uint64_t most_shape_bytes) {
  const auto file = std::make_shared<const ShapeFile>(path);
  const Bytes description = file->read_description();
  MessageReader skeleton(description);
  ModelDocument document;
  if (skeleton.get<StoredKind>() == StoredKind::Cad)
    document.model = std::make_unique<cad::StoredCadModel>(file, skeleton, most_shape_bytes);
  else
    document.model = std::make_unique<detail::StoredFacetModel>(file, skeleton, most_shape_bytes);
  for (auto left = skeleton.get<std::uint64_t>(); left > 0; --left) {
    std::string what = get_text(skeleton);
    document.healing.push_back({std::move(what), static_cast<std::size_t>(skeleton.get<std::uint64_t>())});
  }
  document.warnings = get_diagnostics(skeleton);
  document.format = get_text(skeleton);
  return document;
}

}  // namespace tetloom
