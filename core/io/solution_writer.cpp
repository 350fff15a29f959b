#include <algorithm>
#include <charconv>
#include <cstring>
#include <span>

#include "core/io/atomic_file.hpp"
#include "core/io/medit_detail.hpp"
#include "tetloom/io.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kRealBytes = 25;  // at most, with the character behind

/// The fields of one carrier as they are written.
struct SolutionBlock {
  const char* keyword;
  std::int32_t code;
  std::span<const MeshField> fields;
  std::size_t count;

  std::size_t reals() const {
    std::size_t sum = 0;
    for (const MeshField& field : fields) sum += static_cast<std::size_t>(field.components);
    return sum;
  }
  /// Calls visit(value) for the values of item i.
  template <class Visit>
  void for_values(std::size_t i, const Visit& visit) const {
    for (const MeshField& field : fields) {
      const auto n = static_cast<std::size_t>(field.components);
      for (std::size_t c = 0; c < n; ++c) visit(field.values[i * n + c]);
    }
  }
};

std::int32_t kind_of(const MeshField& field) {
  switch (field.components) {
    case 1: return 1;
    case 3: return 2;
    case 6: return 3;
    case 9: return 4;
    default:
      throw Error(ErrorCode::InvalidArgument, "the field '" + field.name + "' has " + std::to_string(field.components) +
                                                  " components; files of solutions hold 1, 3, 6 or 9");
  }
}

void require_values(const SolutionBlock& block) {
  for (const MeshField& field : block.fields) {
    static_cast<void>(kind_of(field));
    if (field.values.size() != block.count * static_cast<std::size_t>(field.components))
      throw Error(ErrorCode::InvalidArgument,
                  "the field '" + field.name + "' has " + std::to_string(field.values.size()) + " values instead of " +
                      std::to_string(field.components) + " for each of " + std::to_string(block.count));
  }
}

void print_block(AtomicFile& file, const SolutionBlock& block, const BlockLoop& loop) {
  file.write(block.keyword);
  file.print(block.count), file.print('\n');
  file.print(block.fields.size());
  for (const MeshField& field : block.fields) file.print(' '), file.print(kind_of(field));
  file.print('\n');
  const auto print = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i) {
      block.for_values(i, [&](double value) {
        out = std::to_chars(out, out + kRealBytes - 1, value).ptr;
        *out++ = ' ';
      });
      out[-1] = '\n';
    }
    return out;
  };
  file.write_lines(block.count, block.reals() * kRealBytes, print, loop);
}

std::size_t header_bytes(const SolutionBlock& block, int version) {
  const std::size_t position = version == 2 ? 4 : 8, integer = version == 4 ? 8 : 4;
  return 4 + position + integer + 4 + 4 * block.fields.size();
}

void put_position(AtomicFile& file, std::uint64_t position, int version) {
  if (version == 2)
    file.put(static_cast<std::uint32_t>(position));
  else
    file.put(position);
}

void put_block(AtomicFile& file, const SolutionBlock& block, int version, const BlockLoop& loop) {
  const std::size_t record = block.reals() * sizeof(double);
  const std::uint64_t next = file.position() + header_bytes(block, version) + block.count * record;
  file.put(block.code);
  put_position(file, next, version);
  if (version == 4)
    file.put(std::uint64_t{block.count});
  else
    file.put(static_cast<std::uint32_t>(block.count));
  file.put(static_cast<std::int32_t>(block.fields.size()));
  for (const MeshField& field : block.fields) file.put(kind_of(field));
  const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i)
      block.for_values(i, [&](double value) {
        std::memcpy(out, &value, sizeof(double));
        out += sizeof(double);
      });
  };
  file.write_records(block.count, record, encode, loop);
}

void write_text(AtomicFile& file, std::span<const SolutionBlock> blocks, const BlockLoop& loop) {
  file.write("MeshVersionFormatted 2\nDimension 3\n");
  for (const SolutionBlock& block : blocks) print_block(file, block, loop);
  file.write("End\n");
}

void write_binary(AtomicFile& file, std::span<const SolutionBlock> blocks, const BlockLoop& loop) {
  std::uint64_t bytes = 1000, largest = 0;
  for (const SolutionBlock& block : blocks) {
    bytes += header_bytes(block, 4) + block.count * block.reals() * sizeof(double);
    largest = std::max<std::uint64_t>(largest, block.count);
  }
  const int version = detail::medit_version(bytes, largest);
  file.put(std::int32_t{1});
  file.put(std::int32_t{version});
  file.put(detail::kMeditDimension);
  put_position(file, file.position() + (version == 2 ? 4 : 8) + 4, version);
  file.put(std::int32_t{3});
  for (const SolutionBlock& block : blocks) put_block(file, block, version, loop);
  file.put(detail::kMeditEnd);
  put_position(file, 0, version);
}

}  // namespace

void write_solution(const Solution& solution, const SolutionSize& size, const std::filesystem::path& path,
                    const CancelToken* cancel, const BlockLoop& loop) {
  const bool binary = detail::is_binary_solution(path);
  std::vector<SolutionBlock> blocks;
  if (!solution.point_fields.empty())
    blocks.push_back({"SolAtVertices\n", detail::kSolAtVertices, solution.point_fields, size.points});
  if (!solution.tet_fields.empty())
    blocks.push_back({"SolAtTetrahedra\n", detail::kSolAtTetrahedra, solution.tet_fields, size.tets});
  if (blocks.empty())
    throw Error(ErrorCode::InvalidArgument, "there is no solution to write to '" + path.string() + "'");
  for (const SolutionBlock& block : blocks) require_values(block);
  AtomicFile file(path, cancel);
  if (binary)
    write_binary(file, blocks, loop);
  else
    write_text(file, blocks, loop);
  file.commit();
}

}  // namespace tetloom
