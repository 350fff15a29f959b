#include "core/base/codec.hpp"

namespace tetloom {

void put_text(MessageWriter& writer, std::string_view text) { writer.put_array(std::span<const char>(text)); }

std::string get_text(MessageReader& reader) {
  const auto text = reader.get_view<char>();
  return {text.begin(), text.end()};
}

void put_entities(MessageWriter& writer, std::span<const NamedEntity> entities) {
  writer.put(static_cast<std::uint64_t>(entities.size()));
  for (const NamedEntity& named : entities) {
    writer.put(named.entity);
    put_text(writer, named.name);
  }
}

std::vector<NamedEntity> get_entities(MessageReader& reader) {
  std::vector<NamedEntity> entities;
  const auto count = reader.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto entity = reader.get<ModelEntity>();
    entities.push_back({entity, get_text(reader)});
  }
  return entities;
}

void put_diagnostic(MessageWriter& writer, const Diagnostic& diagnostic) {
  writer.put(diagnostic.code);
  put_text(writer, diagnostic.message);
  put_entities(writer, diagnostic.entities);
  writer.put(diagnostic.point.has_value());
  writer.put(diagnostic.point.value_or(Vec3{}));
  writer.put_array(std::span<const std::uint64_t>(diagnostic.elements));
}

Diagnostic get_diagnostic(MessageReader& reader) {
  Diagnostic diagnostic;
  diagnostic.code = reader.get<ErrorCode>();
  diagnostic.message = get_text(reader);
  diagnostic.entities = get_entities(reader);
  const bool has_point = reader.get<bool>();
  const Vec3 point = reader.get<Vec3>();
  if (has_point) diagnostic.point = point;
  diagnostic.elements = reader.get_array<std::uint64_t>();
  return diagnostic;
}

void put_diagnostics(MessageWriter& writer, std::span<const Diagnostic> diagnostics) {
  writer.put(static_cast<std::uint64_t>(diagnostics.size()));
  for (const Diagnostic& diagnostic : diagnostics) put_diagnostic(writer, diagnostic);
}

std::vector<Diagnostic> get_diagnostics(MessageReader& reader) {
  std::vector<Diagnostic> diagnostics;
  const auto count = reader.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) diagnostics.push_back(get_diagnostic(reader));
  return diagnostics;
}

}  // namespace tetloom
