#include "core/base/lists.hpp"
#include "core/io/mid_node_reader_detail.hpp"

namespace tetloom::detail {
namespace {

// The new number of each point: vertices first, then mid nodes, both in their order. `mids` are those, in the new one.
std::vector<std::uint32_t> renumber(std::size_t points, std::span<const std::uint32_t> mids) {
  constexpr std::uint32_t kVertex = 0;
  std::vector<std::uint32_t> number(points, kVertex);
  const std::size_t vertices = points - mids.size();
  for (std::size_t i = 0; i < mids.size(); ++i) number[mids[i]] = static_cast<std::uint32_t>(vertices + i);
  std::uint32_t next = 0;
  for (std::uint32_t& of_point : number)
    if (of_point == kVertex) of_point = next++;
  return number;
}

template <class Item>
void permute(std::vector<Item>& items, std::span<const std::uint32_t> number, std::size_t components) {
  std::vector<Item> old = items;
  for (std::size_t i = 0; i < number.size(); ++i)
    for (std::size_t c = 0; c < components; ++c) items[number[i] * components + c] = old[i * components + c];
}

void permute_points(Mesh& mesh, std::span<const std::uint32_t> number) {
  permute(mesh.points, number, 1);
  if (!mesh.point_to_entity.empty()) permute(mesh.point_to_entity, number, 1);
  for (MeshField& field : mesh.point_fields) permute(field.values, number, static_cast<std::size_t>(field.components));
  for_each_block(mesh, [&](Block, auto& elements, const auto&) {
    for (auto& element : elements)
      for (std::uint32_t& v : element) v = number[v];
  });
}

}  // namespace

void MidNodeReader::check(const InputFile& file, const Mesh& mesh) const {
  enum class Role : std::uint8_t { Free, Vertex, Mid };
  std::vector<Role> role(mesh.points.size(), Role::Free);
  for_each_block(mesh, [&](Block, const auto& elements, const auto&) {
    for (const auto& element : elements)
      for (const std::uint32_t v : element) role[v] = Role::Vertex;
  });
  for (std::size_t i = 0; i < found_.size(); ++i) {
    const auto& [low, high, mid] = found_[i];
    if (mid >= role.size()) file.fail(ErrorCode::InputUnreadable, "an element has a mid node that is not there");
    const std::string node = "node " + std::to_string(mid + std::uint64_t{1});
    if (role[mid] == Role::Vertex) file.fail(ErrorCode::InputUnreadable, node + " is a vertex and a mid node");
    if (role[mid] == Role::Mid) file.fail(ErrorCode::InputUnreadable, node + " is the mid node of two edges");
    role[mid] = Role::Mid;
    if (i > 0 && found_[i - 1].low == low && found_[i - 1].high == high)
      file.fail(ErrorCode::InputUnsuitable, node + " is the second mid node of one edge");
  }
}

void MidNodeReader::finish(const InputFile& file, Mesh& mesh, bool classify) {
  if (found_.empty()) return;
  sort_unique(found_);
  check(file, mesh);
  std::vector<std::uint32_t> mids;
  for (const Found& found : found_) mids.push_back(found.mid);
  const std::vector<std::uint32_t> number = renumber(mesh.points.size(), mids);
  permute_points(mesh, number);
  for (const Found& found : found_) mesh.mid_to_vert.push_back({number[found.low], number[found.high]});
  if (find_mid_node_fault(mesh))
    file.fail(ErrorCode::InputUnsuitable, "the file has elements of first and second order");
  if (classify) classify_mid_nodes(mesh);
}

}  // namespace tetloom::detail
