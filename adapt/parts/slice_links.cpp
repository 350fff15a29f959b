#include "adapt/parts/slice_links.hpp"

#include <algorithm>

namespace tetloom::adapt {

namespace {

// Of the slice: those whose tets are all here, or the others.
std::vector<std::uint32_t> verts_where(const MeshSlice& slice, std::uint8_t is_own) {
  std::vector<std::uint32_t> verts;
  for (std::uint32_t v = 0; v < slice.is_own.size(); ++v)
    if (slice.is_own[v] == is_own) verts.push_back(v);
  return verts;
}

std::vector<Number> numbers_of(const MeshSlice& slice, std::span<const std::uint32_t> verts) {
  std::vector<Number> numbers;
  numbers.reserve(verts.size());
  for (const std::uint32_t v : verts) numbers.push_back(slice.to_vert_number[v]);
  return numbers;
}

}  // namespace

VertexOwners::VertexOwners(const MeshSlice& slice, const SharedWork& work)
    : work_(work), first_at_home_(equal_ranges(slice.vert_count, ranks())) {
  const std::vector<Number> own = numbers_of(slice, verts_where(slice, 1));
  const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) { put_for_homes(own, to); });
  const auto rank = static_cast<std::size_t>(work_.rank());
  at_home_.assign(first_at_home_[rank + 1] - first_at_home_[rank], kNone);
  for (std::uint32_t r = 0; r < ranks(); ++r)
    for (const Number number : MessageReader(told[r]).get_view<Number>()) {
      std::uint32_t& owner = at_home_[number - first_at_home_[rank]];
      owner = std::min(owner, r);
    }
}

void VertexOwners::put_for_homes(std::span<const Number> numbers, std::span<MessageWriter> to) const {
  std::vector<std::vector<Number>> lists(ranks());
  for (const Number number : numbers) lists[rank_in(first_at_home_, number)].push_back(number);
  for (std::size_t r = 0; r < ranks(); ++r) to[r].put_array(std::span<const Number>(lists[r]));
}

// Numbers ascend, and so do homes.
std::vector<std::uint32_t> VertexOwners::of(std::span<const Number> numbers) const {
  const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) { put_for_homes(numbers, to); });
  const Number first = first_at_home_[static_cast<std::size_t>(work_.rank())];
  const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < ranks(); ++r)
      to[r].put_each(MessageReader(asked[r]).get_view<Number>(),
                     [&](Number number) { return at_home_[number - first]; });
  });
  std::vector<std::uint32_t> owners;
  owners.reserve(numbers.size());
  for (const Bytes& bytes : told)
    for (const std::uint32_t owner : MessageReader(bytes).get_view<std::uint32_t>()) owners.push_back(owner);
  return owners;
}

GhostLinks::GhostLinks(const MeshSlice& slice, const VertexOwners& owners, const SharedWork& work)
    : slice_(slice), work_(work), taken_(static_cast<std::size_t>(work.rank_count())) {
  const std::vector<std::uint32_t> ghosts = verts_where(slice_, 0);
  const std::vector<std::uint32_t> of_ghosts = owners.of(numbers_of(slice_, ghosts));
  for (std::size_t i = 0; i < ghosts.size(); ++i) taken_[of_ghosts[i]].push_back(ghosts[i]);
  const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < to.size(); ++r)
      to[r].put_each(taken_[r], [&](std::uint32_t v) { return slice_.to_vert_number[v]; });
  });
  for (const Bytes& bytes : asked) {
    std::vector<std::uint32_t>& verts = given_.emplace_back();
    for (const Number number : MessageReader(bytes).get_view<Number>()) verts.push_back(vert_of(slice_, number));
  }
}

std::vector<std::uint32_t> GhostLinks::refresh(std::span<const std::uint32_t> changed,
                                               std::vector<Tensor>& logs) const {
  std::vector<std::uint8_t> has_changed(slice_.is_own.size(), 0);
  for (const std::uint32_t v : changed) has_changed[v] = 1;
  const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
    for (std::size_t r = 0; r < to.size(); ++r) {
      std::vector<std::uint32_t> places;
      std::vector<Tensor> values;
      for (std::uint32_t i = 0; i < given_[r].size(); ++i)
        if (has_changed[given_[r][i]] != 0) places.push_back(i), values.push_back(logs[given_[r][i]]);
      to[r].put_array(std::span<const std::uint32_t>(places)), to[r].put_array(std::span<const Tensor>(values));
    }
  });
  std::vector<std::uint32_t> refreshed;
  for (std::size_t r = 0; r < told.size(); ++r) {
    MessageReader reader(told[r]);
    const auto places = reader.get_view<std::uint32_t>();
    const auto values = reader.get_view<Tensor>();
    for (std::size_t i = 0; i < places.size(); ++i)
      refreshed.push_back(taken_[r][places[i]]), logs[refreshed.back()] = values[i];
  }
  return refreshed;
}

OwnVerts GhostLinks::own_verts() const {
  return {&slice_.is_own, slice_.own_tets(work_).largest,
          [this](std::span<const std::uint32_t> changed, std::vector<Tensor>& logs) { return refresh(changed, logs); }};
}

}  // namespace tetloom::adapt
