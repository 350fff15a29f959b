#include <memory>
#include <system_error>
#include <utility>

#include "core/base/codec.hpp"
#include "core/cad/detail/stored_model.hpp"
#include "core/geometry/shape_file.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

bool store_model(const ModelDocument& document, const std::filesystem::path& path, const BlockLoop& loop) {
  const auto* model = dynamic_cast<const cad::CadModel*>(document.model.get());
  if (!model) return false;
  try {
    ShapeFileWriter file(path);
    MessageWriter skeleton;
    cad::store_shapes(*model, loop, file, skeleton);
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
  document.model = std::make_unique<cad::StoredCadModel>(file, skeleton, most_shape_bytes);
  for (auto left = skeleton.get<std::uint64_t>(); left > 0; --left) {
    std::string what = get_text(skeleton);
    document.healing.push_back({std::move(what), static_cast<std::size_t>(skeleton.get<std::uint64_t>())});
  }
  document.warnings = get_diagnostics(skeleton);
  document.format = get_text(skeleton);
  return document;
}

}  // namespace tetloom
