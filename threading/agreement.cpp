#include "threading/agreement.hpp"

#include <array>
#include <new>

namespace tetloom {
namespace {

Bytes to_bytes(const Diagnostic& diagnostic) {
  MessageWriter writer;
  writer.put(diagnostic.code);
  writer.put_array(std::span<const char>(diagnostic.message.data(), diagnostic.message.size()));
  writer.put(diagnostic.point.has_value());
  writer.put(diagnostic.point.value_or(Vec3{}));
  writer.put_array(std::span<const std::uint64_t>(diagnostic.elements));
  return writer.take();
}

// Without the model entities: what fails on one rank alone are files and memory.
Diagnostic from_bytes(const Bytes& bytes) {
  MessageReader reader(bytes);
  Diagnostic diagnostic;
  diagnostic.code = reader.get<ErrorCode>();
  const auto message = reader.get_view<char>();
  diagnostic.message.assign(message.begin(), message.end());
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
