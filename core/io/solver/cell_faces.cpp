#include "core/io/solver/cell_faces.hpp"

#include <algorithm>
#include <array>

#include "core/base/grain.hpp"
#include "core/mesh/mesh_access.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

using SortedFace = std::array<std::uint32_t, 4>;  // kNone behind the vertices of a triangle

SortedFace sorted(std::span<const std::uint32_t> verts) {
  SortedFace face{kNone, kNone, kNone, kNone};
  std::ranges::copy(verts, face.begin());
  std::ranges::sort(face);
  return face;
}

}  // namespace

CellFaces::CellFaces(const Mesh& mesh, const BlockLoop& loop, FacesOf which) : mesh_(mesh) {
  std::uint64_t faces = 0, cells = 0;
  for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
    cells += tetloom::cell_count(mesh, static_cast<CellKind>(kind));
    faces += tetloom::cell_count(mesh, static_cast<CellKind>(kind)) * kCellShapes[kind].face_count;
    if (faces >= kNone) throw Error(ErrorCode::InvalidArgument, "the mesh has too many cells for files of solvers");
    first_cell_[kind + 1] = static_cast<std::uint32_t>(cells);
    first_face_[kind + 1] = static_cast<std::uint32_t>(faces);
  }
  knows_all_ = which == FacesOf::AllCells;
  if (!knows_all_) known_ = surface_faces(loop);
  sort_by_lowest_vertex(loop);
  find_twins(loop);
}

std::vector<std::uint32_t> CellFaces::surface_faces(const BlockLoop& loop) const {
  std::vector<std::uint8_t> on_surface(mesh_.points.size(), 0);
  for_each_surface_kind(mesh_, [&](const auto& elements, const auto&) {
    for (const auto& element : elements)
      for (const std::uint32_t v : element) on_surface[v] = 1;
  });
  std::vector<std::uint32_t> found;
  for_each_cell_kind(mesh_, [&](CellKind each, const auto& cells, const auto&) {
    const auto kind = static_cast<std::size_t>(each);
    const auto lists = map_blocks(
        loop, cells.size(), kCopyGrain, std::vector<std::uint32_t>(),
        [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& list) {
          std::array<std::uint32_t, 4> buffer;
          for (std::size_t c = begin; c < end; ++c) {
            const auto marks = std::ranges::count_if(cells[c], [&](std::uint32_t v) { return on_surface[v] != 0; });
            if (marks < 3) continue;
            const auto first = static_cast<std::uint32_t>(first_face_[kind] + c * kCellShapes[kind].face_count);
            for (std::uint32_t face = first; face < first + kCellShapes[kind].face_count; ++face)
              if (std::ranges::all_of(vertices(face, buffer), [&](std::uint32_t v) { return on_surface[v] != 0; }))
                list.push_back(face);
          }
        });
    for (const auto& list : lists) found.insert(found.end(), list.begin(), list.end());
  });
  return found;
}

void CellFaces::sort_by_lowest_vertex(const BlockLoop& loop) {
  const std::size_t count = knows_all_ ? size() : known_.size();
  std::vector<std::uint32_t> lowest(count);
  loop.for_blocks(count, kCopyGrain, [&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, 4> buffer;
    for (std::size_t i = begin; i < end; ++i) lowest[i] = *std::ranges::min_element(vertices(known_face(i), buffer));
  });
  first_at_.assign(mesh_.points.size() + 2, 0);
  for (const std::uint32_t v : lowest) ++first_at_[v + 2];
  for (std::size_t v = 2; v < first_at_.size(); ++v) first_at_[v] += first_at_[v - 1];
  faces_at_.resize(count);
  for (std::size_t i = 0; i < count; ++i) faces_at_[first_at_[lowest[i] + 1]++] = known_face(i);
}

void CellFaces::find_twins(const BlockLoop& loop) {
  twin_.assign(faces_at_.size(), kNone);
  loop.for_blocks(mesh_.points.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, 4> buffer;
    std::vector<std::pair<SortedFace, std::uint32_t>> here;
    for (std::size_t v = begin; v < end; ++v) {
      here.clear();
      for (std::uint32_t i = first_at_[v]; i < first_at_[v + 1]; ++i)
        here.emplace_back(sorted(vertices(faces_at_[i], buffer)), faces_at_[i]);
      std::ranges::sort(here);
      for (std::size_t i = 1; i < here.size(); ++i) {
        std::uint32_t &one = twin_[place(here[i - 1].second)], &other = twin_[place(here[i].second)];
        if (here[i].first != here[i - 1].first || one != kNone) continue;
        other = here[i - 1].second;
        one = here[i].second;
      }
    }
  });
}

std::size_t CellFaces::place(std::uint32_t face) const {
  if (knows_all_) return face;
  const auto at = std::ranges::lower_bound(known_, face);
  return at != known_.end() && *at == face ? static_cast<std::size_t>(at - known_.begin()) : twin_.size();
}

std::uint32_t CellFaces::twin(std::uint32_t face) const {
  const std::size_t at = place(face);
  return at < twin_.size() ? twin_[at] : kNone;
}

std::size_t CellFaces::kind_of_face(std::uint32_t face) const {
  std::size_t kind = 0;
  while (face >= first_face_[kind + 1]) ++kind;
  return kind;
}

std::uint32_t CellFaces::cell(std::uint32_t face) const {
  const std::size_t kind = kind_of_face(face);
  return first_cell_[kind] + (face - first_face_[kind]) / kCellShapes[kind].face_count;
}

std::uint32_t CellFaces::local(std::uint32_t face) const {
  const std::size_t kind = kind_of_face(face);
  return (face - first_face_[kind]) % kCellShapes[kind].face_count;
}

CellKind CellFaces::kind_of_cell(std::uint32_t cell) const {
  std::size_t kind = 0;
  while (cell >= first_cell_[kind + 1]) ++kind;
  return static_cast<CellKind>(kind);
}

std::uint32_t CellFaces::first_face(std::uint32_t cell) const {
  const auto kind = static_cast<std::size_t>(kind_of_cell(cell));
  return first_face_[kind] + (cell - first_cell_[kind]) * kCellShapes[kind].face_count;
}

std::span<const std::uint32_t> CellFaces::vertices(std::uint32_t face, std::span<std::uint32_t, 4> out) const {
  const std::size_t kind = kind_of_face(face);
  const std::uint32_t in_kind = face - first_face_[kind], count = kCellShapes[kind].face_count;
  const auto verts = vertices_of(mesh_, {static_cast<CellKind>(kind), in_kind / count});
  const auto local = kCellShapes[kind].face[in_kind % count].vertices();
  std::ranges::transform(local, out.begin(), [&](std::uint8_t i) { return verts[i]; });
  return out.first(local.size());
}

std::uint32_t CellFaces::find(std::span<const std::uint32_t> verts) const {
  const SortedFace wanted = sorted(verts);
  std::array<std::uint32_t, 4> buffer;
  for (std::uint32_t i = first_at_[wanted[0]]; i < first_at_[wanted[0] + 1]; ++i)
    if (sorted(vertices(faces_at_[i], buffer)) == wanted) return faces_at_[i];
  return kNone;
}

std::uint32_t CellFaces::find_surface(std::uint32_t element) const {
  const std::size_t tris = mesh_.tri_to_vert.size();
  return element < tris ? find(mesh_.tri_to_vert[element]) : find(mesh_.quad_to_vert[element - tris]);
}

std::uint32_t CellFaces::region_of(std::uint32_t face) const {
  const std::uint32_t cell_number = cell(face);
  const auto kind = static_cast<std::size_t>(kind_of_cell(cell_number));
  std::uint32_t region = kNone;
  for_each_cell_kind(mesh_, [&](CellKind each, const auto&, const auto& regions) {
    if (static_cast<std::size_t>(each) == kind) region = regions[cell_number - first_cell_[kind]];
  });
  return region;
}

std::uint32_t CellFaces::find_side(std::uint32_t element) const {
  const std::uint32_t face = find_surface(element);
  const std::uint32_t other = face == kNone ? kNone : twin(face);
  return other != kNone && region_of(other) < region_of(face) ? other : face;
}

}  // namespace tetloom::detail
