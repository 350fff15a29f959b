#include "adapt/parts/slice_curvature.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "adapt/metric/curvature_limits.hpp"
#include "adapt/parts/slice_links.hpp"

namespace tetloom::adapt {

namespace {

// A vertex on one face or edge of the model.
struct VertOnEntity {
  std::uint32_t entity = 0;
  Number number = 0;
  Vec3 point;
};

// What a face or edge asks for at one of the vertices that a rank has told of.
struct FoundLimit {
  std::uint32_t place = 0;  // among these
  VertexLimit limit;
};

class CurvatureLimiter {
 public:
  CurvatureLimiter(MeshSlice& slice, const GeometricModel& model, const CurvatureLimits& limits, const SharedWork& work)
      : slice_(slice), model_(model), limits_(limits), work_(work) {}

  void run() {
    std::vector<std::vector<std::uint32_t>> verts;
    work_.each([&] {
      require_valid(limits_);
      verts = verts_by_entity(slice_.mesh, model_.topology());
      for (auto& of_entity : verts) std::erase_if(of_entity, [&](std::uint32_t v) { return slice_.is_own[v] == 0; });
    });
    std::vector<std::int64_t> weights;
    for (const auto& of_entity : verts) weights.push_back(static_cast<std::int64_t>(of_entity.size()));
    work_.sum(weights);
    const std::vector<int> homes = work_.deal(std::vector<double>(weights.begin(), weights.end()));
    std::vector<std::vector<VertOnEntity>> told(ranks());
    for (std::uint32_t e = 0; e < verts.size(); ++e)
      for (const std::uint32_t v : verts[e])
        told[static_cast<std::size_t>(homes[e])].push_back({e, slice_.to_vert_number[v], slice_.mesh.points[v]});
    const std::vector<Bytes> heard = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r) to[r].put_array(std::span<const VertOnEntity>(told[r]));
    });
    std::vector<std::vector<FoundLimit>> found;
    work_.each([&] { found = find(heard); });
    apply_all(told, work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r) to[r].put_array(std::span<const FoundLimit>(found[r]));
    }));
    tell_around();
  }

 private:
  // Where a vertex is told of, among the messages.
  struct Told {
    std::uint32_t entity;
    Number number;
    std::uint32_t rank, place;
    auto operator<=>(const Told&) const = default;
  };

  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }

  // For each rank, in the order of its list.
  std::vector<std::vector<FoundLimit>> find(const std::vector<Bytes>& heard) const {
    std::vector<std::span<const VertOnEntity>> lists;
    std::vector<Told> all;
    for (std::uint32_t r = 0; r < heard.size(); ++r) {
      lists.push_back(MessageReader(heard[r]).get_view<VertOnEntity>());
      for (std::uint32_t i = 0; i < lists[r].size(); ++i) all.push_back({lists[r][i].entity, lists[r][i].number, r, i});
    }
    std::ranges::sort(all);
    std::vector<std::size_t> begins;  // of entities
    for (std::size_t i = 0; i < all.size(); ++i)
      if (i == 0 || all[i].entity != all[i - 1].entity) begins.push_back(i);
    begins.push_back(all.size());
    std::vector<double> sizes;
    for (std::size_t i = 0; i + 1 < begins.size(); ++i) sizes.push_back(static_cast<double>(begins[i + 1] - begins[i]));
    std::vector<std::vector<VertexLimit>> limits(sizes.size());
    work_.runner().for_each_largest_first(sizes, [&](std::size_t i) {
      limits[i] = limits_at(std::span(all).subspan(begins[i], begins[i + 1] - begins[i]), lists);
    });
    std::vector<std::vector<FoundLimit>> found(lists.size());
    for (std::size_t i = 0; i < limits.size(); ++i) answer(std::span(all).subspan(begins[i]), limits[i], found);
    for (auto& of_rank : found) std::ranges::sort(of_rank, {}, &FoundLimit::place);
    return found;
  }

  // Of one entity. `vert` of the result: among its vertices, each of them once.
  std::vector<VertexLimit> limits_at(std::span<const Told> told,
                                     const std::vector<std::span<const VertOnEntity>>& lists) const {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < told.size(); ++i)
      if (i == 0 || told[i].number != told[i - 1].number) points.push_back(lists[told[i].rank][told[i].place].point);
    std::vector<std::uint32_t> verts(points.size());
    std::iota(verts.begin(), verts.end(), 0u);
    return limits_of_entity(model_, told[0].entity, verts, points, limits_);
  }

  // To all ranks that have told of a vertex. `told`: from the first one of the entity on.
  static void answer(std::span<const Told> told, std::span<const VertexLimit> limits,
                     std::vector<std::vector<FoundLimit>>& found) {
    std::size_t i = 0;
    std::uint32_t vert = 0;
    for (const VertexLimit& limit : limits) {
      for (; vert < limit.vert; ++vert) {
        const Number number = told[i].number;
        while (told[i].number == number) ++i;
      }
      for (std::size_t k = i; k < told.size() && is_same_place(told[k], told[i]); ++k)
        found[told[k].rank].push_back({told[k].place, limit});
    }
  }
  static bool is_same_place(const Told& a, const Told& b) { return a.entity == b.entity && a.number == b.number; }

  // Faces and edges in their order.
  void apply_all(const std::vector<std::vector<VertOnEntity>>& told, const std::vector<Bytes>& answers) {
    std::vector<std::pair<std::uint32_t, VertexLimit>> all;  // by entity
    for (std::size_t r = 0; r < answers.size(); ++r)
      for (const auto& [place, limit] : MessageReader(answers[r]).get_view<FoundLimit>()) {
        const VertOnEntity& at = told[r][place];
        all.emplace_back(at.entity, limit).second.vert = vert_of(slice_, at.number);
      }
    std::ranges::stable_sort(all, {}, &std::pair<std::uint32_t, VertexLimit>::first);
    for (const auto& [entity, limit] : all) apply(slice_.metric, limit);
  }

  void tell_around() {
    const GhostLinks ghosts(slice_, VertexOwners(slice_, work_), work_);
    std::vector<std::uint32_t> all(slice_.is_own.size());
    std::iota(all.begin(), all.end(), 0u);
    ghosts.refresh(all, slice_.metric.logs);
  }

  MeshSlice& slice_;
  const GeometricModel& model_;
  const CurvatureLimits& limits_;
  const SharedWork& work_;
};

}  // namespace

void limit_by_curvature(MeshSlice& slice, const GeometricModel& model, const CurvatureLimits& limits,
                        const SharedWork& work) {
  CurvatureLimiter(slice, model, limits, work).run();
}

}  // namespace tetloom::adapt
