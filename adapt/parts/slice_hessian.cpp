#include "adapt/parts/slice_hessian.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "adapt/metric/own_hessian.hpp"
#include "adapt/parts/slice_links.hpp"
#include "core/base/first_number.hpp"
#include "core/base/lists.hpp"
#include "tetloom/error.hpp"

namespace tetloom::adapt {

namespace {

// What lies at a vertex, wherever that is.
struct PlainVert {
  Number number = 0;
  Vec3 point;
  double value = 0;
};

// Some vertices and their neighbours, as their owners know them.
struct KnownVerts {
  std::vector<Number> numbers;        // ascending
  std::vector<std::uint32_t> counts;  // of neighbours
  std::vector<Number> neighbors;      // of one vertex after the other
  std::vector<PlainVert> verts;       // the neighbours, each once, ascending
};

// A slice with what lies within three edges of its own vertices.
class Surroundings {
 public:
  Surroundings(const MeshSlice& slice, std::span<const double> values, const VertexOwners& owners,
               const SharedWork& work)
      : slice_(slice), values_(values), graph_(tets_of(slice.mesh), work.runner()), owners_(owners), work_(work) {
    std::vector<Number> ghosts;
    for (std::size_t v = 0; v < slice_.is_own.size(); ++v)
      if (slice_.is_own[v] == 0) ghosts.push_back(slice_.to_vert_number[v]);
    known_[0] = ask(std::move(ghosts));
    std::vector<PlainVert> beyond = beyond_slice(known_[0].verts);
    std::vector<Number> far;
    for (const PlainVert& vert : beyond) far.push_back(vert.number);
    known_[1] = ask(std::move(far));
    far_ = beyond_slice(known_[1].verts);
    far_.insert(far_.end(), beyond.begin(), beyond.end());
    sort_far();
    number_verts();
  }

  // At own vertices of the slice; zero elsewhere.
  std::vector<Tensor> hessians() const {
    std::vector<Vec3> points(to_slice_.size());
    std::vector<double> values(to_slice_.size());
    std::size_t next_far = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool is_far = to_slice_[i] == kNone;
      points[i] = is_far ? far_[next_far].point : slice_.mesh.points[to_slice_[i]];
      values[i] = is_far ? far_[next_far].value : values_[to_slice_[i]];
      next_far += is_far;
    }
    std::vector<std::uint32_t> own, places;
    for (std::uint32_t v = 0; v < slice_.is_own.size(); ++v)
      if (slice_.is_own[v] != 0) own.push_back(v), places.push_back(from_slice_[v]);
    const std::vector<Tensor> found = recover_hessian_at(places, values, {points, {}}, graph_of_all(), work_.runner());
    std::vector<Tensor> hessians(slice_.is_own.size());
    for (std::size_t i = 0; i < own.size(); ++i) hessians[own[i]] = found[i];
    return hessians;
  }

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }

  // Neighbours of vertices that are not this rank's own.
  KnownVerts ask(std::vector<Number> numbers) const {
    const std::vector<std::uint32_t> owners = owners_.of(numbers);
    std::vector<std::vector<Number>> lists(ranks());
    for (std::size_t i = 0; i < numbers.size(); ++i) lists[owners[i]].push_back(numbers[i]);
    const std::vector<Bytes> asked = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r) to[r].put_array(std::span<const Number>(lists[r]));
    });
    const std::vector<Bytes> told = work_.exchange([&](std::span<MessageWriter> to) {
      for (std::size_t r = 0; r < ranks(); ++r) answer(MessageReader(asked[r]).get_view<Number>(), to[r]);
    });
    KnownVerts known;
    known.numbers = std::move(numbers);
    take_answers(told, owners, known);
    return known;
  }

  void answer(std::span<const Number> numbers, MessageWriter& writer) const {
    std::vector<std::uint32_t> counts, all;
    for (const Number number : numbers) {
      const auto neighbors = graph_.neighbors(vert_of(slice_, number));
      counts.push_back(static_cast<std::uint32_t>(neighbors.size()));
      all.insert(all.end(), neighbors.begin(), neighbors.end());
    }
    writer.put_array(std::span<const std::uint32_t>(counts));
    writer.put_each(std::span<const std::uint32_t>(all), [&](std::uint32_t v) { return slice_.to_vert_number[v]; });
    sort_unique(all);
    writer.put_each(std::span<const std::uint32_t>(all), [&](std::uint32_t v) {
      return PlainVert{slice_.to_vert_number[v], slice_.mesh.points[v], values_[v]};
    });
  }

  // Answers of each rank are in the order of the questions, and those ascend.
  static void take_answers(const std::vector<Bytes>& told, std::span<const std::uint32_t> owners, KnownVerts& known) {
    struct Answers {
      std::span<const std::uint32_t> counts;
      std::span<const Number> neighbors;
      std::size_t next = 0, next_neighbor = 0;
    };
    std::vector<Answers> answers;
    for (const Bytes& bytes : told) {
      MessageReader reader(bytes);
      Answers& of_rank = answers.emplace_back();
      of_rank.counts = reader.get_view<std::uint32_t>(), of_rank.neighbors = reader.get_view<Number>();
      const auto verts = reader.get_view<PlainVert>();
      known.verts.insert(known.verts.end(), verts.begin(), verts.end());
    }
    std::ranges::sort(known.verts, {}, &PlainVert::number);
    const auto same = std::ranges::unique(known.verts, {}, &PlainVert::number);
    known.verts.erase(same.begin(), same.end());
    for (const std::uint32_t owner : owners) {
      Answers& of_rank = answers[owner];
      const std::uint32_t count = of_rank.counts[of_rank.next++];
      const auto neighbors = of_rank.neighbors.subspan(of_rank.next_neighbor, count);
      of_rank.next_neighbor += count;
      known.counts.push_back(count);
      known.neighbors.insert(known.neighbors.end(), neighbors.begin(), neighbors.end());
    }
  }

  std::vector<PlainVert> beyond_slice(std::span<const PlainVert> verts) const {
    std::vector<PlainVert> beyond;
    for (const PlainVert& vert : verts)
      if (!std::ranges::binary_search(slice_.to_vert_number, vert.number)) beyond.push_back(vert);
    return beyond;
  }

  void sort_far() {
    std::ranges::sort(far_, {}, &PlainVert::number);
    const auto same = std::ranges::unique(far_, {}, &PlainVert::number);
    far_.erase(same.begin(), same.end());
  }

  // All vertices ascend, those of the slice among those far away.
  void number_verts() {
    std::size_t next_far = 0;
    for (std::uint32_t v = 0; v < slice_.to_vert_number.size(); ++v) {
      for (; next_far < far_.size() && far_[next_far].number < slice_.to_vert_number[v]; ++next_far)
        to_slice_.push_back(kNone), far_places_.push_back(static_cast<std::uint32_t>(to_slice_.size() - 1));
      from_slice_.push_back(static_cast<std::uint32_t>(to_slice_.size()));
      to_slice_.push_back(v);
    }
    for (; next_far < far_.size(); ++next_far)
      to_slice_.push_back(kNone), far_places_.push_back(static_cast<std::uint32_t>(to_slice_.size() - 1));
  }

  std::uint32_t place_of(Number number) const {
    const auto at = std::ranges::lower_bound(slice_.to_vert_number, number);
    if (at != slice_.to_vert_number.end() && *at == number) return from_slice_[at - slice_.to_vert_number.begin()];
    const auto far = std::ranges::lower_bound(far_, number, {}, &PlainVert::number);
    return far_places_[far - far_.begin()];
  }

  // Without the neighbours of those that are furthest away: nobody looks at these.
  VertexGraph graph_of_all() const {
    std::vector<std::size_t> begins{0};
    std::vector<std::uint32_t> neighbors;
    std::array<std::size_t, 2> next{}, next_neighbor{};
    for (std::size_t i = 0, far = 0; i < to_slice_.size(); ++i) {
      const std::uint32_t v = to_slice_[i];
      if (v != kNone && slice_.is_own[v] != 0) {
        for (const std::uint32_t w : graph_.neighbors(v)) neighbors.push_back(from_slice_[w]);
      } else {
        const Number number = v != kNone ? slice_.to_vert_number[v] : far_[far].number;
        for (std::size_t k = 0; k < 2; ++k) {
          const KnownVerts& known = known_[k];
          if (next[k] == known.numbers.size() || known.numbers[next[k]] != number) continue;
          for (std::uint32_t n = known.counts[next[k]++]; n > 0; --n)
            neighbors.push_back(place_of(known.neighbors[next_neighbor[k]++]));
        }
      }
      far += v == kNone;
      begins.push_back(neighbors.size());
    }
    return {std::move(begins), std::move(neighbors)};
  }

  const MeshSlice& slice_;
  const std::span<const double> values_;
  const VertexGraph graph_;
  const VertexOwners& owners_;
  const SharedWork& work_;
  std::array<KnownVerts, 2> known_;        // ghosts of the slice, and what lies beyond
  std::vector<PlainVert> far_;             // not in the slice, ascending
  std::vector<std::uint32_t> to_slice_;    // of all vertices; kNone: far away
  std::vector<std::uint32_t> from_slice_;  // of those of the slice, among all
  std::vector<std::uint32_t> far_places_;  // the same of those far away
};

void require_finite(const MeshSlice& slice, const MeshField& field) {
  for (std::size_t v = 0; v < field.values.size(); ++v) {
    if (std::isfinite(field.values[v])) continue;
    Diagnostic diagnostic;
    diagnostic.code = ErrorCode::InputUnsuitable;
    diagnostic.message =
        "the field at vertex " + std::to_string(slice.to_vert_number[v] - first_number() + 1) + " is no finite number";
    diagnostic.point = slice.mesh.points[v];
    throw Error(std::move(diagnostic));
  }
}

// Vertices of which this rank is the owner.
std::vector<std::uint8_t> counted_verts(const MeshSlice& slice, const VertexOwners& owners, const SharedWork& work) {
  const std::vector<std::uint32_t> of_all = owners.of(slice.to_vert_number);
  std::vector<std::uint8_t> counted;
  counted.reserve(of_all.size());
  for (const std::uint32_t owner : of_all) counted.push_back(owner == static_cast<std::uint32_t>(work.rank()));
  return counted;
}

double flat_of(const MeshSlice& slice, std::span<const double> values, const OwnTets& own) {
  std::array<double, 2> ends{-HUGE_VAL, -HUGE_VAL};  // - lowest, highest
  for (const double value : values) ends = {std::max(ends[0], -value), std::max(ends[1], value)};
  own.largest(ends);
  return flat_curvature(-ends[0], ends[1], diagonal_of(slice.mesh.points, own));
}

}  // namespace

HessianMetric metric_from_solution(const MeshSlice& slice, const std::string& name, const HessianOptions& options,
                                   const SharedWork& work) {
  const MeshField& field = *std::ranges::find(slice.mesh.point_fields, name, &MeshField::name);
  work.each([&] { require_finite(slice, field); });
  const VertexOwners owners(slice, work);
  const GhostLinks ghosts(slice, owners, work);
  std::vector<Tensor> hessians;
  {
    const Surroundings surroundings(slice, field.values, owners, work);
    work.each([&] { hessians = surroundings.hessians(); });
  }
  std::vector<std::uint32_t> all(hessians.size());
  std::iota(all.begin(), all.end(), 0u);
  ghosts.refresh(all, hessians);
  const std::vector<std::uint8_t> counted = counted_verts(slice, owners, work);
  const OwnMesh own{slice.own_tets(work), ghosts.own_verts(), &counted};
  const double flat = flat_of(slice, field.values, own.tets);
  const VertexGraph graph(tets_of(slice.mesh), work.runner());
  HessianMetric result = metric_from_hessian(hessians, flat, tets_of(slice.mesh), graph, options, own, work.runner());
  ghosts.refresh(all, result.metric.logs);
  return result;
}

}  // namespace tetloom::adapt
