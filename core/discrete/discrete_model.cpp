#include "tetloom/model.hpp"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <new>
#include <string>

#include "core/discrete/discrete_builder.hpp"
#include "core/discrete/facet_soup.hpp"

namespace tetloom {
namespace {

enum class Format { Stl, Obj };

Format find_format(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
  if (extension == ".stl") return Format::Stl;
  if (extension == ".obj") return Format::Obj;
  throw Error(ErrorCode::InvalidArgument, "'" + path.string() + "' is neither an STL nor an OBJ file by its extension");
}

[[noreturn]] void fail_unreadable(const std::string& name, const std::string& why) {
  throw Error(ErrorCode::InputUnreadable, "'" + name + "' " + why);
}

std::string read_bytes(const std::filesystem::path& path, const CancelToken* cancel) {
  constexpr std::size_t kChunk = std::size_t{1} << 24;
  const std::string name = path.string();
  std::error_code code;
  const std::filesystem::file_status status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) fail_unreadable(name, "does not exist");
  if (std::filesystem::is_directory(status)) fail_unreadable(name, "is a directory");
  if (!std::filesystem::is_regular_file(status)) fail_unreadable(name, "is not a regular file");
  const auto close = [](std::FILE* file) { std::fclose(file); };
  const std::unique_ptr<std::FILE, decltype(close)> file(std::fopen(name.c_str(), "rb"), close);
  if (!file) fail_unreadable(name, "cannot be opened");
  std::string bytes;
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  if (!code) bytes.reserve(size + kChunk);
  while (true) {
    detail::check_cancelled(cancel);
    const std::size_t before = bytes.size();
    bytes.resize(before + kChunk);
    const std::size_t got = std::fread(bytes.data() + before, 1, kChunk, file.get());
    bytes.resize(before + got);
    if (std::ferror(file.get())) fail_unreadable(name, "cannot be read to its end");
    if (got < kChunk) break;
  }
  if (bytes.empty()) fail_unreadable(name, "is empty");
  return bytes;
}

void check_arrays(std::size_t point_count, std::span<const std::array<std::uint32_t, 3>> triangles,
                  std::size_t group_count) {
  if (group_count != 0 && group_count != triangles.size()) {
    throw Error(ErrorCode::InvalidArgument, "a discrete model needs as many groups as triangles, or none");
  }
  for (const auto& t : triangles) {
    if (std::max({t[0], t[1], t[2]}) < point_count) continue;
    throw Error(ErrorCode::InvalidArgument, "a triangle of a discrete model refers to a point that does not exist");
  }
}

}  // namespace

ModelDocument read_discrete_model(const std::filesystem::path& path, const ReadOptions& options,
                                  const CancelToken* cancel) {
  try {
    const Format format = find_format(path);
    detail::FacetSoup soup;
    {
      const std::string bytes = read_bytes(path, cancel), name = path.string();
      soup = format == Format::Stl ? detail::parse_stl(bytes, name, cancel) : detail::parse_obj(bytes, name, cancel);
    }
    ModelDocument document = detail::build_discrete_model(std::move(soup), options, cancel);
    document.format = format == Format::Stl ? "STL" : "OBJ";
    return document;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::OutOfMemory, "'" + path.string() + "' does not fit in memory");
  }
}

std::unique_ptr<GeometricModel> make_discrete_model(std::span<const Vec3> points,
                                                    std::span<const std::array<std::uint32_t, 3>> triangles,
                                                    double feature_angle, std::span<const std::uint32_t> tri_to_group) {
  check_arrays(points.size(), triangles, tri_to_group.size());
  detail::FacetSoup soup;
  soup.points.assign(points.begin(), points.end());
  soup.tri_to_vert.assign(triangles.begin(), triangles.end());
  soup.tri_to_group.assign(tri_to_group.begin(), tri_to_group.end());
  ReadOptions options;
  options.feature_angle = feature_angle;
  return detail::build_discrete_model(std::move(soup), options, nullptr).model;
}

}  // namespace tetloom
