#include "core/part/adjacency.hpp"

#include <algorithm>
#include <utility>

#include "core/tets/pair_faces.hpp"
#include "tetloom/error.hpp"

namespace tetloom {
namespace {

CellPlace& neighbor(PartMesh& part, CellPlace face) {
  return part.block(face.kind())
      .to_neighbor[std::size_t{face.cell()} * shape_of(face.kind()).face_count + face.place()];
}

void check_limits(const PartMesh& part) {
  for (const CellKind kind : kAllCellKinds) {
    const std::size_t limit = kind == CellKind::Tet ? CellPlace::kMaxTets : CellPlace::kMaxOthers - 1;
    if (part.block(kind).size() >= limit)
      throw Error(ErrorCode::InputUnsuitable, "a part cannot hold so many cells of one kind; use more parts");
  }
}

void match_mixed(PartMesh& part) {
  for (const CellKind kind : kAllCellKinds) {
    const std::uint32_t faces = shape_of(kind).face_count;
    for (std::uint32_t cell = 0; cell < part.block(kind).size(); ++cell) {
      for (std::uint32_t i = 0; i < faces; ++i) {
        const CellPlace face(kind, cell, i);
        const FaceKey key = key_of_face(part, face);
        tets::pair_or_chain(
            part.vert_to_place[key[0]], face, [&](CellPlace of) -> CellPlace& { return neighbor(part, of); },
            [&](CellPlace other) { return key_of_face(part, other) == key; });
      }
    }
  }
}

void match_tets(PartMesh& part) {
  CellPlace* neighbors = part.block(CellKind::Tet).to_neighbor.data();
  const auto face_at = [](std::size_t index) {
    return CellPlace(CellKind::Tet, static_cast<std::uint32_t>(index / 4), static_cast<std::uint32_t>(index % 4));
  };
  const auto index_of = [](CellPlace face) { return std::size_t{face.cell()} * 4 + face.place(); };
  tets::pair_faces(part.block(CellKind::Tet).to_vert.span(), part.vert_to_place.span(), face_at, index_of,
                   [&](CellPlace face) -> CellPlace& { return neighbors[index_of(face)]; });
}

void match_faces(PartMesh& part) {
  part.vert_to_place.clear();
  part.vert_to_place.resize(part.vertex_count());
  for (const CellKind kind : kAllCellKinds)
    part.block(kind).to_neighbor.resize_for_overwrite(part.block(kind).size() * shape_of(kind).face_count);
  const bool tets_alone = part.block(CellKind::Tet).size() == part.cell_count();
  tets_alone ? match_tets(part) : match_mixed(part);
  tets::empty_chains(part.vert_to_place.span(), [&](CellPlace face) -> CellPlace& { return neighbor(part, face); });
}

// Names the lowest corner at each vertex.
void name_corners(PartMesh& part) {
  for (const CellKind kind : kAllCellKinds) {
    const CellBlock& block = part.block(kind);
    const std::uint32_t n = shape_of(kind).vertex_count;
    for (std::uint32_t cell = 0; cell < block.size(); ++cell) {
      for (std::uint32_t i = 0; i < n; ++i) {
        CellPlace& place = part.vert_to_place[block.to_vert[std::size_t{cell} * n + i]];
        if (!place.valid()) place = CellPlace(kind, cell, i);
      }
    }
  }
}

// Collects the corners at `vert` that are connected to those already in `ball` from index `from` on.
void grow_ball(const PartMesh& part, std::uint32_t vert, std::size_t from, std::vector<CellPlace>& ball) {
  for (std::size_t k = from; k < ball.size(); ++k) {
    const CellPlace corner = ball[k];
    const CellShape& shape = shape_of(corner.kind());
    for (std::uint32_t f = 0; f < shape.face_count; ++f) {
      const auto verts = shape.face[f].vertices();
      if (std::find(verts.begin(), verts.end(), corner.place()) == verts.end()) continue;
      const CellPlace behind = neighbor_of(part, CellPlace(corner.kind(), corner.cell(), f));
      if (!behind.valid()) continue;
      const CellId cell{behind.kind(), behind.cell()};
      const auto cell_verts = vertices_of(part, cell);
      const auto place =
          static_cast<std::uint32_t>(std::find(cell_verts.begin(), cell_verts.end(), vert) - cell_verts.begin());
      const CellPlace next(cell.kind, cell.index, place);
      if (std::find(ball.begin() + static_cast<std::ptrdiff_t>(from), ball.end(), next) == ball.end())
        ball.push_back(next);
    }
  }
}

// Only vertices on open faces can have cells in several groups. Their corners are collected from all cells, and those
// that the first group does not reach get names of their own.
void name_further_corners(PartMesh& part) {
  part.further_places.clear();
  std::vector<std::uint32_t> slot(part.vertex_count(), kNone);
  std::vector<std::uint32_t> open;
  for_each_open_face(part, [&](CellPlace face) {
    for (const std::uint32_t v : vertices_of_face(part, face)) {
      if (v == kNone || slot[v] != kNone) continue;
      slot[v] = static_cast<std::uint32_t>(open.size());
      open.push_back(v);
    }
  });
  std::vector<std::uint32_t> first(open.size() + 1, 0);
  const auto for_each_open_corner = [&](const auto& visit) {
    for (const CellKind kind : kAllCellKinds) {
      const auto& to_vert = part.block(kind).to_vert;
      const std::uint32_t n = shape_of(kind).vertex_count;
      for (std::size_t i = 0; i < to_vert.size(); ++i)
        if (slot[to_vert[i]] != kNone)
          visit(slot[to_vert[i]],
                CellPlace(kind, static_cast<std::uint32_t>(i / n), static_cast<std::uint32_t>(i % n)));
    }
  };
  for_each_open_corner([&](std::uint32_t s, CellPlace) { ++first[s + 1]; });
  for (std::size_t s = 0; s < open.size(); ++s) first[s + 1] += first[s];
  std::vector<CellPlace> corners(first.back());
  std::vector<std::uint32_t> filled(first.begin(), first.end() - 1);
  for_each_open_corner([&](std::uint32_t s, CellPlace corner) { corners[filled[s]++] = corner; });

  std::vector<CellPlace> ball;
  std::vector<FurtherPlace> further;
  for (std::size_t s = 0; s < open.size(); ++s) {
    ball.assign(1, part.vert_to_place[open[s]]);
    grow_ball(part, open[s], 0, ball);
    const std::size_t count = first[s + 1] - first[s];
    for (std::uint32_t i = first[s]; ball.size() < count && i < first[s + 1]; ++i) {
      if (std::find(ball.begin(), ball.end(), corners[i]) != ball.end()) continue;
      further.push_back({open[s], corners[i]});
      const std::size_t from = ball.size();
      ball.push_back(corners[i]);
      grow_ball(part, open[s], from, ball);
    }
  }
  std::sort(further.begin(), further.end(), [](const FurtherPlace& a, const FurtherPlace& b) {
    return a.vert != b.vert ? a.vert < b.vert : a.place < b.place;
  });
  part.further_places = GrowingArray<FurtherPlace>(std::span<const FurtherPlace>(further));
}

}  // namespace

std::array<std::uint32_t, 4> vertices_of_face(const PartMesh& part, CellPlace face) {
  const CellShape& shape = shape_of(face.kind());
  const std::uint32_t* verts = part.block(face.kind()).to_vert.data() + std::size_t{face.cell()} * shape.vertex_count;
  const LocalFace& local = shape.face[face.place()];
  return {verts[local.vert[0]], verts[local.vert[1]], verts[local.vert[2]],
          local.count == 4 ? verts[local.vert[3]] : kNone};
}

FaceKey key_of_face(const PartMesh& part, CellPlace face) {
  FaceKey key = vertices_of_face(part, face);
  if (key[0] > key[1]) std::swap(key[0], key[1]);
  if (key[1] > key[2]) std::swap(key[1], key[2]);
  if (key[0] > key[1]) std::swap(key[0], key[1]);
  if (key[3] == kNone) return key;
  if (key[2] > key[3]) std::swap(key[2], key[3]);
  if (key[1] > key[2]) std::swap(key[1], key[2]);
  if (key[0] > key[1]) std::swap(key[0], key[1]);
  return key;
}

FaceKey key_of_verts(std::span<const std::uint32_t> verts) {
  FaceKey key{kNone, kNone, kNone, kNone};
  std::ranges::copy(verts, key.begin());
  std::ranges::sort(key);
  return key;
}

void disconnect_cells(PartMesh& part) {
  for (CellBlock& block : part.cells) block.to_neighbor.release();
  part.vert_to_place.release();
  part.further_places.release();
}

void connect_cells(PartMesh& part) {
  check_limits(part);
  match_faces(part);
  name_corners(part);
  name_further_corners(part);
}

std::span<const CellPlace> BallFinder::find_ball(std::uint32_t vert) {
  ball_.clear();
  if (!part_.vert_to_place[vert].valid()) return {};
  ball_.push_back(part_.vert_to_place[vert]);
  grow_ball(part_, vert, 0, ball_);
  const auto further =
      std::equal_range(part_.further_places.begin(), part_.further_places.end(), FurtherPlace{vert, {}},
                       [](const FurtherPlace& a, const FurtherPlace& b) { return a.vert < b.vert; });
  for (auto it = further.first; it != further.second; ++it) {
    const std::size_t from = ball_.size();
    ball_.push_back(it->place);
    grow_ball(part_, vert, from, ball_);
  }
  return ball_;
}

std::span<const CellId> BallFinder::find_shell(std::uint32_t a, std::uint32_t b) {
  shell_.clear();
  for (const CellPlace corner : find_ball(a)) {
    const CellId cell{corner.kind(), corner.cell()};
    const auto verts = vertices_of(part_, cell);
    for (const auto& edge : shape_of(cell.kind).edges()) {
      const std::uint32_t p = verts[edge[0]], q = verts[edge[1]];
      if ((p == a && q == b) || (p == b && q == a)) shell_.push_back(cell);
    }
  }
  std::sort(shell_.begin(), shell_.end());
  return shell_;
}

CellPlace BallFinder::find_face(std::span<const std::uint32_t> verts) {
  const FaceKey wanted = key_of_verts(verts);
  CellPlace found;
  for (const CellPlace corner : find_ball(wanted[0])) {
    for (std::uint32_t f = 0; f < shape_of(corner.kind()).face_count; ++f) {
      const CellPlace face(corner.kind(), corner.cell(), f);
      if (face < found && key_of_face(part_, face) == wanted) found = face;
    }
  }
  return found;
}

}  // namespace tetloom
