#include "core/io/solver/foam_faces.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace tetloom::detail {
namespace {

class FaceOrder {
 public:
  FaceOrder(const CellFaces& faces, std::uint32_t part, std::span<const FoamSharedFace> shared)
      : faces_(faces), part_(part), place_(faces.size(), kNone), neighbour_(shared.empty() ? 0 : faces.size(), kNone) {
    for (const FoamSharedFace& face : shared) neighbour_[faces.first_face(face.cell) + face.local] = face.part;
  }

  FoamFaces run(std::span<const Group> groups) {
    put_internal();
    for (const Group& group : groups) put_patch(group);
    put_rest();
    put_shared();
    for (const Group& group : groups) put_zone(group);
    return std::move(result_);
  }

 private:
  void put(std::uint32_t face) {
    place_[face] = static_cast<std::uint32_t>(result_.faces.size());
    result_.faces.push_back(face);
  }

  bool is_shared(std::uint32_t face) const { return !neighbour_.empty() && neighbour_[face] != kNone; }
  bool is_on_boundary(std::uint32_t face) const { return faces_.twin(face) == kNone && !is_shared(face); }

  // By the lower of the two cells, then by the higher one.
  void put_internal() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> above;  // cell, face
    for (std::uint32_t cell = 0; cell < faces_.cell_count(); ++cell) {
      above.clear();
      const std::uint32_t first = faces_.first_face(cell);
      const std::uint32_t count = kCellShapes[static_cast<std::size_t>(faces_.kind_of_cell(cell))].face_count;
      for (std::uint32_t face = first; face < first + count; ++face)
        if (faces_.twin(face) != kNone && faces_.cell(faces_.twin(face)) > cell)
          above.emplace_back(faces_.cell(faces_.twin(face)), face);
      std::ranges::sort(above);
      for (const auto& [other, face] : above) put(face);
    }
    result_.internal_count = result_.faces.size();
  }

  void put_patch(const Group& group) {
    const std::size_t begin = result_.faces.size();
    for (const std::uint32_t element : group.elements) {
      const std::uint32_t face = faces_.find_surface(element);
      if (face != kNone && place_[face] == kNone && is_on_boundary(face)) put(face);
    }
    result_.patches.push_back({begin, result_.faces.size() - begin});
  }

  void put_rest() {
    const std::size_t begin = result_.faces.size();
    for (std::uint32_t face = 0; face < faces_.size(); ++face)
      if (place_[face] == kNone && is_on_boundary(face)) put(face);
    result_.patches.push_back({begin, result_.faces.size() - begin});
  }

  void put_shared() {
    struct Shared {
      std::uint32_t part;
      std::array<std::uint32_t, 4> verts;  // ascending; kNone behind those of a triangle
      std::uint32_t face;
      auto key() const { return std::tie(part, verts); }
    };
    std::vector<Shared> all;
    std::array<std::uint32_t, 4> buffer;
    for (std::uint32_t face = 0; face < neighbour_.size(); ++face) {
      if (!is_shared(face)) continue;
      all.push_back({neighbour_[face], {kNone, kNone, kNone, kNone}, face});
      std::ranges::copy(faces_.vertices(face, buffer), all.back().verts.begin());
      std::ranges::sort(all.back().verts);
    }
    std::ranges::sort(all, {}, &Shared::key);
    for (const Shared& shared : all) {
      if (result_.neighbours.empty() || result_.neighbours.back().part != shared.part)
        result_.neighbours.push_back({shared.part, {result_.faces.size(), 0}});
      ++result_.neighbours.back().range.count;
      put(shared.face);
    }
  }

  void put_zone(const Group& group) {
    FoamFaces::Zone zone;
    for (const std::uint32_t element : group.elements) {
      const std::uint32_t face = faces_.find_surface(element);
      if (face == kNone || place_[face] == kNone || is_on_boundary(face)) continue;
      zone.faces.push_back(place_[face]);
      zone.flips.push_back(is_shared(face) && part_ > neighbour_[face]);
    }
    result_.zones.push_back(std::move(zone));
  }

  const CellFaces& faces_;
  const std::uint32_t part_;
  std::vector<std::uint32_t> place_;      // of a face of a cell among the result's
  std::vector<std::uint32_t> neighbour_;  // the part that has a face of a cell as well; empty of a whole mesh
  FoamFaces result_;
};

}  // namespace

FoamFaces order_foam_faces(const CellFaces& faces, std::span<const Group> groups, std::uint32_t part,
                           std::span<const FoamSharedFace> shared) {
  return FaceOrder(faces, part, shared).run(groups);
}

}  // namespace tetloom::detail
