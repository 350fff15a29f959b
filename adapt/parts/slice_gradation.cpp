#include "adapt/parts/slice_gradation.hpp"

#include <algorithm>
#include <utility>

#include "adapt/metric/own_verts.hpp"

namespace tetloom::adapt {

namespace {

// Vertices around a slice, each with a rank that has all of its tets.
class GhostLinks {
 public:
  GhostLinks(const MeshSlice& slice, const SharedWork& work)
      : slice_(slice), work_(work), first_at_home_(equal_ranges(slice.vert_count, ranks())) {
    const std::vector<std::uint32_t> ghosts = verts_where(0);
    find_owners(ghosts);
    ask_owners();
  }

  /// Brings values of `changed` vertices to all ranks around; returns the vertices that got one.
  std::vector<std::uint32_t> refresh(std::span<const std::uint32_t> changed, std::vector<Tensor>& logs) const {
    std::vector<std::uint8_t> has_changed(slice_.is_own.size(), 0);
    for (const std::uint32_t v : changed) has_changed[v] = 1;
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r) {
        std::vector<std::uint32_t> places;
        std::vector<Tensor> values;
        for (std::uint32_t i = 0; i < given_[r].size(); ++i)
          if (has_changed[given_[r][i]] != 0) places.push_back(i), values.push_back(logs[given_[r][i]]);
        to[r].put_array(std::span<const std::uint32_t>(places)), to[r].put_array(std::span<const Tensor>(values));
      }
    });
    std::vector<std::uint32_t> refreshed;
    for (std::size_t r = 0; r < ranks(); ++r) {
      MessageReader reader(told[r]);
      const auto places = reader.get_view<std::uint32_t>();
      const auto values = reader.get_view<Tensor>();
      for (std::size_t i = 0; i < places.size(); ++i)
        refreshed.push_back(taken_[r][places[i]]), logs[refreshed.back()] = values[i];
    }
    return refreshed;
  }

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }
  Number number_of(std::uint32_t vert) const { return slice_.to_vert_number[vert]; }

  std::vector<std::uint32_t> verts_where(std::uint8_t is_own) const {
    std::vector<std::uint32_t> verts;
    for (std::uint32_t v = 0; v < slice_.is_own.size(); ++v)
      if (slice_.is_own[v] == is_own) verts.push_back(v);
    return verts;
  }

  // Numbers of vertices for their homes.
  void put_for_homes(const std::vector<std::uint32_t>& verts, std::span<MessageWriter> to) const {
    std::vector<std::vector<Number>> numbers(ranks());
    for (const std::uint32_t v : verts) numbers[rank_in(first_at_home_, number_of(v))].push_back(number_of(v));
    for (std::size_t r = 0; r < ranks(); ++r) to[r].put_array(std::span<const Number>(numbers[r]));
  }

  // At its home every vertex has the lowest rank that has all of its tets.
  void find_owners(const std::vector<std::uint32_t>& ghosts) {
    const std::vector<Bytes> asked = work_.exchange(
        [&](std::span<MessageWriter> to) { put_for_homes(verts_where(1), to), put_for_homes(ghosts, to); });
    const auto rank = static_cast<std::size_t>(work_.rank());
    const Number first = first_at_home_[rank];
    std::vector<std::uint32_t> owners(first_at_home_[rank + 1] - first, kNone);
    std::vector<std::span<const Number>> wanted;
    for (std::uint32_t r = 0; r < ranks(); ++r) {
      MessageReader reader(asked[r]);
      for (const Number number : reader.get_view<Number>())
        owners[number - first] = std::min(owners[number - first], r);
      wanted.push_back(reader.get_view<Number>());
    }
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r)
        to[r].put_each(wanted[r], [&](Number number) { return owners[number - first]; });
    });
    // Ghosts ascend, and so do homes.
    taken_.resize(ranks());
    std::size_t next = 0;
    for (const Bytes& bytes : told)
      for (const std::uint32_t owner : MessageReader(bytes).get_view<std::uint32_t>())
        taken_[owner].push_back(ghosts[next++]);
  }

  void ask_owners() {
    const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r)
        to[r].put_each(taken_[r], [&](std::uint32_t v) { return number_of(v); });
    });
    for (const Bytes& bytes : asked) {
      std::vector<std::uint32_t>& verts = given_.emplace_back();
      for (const Number number : MessageReader(bytes).get_view<Number>())
        verts.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(slice_.to_vert_number, number) -
                                                   slice_.to_vert_number.begin()));
    }
  }

  const MeshSlice& slice_;
  const SharedWork& work_;
  std::vector<Number> first_at_home_;
  std::vector<std::vector<std::uint32_t>> taken_, given_;  // vertices that come from each rank, and go there
};

}  // namespace

void limit_gradation(MeshSlice& slice, double growth, const SharedWork& work) {
  const GhostLinks ghosts(slice, work);
  const OwnVerts own{
      &slice.is_own, slice.own_tets(work).largest,
      [&](std::span<const std::uint32_t> changed, std::vector<Tensor>& logs) { return ghosts.refresh(changed, logs); }};
  const VertexGraph graph(tets_of(slice.mesh), work.runner());
  limit_gradation(slice.metric, slice.mesh.points, graph, growth, own, work.runner());
}

}  // namespace tetloom::adapt
