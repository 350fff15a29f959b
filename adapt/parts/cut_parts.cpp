#include "adapt/parts/cut_parts.hpp"

#include <algorithm>
#include <atomic>
#include <unordered_map>

#include "core/base/grain.hpp"
#include "core/tets/pair_faces.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

namespace {

using tets::TetMesh;

constexpr std::uint32_t kShared = kNone - 1;

class PartCutter {
 public:
  PartCutter(RoundShare& share, std::uint32_t first, std::uint32_t count, const TaskRunner& runner)
      : share_(share),
        mesh_(share.mesh),
        first_(first),
        runner_(runner),
        parts_(count),
        to_triangles_(count),
        shared_(count) {}

  std::vector<PartOfWhole> run() {
    sort_tets();
    sort_triangles();
    find_owners();
    runner_.for_each(parts_.size(), [&](std::size_t p) { take_corners(p), take_edges(p); });
    mesh_.to_vert.release(), share_.to_part.release();
    runner_.for_each(parts_.size(), [&](std::size_t p) { link_tets(p); });
    find_places();
    runner_.for_each(parts_.size(), [&](std::size_t p) { take_triangles(p); });
    to_place_.release();
    runner_.for_each(parts_.size(), [&](std::size_t p) { take_regions(p), take_verts(p); });
    mesh_ = WholeMesh();
    return std::move(parts_);
  }

 private:
  std::uint32_t part_of(std::uint32_t tet) const { return share_.to_part[tet] - first_; }
  bool has(std::size_t p, std::uint32_t tet) const {
    return tet != kNone && to_place_[tet] >= first_tets_[p] && to_place_[tet] < first_tets_[p + 1];
  }
  bool is_shared(std::uint32_t vert) const { return to_owner_[vert] == kShared; }
  std::span<const std::uint32_t> tets_of(std::size_t p) const {
    return std::span(tets_).subspan(first_tets_[p], first_tets_[p + 1] - first_tets_[p]);
  }

  // The tets of each part, in their order.
  void sort_tets() {
    const std::size_t count = mesh_.size(), parts = parts_.size();
    const std::size_t grain = grain_of_tables(count, kCopyGrain), blocks = (count + grain - 1) / grain;
    std::vector<std::uint32_t> places(blocks * parts, 0);  // of the next tet of each part in each block
    runner_.for_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
      std::uint32_t* of_block = &places[begin / grain * parts];
      for (std::size_t tet = begin; tet < end; ++tet) ++of_block[part_of(static_cast<std::uint32_t>(tet))];
    });
    first_tets_.assign(1, 0);
    for (std::size_t p = 0; p < parts; ++p) {
      std::uint32_t sum = 0;
      for (std::size_t block = 0; block < blocks; ++block) {
        const std::uint32_t own = std::exchange(places[block * parts + p], sum);
        sum += own;
      }
      first_tets_.push_back(first_tets_.back() + sum);
    }
    tets_.resize_for_overwrite(count);
    runner_.for_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
      std::uint32_t* of_block = &places[begin / grain * parts];
      for (std::size_t tet = begin; tet < end; ++tet) {
        const std::uint32_t p = part_of(static_cast<std::uint32_t>(tet));
        tets_[first_tets_[p] + of_block[p]++] = static_cast<std::uint32_t>(tet);
      }
    });
  }

  void find_places() {
    to_place_.resize_for_overwrite(tets_.size());
    runner_.for_blocks(tets_.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) to_place_[tets_[i]] = static_cast<std::uint32_t>(i);
    });
  }

  void sort_triangles() {
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      const auto& tets = mesh_.triangles[i].tets;
      to_triangles_[part_of(tets[0])].push_back(i);
      if (tets[1] != kNone && part_of(tets[1]) != part_of(tets[0])) to_triangles_[part_of(tets[1])].push_back(i);
    }
  }

  void find_owners() {
    to_owner_.resize(mesh_.points.size(), kNone), to_local_vert_.resize(mesh_.points.size(), 0);
    runner_.for_blocks(mesh_.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin * 4; i < end * 4; ++i) add_owner(mesh_.to_vert[i], share_.to_part[i / 4] - first_);
    });
    for (const std::uint32_t v : share_.outside.verts) to_owner_[v] = kShared;
  }

  // From tets of all parts at once.
  void add_owner(std::uint32_t vert, std::uint32_t part) {
    // Partner: the same call for other tets of the vertex. Whatever their order, two parts leave kShared.
    const std::atomic_ref<std::uint32_t> owner(to_owner_[vert]);
    std::uint32_t known = owner.load(std::memory_order_relaxed);
    if (known == kNone && owner.compare_exchange_strong(known, part, std::memory_order_relaxed)) return;
    if (known != part && known != kShared) owner.store(kShared, std::memory_order_relaxed);
  }

  // Of a vertex that is in the part.
  std::uint32_t known(std::size_t p, std::uint32_t v) const {
    return is_shared(v) ? shared_[p].at(v) : to_local_vert_[v];
  }

  std::uint32_t local_of(std::size_t p, std::uint32_t v) {
    GrowingArray<std::uint32_t>& to_whole = parts_[p].to_whole;
    const auto next = static_cast<std::uint32_t>(to_whole.size());
    if (is_shared(v)) {
      const auto [at, is_new] = shared_[p].emplace(v, next);
      if (is_new) to_whole.push_back(v);
      return at->second;
    }
    std::uint32_t& local = to_local_vert_[v];
    if (local >= next || to_whole[local] != v) {
      local = next;
      to_whole.push_back(v);
    }
    return local;
  }

  void take_corners(std::size_t p) {
    TetMesh& part = parts_[p].mesh.mesh;
    const auto tets = tets_of(p);
    part.to_vert.reserve(tets.size() * 5);
    for (const std::uint32_t tet : tets)
      for (std::size_t i = 0; i < 4; ++i) part.to_vert.push_back(local_of(p, mesh_.to_vert[std::size_t{tet} * 4 + i]));
  }

  // Those that its tets have, whether it has a triangle there or not.
  void take_edges(std::size_t p) {
    for (const std::uint32_t tet : tets_of(p))
      for_each_piece(mesh_, tet, [&](const ModelEdgePiece& piece) {
        parts_[p].mesh.surface.add_edge(known(p, piece.verts[0]), known(p, piece.verts[1]), piece.edge);
      });
  }

  // Open faces are fixed.
  void link_tets(std::size_t p) {
    TetMesh& part = parts_[p].mesh.mesh;
    const std::size_t count = tets_of(p).size();
    part.to_neighbor.reserve(count * 5), part.to_fixed.reserve(count * 5 / 4);
    part.to_neighbor.resize(count * 4), part.to_fixed.resize(count, 0);
    const auto link_of = [&](FaceCode face) -> FaceCode& { return part.behind(face); };
    GrowingArray<FaceCode> heads;
    heads.resize(parts_[p].to_whole.size());
    tets::pair_faces(
        part.to_vert.span(), heads.span(), FaceCode::at, [](FaceCode face) { return face.index(); }, link_of);
    tets::empty_chains(heads.span(), link_of);
    for (const FaceCode face : tets::FaceRange(0, count))
      if (!part.behind(face).valid()) tets::fix_side(part, face);
  }

  void take_triangles(std::size_t p) {
    CavityMesh& part = parts_[p].mesh;
    for (const std::uint32_t i : to_triangles_[p]) {
      SurfaceTriangle triangle = mesh_.triangles[i].triangle;
      for (std::uint32_t& v : triangle.verts) v = known(p, v);
      part.surface.add(triangle);
      for (const std::uint32_t tet : mesh_.triangles[i].tets) {
        if (!has(p, tet)) continue;
        const std::uint32_t local = to_place_[tet] - first_tets_[p];
        for (std::uint32_t f = 0; f < 4; ++f) {
          const std::uint32_t apex = part.verts(local)[f];
          if (std::find(triangle.verts.begin(), triangle.verts.end(), apex) == triangle.verts.end())
            part.mesh.to_fixed[local] |= static_cast<std::uint8_t>(1u << f);
        }
      }
    }
  }

  void take_regions(std::size_t p) {
    for (const std::uint32_t tet : tets_of(p)) parts_[p].mesh.mesh.to_region.push_back(mesh_.to_region[tet]);
  }

  void take_verts(std::size_t p) {
    CavityMesh& part = parts_[p].mesh;
    for (const std::uint32_t v : parts_[p].to_whole) {
      part.mesh.points.push_back(mesh_.points[v]);
      part.to_metric.push_back(mesh_.to_metric[v]);
      part.to_entity.push_back(mesh_.to_entity[v]);
      part.to_hint.push_back(mesh_.to_hint[v]);
      part.to_frozen.push_back(static_cast<std::uint8_t>(is_shared(v)));
      part.to_state.push_back(mesh_.to_state[v]);
    }
  }

  RoundShare& share_;
  WholeMesh& mesh_;
  std::uint32_t first_;
  const TaskRunner& runner_;
  std::vector<PartOfWhole> parts_;
  std::vector<std::uint32_t> first_tets_;      // of each part, in tets_
  GrowingArray<std::uint32_t> tets_;           // of one part after the other
  GrowingArray<std::uint32_t> to_place_;       // of every tet in tets_
  GrowingArray<std::uint32_t> to_owner_;       // of every vertex: the part that has it, or that several do
  GrowingArray<std::uint32_t> to_local_vert_;  // of vertices that one part has; each is written by its own part
  std::vector<std::vector<std::uint32_t>> to_triangles_;
  std::vector<std::unordered_map<std::uint32_t, std::uint32_t>> shared_;  // places in the part of what it shares
};

}  // namespace

void put_part(const PartOfWhole& part, MessageWriter& writer) {
  part.mesh.put(writer);
  writer.put_array<std::uint32_t>(part.to_whole.span());
}

PartOfWhole get_part_of_whole(MessageReader& reader) {
  PartOfWhole part;
  part.mesh = CavityMesh::get(reader);
  part.to_whole.append(reader.get_view<std::uint32_t>());
  return part;
}

std::vector<PartOfWhole> cut_parts(RoundShare& share, std::uint32_t first, std::uint32_t count,
                                   const TaskRunner& runner) {
  return PartCutter(share, first, count, runner).run();
}

}  // namespace tetloom::adapt
