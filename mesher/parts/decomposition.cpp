#include "mesher/parts/decomposition.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/lists.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

// What it takes, measured over all steps, in microseconds: per size^3 of the core, per size^3 where sizes vary, and per
// size^2 of surface. A cell that meets the surface is taken to hold its own width squared of that, and half of its
// volume.
constexpr double kCoreWork = 2.8, kVaryingWork = 31, kSurfaceWork = 8.4, kInsideOfMet = 0.5;
// Small parts cost more at their boundaries than they give and have poorer tets there; large ones leave cores idle.
constexpr double kWorkPerPart = 4e5, kTetsPerPart = 2.5e5;
constexpr double kLeastOfTwo = 0.6;  // parts of the size above, from which on there are two
constexpr double kVaries = 1.1;      // ratio of the sizes in a cell from which on it is taken to vary
constexpr double kTetsPerCube = 9.5;
constexpr std::size_t kCellsPerTask = 256;

double volume_in_sizes(const lattice::LatticeCell& cell) {
  const double size = std::sqrt(cell.lo * cell.hi), width = (cell.box.hi.x - cell.box.lo.x) / size;
  return width * width * width;
}

double work_of(const lattice::LatticeCell& cell) {
  const double cubes = volume_in_sizes(cell);
  const double area = cell.meets_surface ? std::cbrt(cubes) * std::cbrt(cubes) : 0;
  const double inside = cell.meets_surface ? kInsideOfMet : 1;
  return inside * cubes * (cell.hi > kVaries * cell.lo ? kVaryingWork : kCoreWork) + area * kSurfaceWork;
}

double volume_of(const Box3& box) {
  const Vec3 extent = box.hi - box.lo;
  return extent.x * extent.y * extent.z;
}

int longest_axis(const Box3& box) {
  const Vec3 extent = box.hi - box.lo;
  return extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
}

// Where along the axis the given share of the work is reached, with each piece's spread evenly over it.
double find_cut(std::span<const std::array<double, 3>> spans, double share) {
  struct Event {
    double at, density;
  };
  std::vector<Event> events;
  double whole = 0;
  for (const auto& [lo, hi, work] : spans) {
    whole += work;
    events.push_back({lo, work / (hi - lo)});
    events.push_back({hi, -work / (hi - lo)});
  }
  std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.at < b.at; });
  double done = 0, density = 0;
  for (std::size_t i = 0; i + 1 < events.size(); ++i) {
    density += events[i].density;
    const double step = (events[i + 1].at - events[i].at) * density;
    if (done + step >= share * whole && step > 0) return events[i].at + (share * whole - done) / density;
    done += step;
  }
  return events.back().at;
}

// The same of the boxes of some pieces; nothing where all of them are flat.
template <class Piece>
std::optional<double> find_cut(std::span<const Piece> pieces, int axis, double share) {
  std::vector<std::array<double, 3>> spans;
  spans.reserve(pieces.size());
  for (const Piece& piece : pieces)
    if (piece.box.hi[axis] > piece.box.lo[axis]) spans.push_back({piece.box.lo[axis], piece.box.hi[axis], piece.work});
  if (spans.empty()) return std::nullopt;
  return find_cut(spans, share);
}

// What of the pieces lies below `at`, and what above.
template <class Piece>
std::array<std::vector<Piece>, 2> cut_at(std::span<const Piece> pieces, int axis, double at) {
  std::array<std::vector<Piece>, 2> sides;
  sides[0].reserve(static_cast<std::size_t>(
      std::ranges::count_if(pieces, [&](const Piece& piece) { return piece.box.lo[axis] < at; })));
  sides[1].reserve(static_cast<std::size_t>(
      std::ranges::count_if(pieces, [&](const Piece& piece) { return piece.box.hi[axis] > at; })));
  for (const Piece& piece : pieces) {
    for (std::size_t side = 0; side < 2; ++side) {
      Piece cut = piece;
      double& bound = side == 0 ? cut.box.hi[axis] : cut.box.lo[axis];
      bound = side == 0 ? std::min(bound, at) : std::max(bound, at);
      if (cut.box.lo[axis] >= cut.box.hi[axis]) continue;
      cut.work *= volume_of(cut.box) / volume_of(piece.box);
      sides[side].push_back(cut);
    }
  }
  return sides;
}

}  // namespace

VolumeEstimate estimate_volume(const lattice::LatticeCells& cells) {
  VolumeEstimate estimate;
  for (const lattice::LatticeCell& cell : cells.cells()) {
    estimate.tets += kTetsPerCube * volume_in_sizes(cell) * (cell.meets_surface ? kInsideOfMet : 1);
    estimate.work += work_of(cell);
  }
  return estimate;
}

std::size_t count_parts(const VolumeEstimate& volume, double tets_per_part) {
  constexpr double kMost = 1e5;
  if (tets_per_part > 0)
    return static_cast<std::size_t>(std::clamp(std::round(volume.tets / tets_per_part), 1.0, kMost));
  const double parts = std::max(volume.work / kWorkPerPart, volume.tets / kTetsPerPart);
  if (parts < kLeastOfTwo) return 1;
  // An even number, so that two cores have as much to do as one another.
  return static_cast<std::size_t>(std::clamp(2 * std::round(parts / 2), 2.0, kMost));
}

bool is_one_part(double tets, std::size_t triangles, double tets_per_part) {
  constexpr double kSafety = 2.5;  // of estimates
  if (tets_per_part > 0) return kSafety * tets < 1.5 * tets_per_part;
  const double work = kVaryingWork / kTetsPerCube * tets + kSurfaceWork * static_cast<double>(triangles);
  return kSafety * std::max(work / kWorkPerPart, tets / kTetsPerPart) < kLeastOfTwo;
}

Decomposition::Decomposition(const lattice::LatticeCells& cells, std::size_t part_count, const SharedWork& work,
                             Trace* trace) {
  std::optional<TraceSpan> span(std::in_place, trace, "boxes");
  std::vector<Piece> pieces;
  pieces.reserve(cells.cells().size());
  for (std::uint32_t i = 0; i < cells.cells().size(); ++i)
    pieces.push_back({cells.cells()[i].box, work_of(cells.cells()[i]), i});
  const Vec3 far{HUGE_VAL, HUGE_VAL, HUGE_VAL};
  nodes_.resize(2 * part_count - 1), boxes_.resize(part_count), work_.resize(part_count);
  part_to_cells_.resize(part_count);
  work.each([&] {
    const std::vector<PartId> own = work.ranks().parts_of_rank(part_count);
    bisect(std::move(pieces), {-1 * far, far}, {0, 0, static_cast<std::uint32_t>(part_count)}, own);
  });
  if (work.rank_count() > 1) share_cuts(work);
  span.emplace(trace, "neighbours", work.runner().threads(), cells.cells().size() / kCellsPerTask + 1);
  find_neighbors(cells, work);
}

// Nodes lie as they are come to, depth first, so a branch of n parts has 2 n - 1 of them. A rank cuts only what holds
// parts of its own, which are consecutive.
void Decomposition::bisect(std::vector<Piece> pieces, const Box3& box, const Branch& branch,
                           std::span<const PartId> own) {
  const auto& [index, first_part, part_count] = branch;
  if (own.empty() || own.back().value < first_part || own.front().value >= first_part + part_count) return;
  if (part_count == 1) {
    nodes_[index] = {kLeaf, 0, first_part, 0};
    boxes_[first_part] = box;
    std::vector<std::uint32_t>& cells = part_to_cells_[first_part];
    for (const Piece& piece : pieces) {
      work_[first_part] += piece.work;
      cells.push_back(piece.cell);
    }
    std::sort(cells.begin(), cells.end());
    return;
  }
  Box3 around;
  for (const Piece& piece : pieces) around.add(piece.box);
  const int axis = pieces.empty() ? 0 : longest_axis(around);
  const std::uint32_t low_count = part_count / 2;
  const double share = static_cast<double>(low_count) / static_cast<double>(part_count);
  // Where nothing is to be cut, the box still has two sides.
  const double at = std::clamp(find_cut<Piece>(pieces, axis, share).value_or(0), box.lo[axis], box.hi[axis]);
  std::array<std::vector<Piece>, 2> sides = cut_at<Piece>(pieces, axis, at);
  pieces = {};
  std::array<Box3, 2> boxes{box, box};
  boxes[0].hi[axis] = at, boxes[1].lo[axis] = at;
  nodes_[index] = {axis, at, index + 1, index + 2 * low_count};
  bisect(std::move(sides[0]), boxes[0], {nodes_[index].low, first_part, low_count}, own);
  bisect(std::move(sides[1]), boxes[1], {nodes_[index].high, first_part + low_count, part_count - low_count}, own);
}

// Of nodes, boxes and work each rank has made those that it has parts of.
void Decomposition::share_cuts(const SharedWork& work) {
  struct OfPart {
    std::uint32_t part;
    Box3 box;
    double work;
  };
  struct OfNode {
    std::uint32_t index;
    Node node;
  };
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    std::vector<OfPart> parts;
    std::vector<OfNode> nodes;
    for (const PartId part : work.ranks().parts_of_rank(part_count()))
      parts.push_back({part.value, boxes_[part.value], work_[part.value]});
    for (std::uint32_t i = 0; i < nodes_.size(); ++i)
      if (nodes_[i].axis != kNotCut) nodes.push_back({i, nodes_[i]});
    writer.put_array<OfPart>(parts);
    writer.put_array<OfNode>(nodes);
  });
  work.each([&] {
    for (const Bytes& bytes : given) {
      MessageReader reader(bytes);
      for (const OfPart& one : reader.get_view<OfPart>()) boxes_[one.part] = one.box, work_[one.part] = one.work;
      for (const OfNode& one : reader.get_view<OfNode>()) nodes_[one.index] = one.node;
    }
  });
}

std::vector<std::uint32_t> Decomposition::keep_cells_of(std::span<const PartId> parts) {
  std::vector<std::vector<std::uint32_t>> part_to_kept(part_count());
  std::vector<std::uint32_t> all;
  for (const PartId part : parts) {
    std::vector<std::uint32_t>& kept = part_to_kept[part.value];
    kept = std::move(part_to_cells_[part.value]);
    all.insert(all.end(), kept.begin(), kept.end());
  }
  sort_unique(all);
  for (std::vector<std::uint32_t>& kept : part_to_kept)
    for (std::uint32_t& cell : kept)
      cell = static_cast<std::uint32_t>(std::ranges::lower_bound(all, cell) - all.begin());
  part_to_cells_ = std::move(part_to_kept);
  return all;
}

PartId Decomposition::owner_of(const Vec3& x) const {
  std::uint32_t index = 0;
  while (nodes_[index].axis >= 0)
    index = x[nodes_[index].axis] < nodes_[index].at ? nodes_[index].low : nodes_[index].high;
  return PartId(nodes_[index].low);
}

void Decomposition::find_neighbors(const lattice::LatticeCells& cells, const SharedWork& work) {
  using Pair = std::array<PartId, 2>;
  const std::size_t count = cells.cells().size();
  const std::vector<double> blocks((count + kCellsPerTask - 1) / kCellsPerTask, 1.0);
  const auto block_to_pairs = work.make_lists<Pair>(blocks, [&](std::size_t block) {
    std::vector<Pair> pairs;
    std::vector<PartId> near;
    const std::size_t begin = block * kCellsPerTask;
    for (const lattice::LatticeCell& cell :
         std::span(cells.cells()).subspan(begin, std::min(kCellsPerTask, count - begin))) {
      const double reach = kNeighborhood * cells.coarsest_of(cell).size();
      const Vec3 margin{reach, reach, reach};
      near.clear();
      for_each_in({cell.box.lo - margin, cell.box.hi + margin}, [&](PartId part) { near.push_back(part); });
      if (near.size() < 2) continue;
      for_each_in(cell.box, [&](PartId part) {
        for (const PartId other : near)
          if (other != part) pairs.push_back({part, other}), pairs.push_back({other, part});
      });
    }
    sort_unique(pairs);
    return pairs;
  });
  part_to_neighbors_.resize(boxes_.size());
  for (const std::vector<Pair>& pairs : block_to_pairs)
    for (const auto& [part, other] : pairs) part_to_neighbors_[part.value].push_back(other);
  work.runner().for_each(boxes_.size(), [&](std::size_t part) {
    std::vector<PartId>& list = part_to_neighbors_[part];
    sort_unique(list);
  });
}

}  // namespace tetloom::parts
