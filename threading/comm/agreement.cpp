#include "threading/comm/agreement.hpp"

#include <array>
#include <new>

namespace tetloom {
namespace {

void put_text(MessageWriter& writer, const std::string& text) {
  writer.put_array(std::span<const char>(text.data(), text.size()));
}

std::string get_text(MessageReader& reader) {
  const auto text = reader.get_view<char>();
  return {text.begin(), text.end()};
}

Bytes to_bytes(const Diagnostic& diagnostic) {
  MessageWriter writer;
  writer.put(diagnostic.code);
  put_text(writer, diagnostic.message);
  writer.put(static_cast<std::uint64_t>(diagnostic.entities.size()));
  for (const NamedEntity& named : diagnostic.entities) {
    writer.put(named.entity);
    put_text(writer, named.name);
  }
  writer.put(diagnostic.point.has_value());
  writer.put(diagnostic.point.value_or(Vec3{}));
  writer.put_array(std::span<const std::uint64_t>(diagnostic.elements));
  return writer.take();
}

Diagnostic from_bytes(const Bytes& bytes) {
  MessageReader reader(bytes);
  Diagnostic diagnostic;
  diagnostic.code = reader.get<ErrorCode>();
  diagnostic.message = get_text(reader);
  diagnostic.entities.resize(reader.get<std::uint64_t>());
  for (NamedEntity& named : diagnostic.entities) {
    named.entity = reader.get<ModelEntity>();
    named.name = get_text(reader);
  }
  const bool has_point = reader.get<bool>();
  const Vec3 point = reader.get<Vec3>();
  if (has_point) diagnostic.point = point;
  diagnostic.elements = reader.get_array<std::uint64_t>();
  return diagnostic;
}

}  // namespace

void agree(Communicator& communicator, const std::optional<Diagnostic>& failure) {
  std::array<std::int64_t, 1> failures{failure ? 1 : 0};
  communicator.sum(failures);
  if (failures[0] == 0) return;
  if (communicator.rank_count() == 1) throw Error(*failure);
  for (const Bytes& bytes : communicator.all_gather(failure ? to_bytes(*failure) : Bytes{}))
    if (!bytes.empty()) throw Error(from_bytes(bytes));
}

std::optional<Diagnostic> failure_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.diagnostic();
  } catch (const std::bad_alloc&) {
    return Diagnostic{ErrorCode::OutOfMemory, "the memory is exhausted", {}, {}, {}};
  } catch (const std::exception& error) {
    return Diagnostic{ErrorCode::Internal, std::string("unexpected error: ") + error.what(), {}, {}, {}};
  }
  return std::nullopt;
}

void run_on_all(Communicator& communicator, const std::function<void()>& work) {
  agree(communicator, failure_of(work));
}

void run_on_first(Communicator& communicator, const std::function<void()>& work) {
  agree(communicator, communicator.rank() == 0 ? failure_of(work) : std::nullopt);
}

std::uint64_t share_number(Communicator& communicator, std::uint64_t value) {
  std::array<std::int64_t, 1> number{communicator.rank() == 0 ? static_cast<std::int64_t>(value) : 0};
  communicator.sum(number);
  return static_cast<std::uint64_t>(number[0]);
}

}  // namespace tetloom
