#include "adapt/adapter.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "adapt/metric/tet_edges.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/grain.hpp"
#include "core/base/stopwatch.hpp"
#include "core/geometry/model_projector.hpp"

namespace tetloom::adapt {

namespace {

// How a mesh is dealt.
struct DealingSettings {
  double per_part = 1e5;            // tets of a part, where there are many parts
  double tets_per_complexity = 10;  // that a regular mesh has, about
  double work_of_tet = 0.7;         // beside what it will become
  // Where a metric turns from neighbour to neighbour, edges are long however many there are: no more than so many times
  // the tets that it asks for, but always the least.
  double overfull = 6, least_full = 1000;
};
constexpr DealingSettings kDealing;

// When the rounds end.
struct EndSettings {
  std::size_t most_stages = 40;   // each of which halves sizes: more than numbers have room for
  std::size_t most_rounds = 12;   // at the metric itself
  std::size_t most_snapping = 8;  // rounds for vertices beside the model
  double worth_a_round = 0.002;   // gain in the share of unit edges
  double enough = 0.985;          // of that share
  double nearly_all = 0.9998;     // share of edges of lengths in [1/2, 2]
  double fair = 0.008;            // cubed mean ratio: all tets should have at least that
  double fair_gain = 1.2;         // of the worst
};
constexpr EndSettings kEnd;

// What a pass changes, in metric lengths and mean ratios.
struct PassSettings {
  double movable = 0.92;                // vertices of tets below move
  double collapsed = 0.73;              // a little above the shortest: what is collapsed and split does not alternate
  double longest = 1.4142135623730951;  // of a unit edge
  double longest_of_stage = 1.6;        // on the way, where the next stage splits it again
};
constexpr PassSettings kPasses;

// Equal parts keep 2 threads, or 4, busy where they are as many or a multiple. Few of them: every round leaves
// something to do at their sides.
double part_count_for(double tets) {
  constexpr double kForTwo = 2e4, kForFour = 1.6e5, kForEight = 6e5, kForMore = 1.6e6;
  if (tets < kForEight) return tets < kForTwo ? 1 : tets < kForFour ? 2 : 4;
  return tets < kForMore ? 8 : 4 * std::round(tets / kDealing.per_part / 4);
}

void follow(Passes& passes) {
  passes.split_edges(2), passes.swap(0.6);
  passes.split_edges(kPasses.longest_of_stage), passes.collapse_edges(0.7, 1.45), passes.swap(0.6), passes.smooth(0.85);
}

void finish(Passes& passes) {
  passes.collapse_edges(kPasses.collapsed, kPasses.longest), passes.swap(0.8), passes.smooth(kPasses.movable);
}

void refine_and_finish(Passes& passes) { passes.split_edges(kPasses.longest), finish(passes); }

// The first time at the metric itself, and the second in the same round: most of what is left then lies between parts.
void refine(Passes& passes) {
  passes.split_edges(kPasses.longest), passes.collapse_edges(0.65, kPasses.longest), passes.swap(0.7),
      passes.smooth(kPasses.movable);
  refine_and_finish(passes);
}

// The last rounds: where vertices have moved, other swaps pay.
void polish(Passes& passes) { finish(passes), passes.swap(0.8), passes.smooth(kPasses.movable); }

// Those of the vertices `kept`, of `count`; all where it is empty.
void keep_values(std::vector<double>& values, const std::vector<std::uint32_t>& kept, std::size_t count) {
  if (kept.empty() || values.empty()) return;
  const std::size_t size = values.size() / count;
  for (std::size_t v = 0; v < kept.size(); ++v) std::copy_n(&values[kept[v] * size], size, &values[v * size]);
  values.resize(kept.size() * size);
}

}  // namespace

bool Adapter::Fit::is_good() const {
  return unit > kEnd.enough && half_to_two > kEnd.nearly_all && least_quality > kEnd.fair;
}

bool Adapter::Fit::is_better_than(const Fit& other) const {
  return unit > other.unit + kEnd.worth_a_round || half_to_two > other.half_to_two ||
         (least_quality > kEnd.fair_gain * other.least_quality && other.least_quality < kEnd.fair);
}

void Adapter::run(AdaptReport& report) {
  runner_.begin_stage(Stage::Adapt, 0);
  follow_stages();
  approach_metric();
  snap_to_model();
  Stopwatch watch;
  carry_fields(report);
  seconds_.result = watch.lap();
  note_rounds(report);
}

void Adapter::follow_stages() {
  double ratio = kFirstRatio;
  for (std::size_t stage = 0; stage < kEnd.most_stages; ++stage, ratio *= 2) {
    if ((stage == 0 ? first_stage_.refinement : refinement()) <= ratio) break;
    round(ratio, {follow, kPasses.longest_of_stage});
  }
}

void Adapter::approach_metric() {
  implied_ = {};  // which only stages ask for
  if (tiles_) work_.each([&] { tiles_->drop_implied(), give_back_free_memory(); });
  round(HUGE_VAL, {refine, kPasses.longest});
  Fit best;
  for (std::size_t i = 0, idle = 0; i < kEnd.most_rounds && idle < 2; ++i) {
    const Fit fit = measure();
    if (fit.is_good()) break;
    idle = fit.is_better_than(best) ? 0 : idle + 1;
    best = {std::max(best.unit, fit.unit), std::max(best.half_to_two, fit.half_to_two),
            std::max(best.least_quality, fit.least_quality)};
    round(HUGE_VAL, {refine_and_finish, kPasses.longest});
  }
}

// One round more, and as many as vertices beside the model need: they make room for each other, one step in each.
void Adapter::snap_to_model() {
  std::size_t before = ~std::size_t{0};
  for (std::size_t i = 0; i < kEnd.most_snapping; ++i) {
    round(HUGE_VAL, {polish});
    const std::size_t unsnapped = options_.model ? sum_of(last_counts_).unsnapped : 0;
    if (unsnapped == 0 || unsnapped >= before) break;
    before = unsnapped;
  }
}

// What all ranks have, by rank; on rank 0.
std::vector<double> Adapter::gather(std::vector<double>&& own) const {
  if (work_.rank_count() == 1) return std::move(own);
  const std::vector<Bytes> given = work_.exchange([&](std::span<MessageWriter> to) {
    to[0].put_array(std::span<const double>(own));
    own = {};
  });
  std::vector<double> all;
  work_.each([&] {
    if (work_.rank() == 0) all = joined_lists<double>(given);
  });
  return all;
}

// Each rank for its share. Nothing is looked up afterwards.
void Adapter::carry_fields(AdaptReport& report) {
  if (!tiles_ && !options_.transfer.empty()) {
    const std::size_t count = background_->mesh().tets.size();
    fields_before_ =
        fields_before({mesh_, {background_->mesh(), mesh_.tet_to_entity}, 0, count, {}}, options_.transfer, work_);
  }
  carrier_.emplace(mesh_, *background_, tiles_.get(), options_.transfer, std::move(fields_before_));
  if (!carrier_->has_none()) {
    std::vector<TetVerts> tets;
    work_.each([&] { tets = tets_of(whole_, runner_); });
    const TetsInRegions share{{whole_.points.span(), tets}, whole_.to_region.span()};
    // The hints of vertices are those of any number of ranks, and so are the places.
    carried_ = carrier_->carry(share, whole_.to_hint.span(), options_.cell_reconstruction, work_);
    report.transfers = carrier_->finish(share, carried_, work_);
  }
  background_.reset(), tiles_.reset(), implied_ = {};
  whole_.to_hint.release(), whole_.to_state.release();
}

Adapter::Whole Adapter::take_whole() {
  Whole result;
  // Vertices that lower ranks have as well come last.
  const std::size_t own = own_vert_count(links_, work_.rank()), verts = whole_.points.size();
  if (verts > 0) carried_.on_points.resize(carried_.on_points.size() / verts * own);
  CarriedFields carried{gather(std::move(carried_.on_points)), gather(std::move(carried_.on_tets))};
  whole_ = gather_shares(whole_, links_, work_);
  work_.each([&] {
    if (work_.rank() != 0) return;
    const std::size_t gathered = whole_.points.size();
    keep_values(carried.on_points, join_umbrellas(whole_, touching_), gathered);
    result.mesh = make_mesh_of(whole_, mesh_, work_.runner_for_one());
    result.metric = std::move(whole_.to_metric);
    whole_ = WholeMesh();
    carrier_->give(std::move(carried), result.mesh);
  });
  return result;
}

PartsWithMetric Adapter::take_parts() {
  const SharePieces pieces{whole_,
                           links_,
                           touching_,
                           mesh_,
                           {carrier_->infos_on_points(), carried_.on_points},
                           {carrier_->infos_on_tets(), carried_.on_tets}};
  PartsWithMetric parts = make_parts(pieces, last_parts_, work_);
  carried_ = CarriedFields();
  return parts;
}

void Adapter::note_rounds(AdaptReport& report) const {
  report.operations = sum_of(counts_);
  report.beside_model = sum_of(last_counts_).unsnapped;
  report.rounds = rounds_, report.most_parts = most_parts_, report.last_parts = last_parts_;
  report.stages.metric = seconds_.metric, report.stages.dealing = seconds_.dealing;
  report.stages.parts = seconds_.parts, report.stages.result = seconds_.result;
}

// Of all ranks.
PassCounts Adapter::sum_of(const PassCounts& counts) const {
  PassCounts sum;
  for (const Bytes& bytes : work_.all_gather([&](MessageWriter& writer) { writer.put(counts); }))
    sum.add(MessageReader(bytes).get<PassCounts>());
  return sum;
}

// Calls look_up(v) for all vertices. In together where there are tiles.
template <class LookUp>
void Adapter::look_up_verts(const LookUp& look_up, bool needs_tiles) {
  const auto tile_of = [&](std::size_t v) { return tiles_->tile_of(whole_.to_hint[v]); };
  look_up_all(needs_tiles ? tiles_.get() : nullptr, whole_.points.size(), kElementGrain, work_, tile_of,
              [&] { return std::cref(look_up); });
}

// The largest ratio of sizes of the mesh that was given to those asked for, where vertices are now.
double Adapter::refinement() {
  const MetricStage stage(*background_, implied_, function_, 1);
  const std::size_t count = whole_.points.size(), blocks = (count + kElementGrain - 1) / kElementGrain;
  std::vector<double> most(blocks, 0);
  look_up_verts([&](std::size_t v) {
    BackgroundTet hint = whole_.to_hint[v];
    most[v / kElementGrain] = std::max(most[v / kElementGrain], stage.refinement_at(whole_.points[v], hint));
    whole_.to_hint[v] = hint;
  });
  std::array<double, 1> all{0};
  for (const double one : most) all[0] = std::max(all[0], one);
  work_.max(all);
  return all[0];
}

void Adapter::set_metric(const MetricStage& stage) {
  const auto look_up = [&](std::size_t v) {
    BackgroundTet hint = whole_.to_hint[v];
    const Tensor tensor = stage.at(whole_.points[v], hint);
    // Where the stage asks for something else than the last one, everything is looked at again.
    if (!(tensor == whole_.to_metric[v].tensor)) whole_.to_state[v] = kHasChanged | kUnsettled;
    whole_.to_metric[v] = {tensor, det(tensor)};
    whole_.to_hint[v] = hint;
  };
  look_up_verts(look_up, stage.looks_up());
}

// One round at a stage of the metric.
void Adapter::round(double ratio, const Work& work) {
  Stopwatch watch;
  const MetricStage stage(*background_, implied_, function_, ratio);
  // In a stage vertices keep the metric of where they are.
  if (ratio != ratio_) set_metric(stage);
  if (tiles_) work_.each([&] { tiles_->drop_fetched(); });
  ratio_ = ratio;
  seconds_.metric += watch.lap();
  GrowingArray<float> to_work = work_per_tet();
  const double all = sum_of_work(to_work.span(), work_);
  const double wanted = options_.tets_per_part > 0 ? all / options_.tets_per_part : part_count_for(all);
  const auto parts = static_cast<std::size_t>(std::max(1.0, std::round(wanted)));
  last_parts_ = parts, most_parts_ = std::max(most_parts_, parts);
  Dealing dealing = deal_tets(whole_, links_, to_work.span(), parts, rounds_++, work_);
  to_work.release();
  seconds_.dealing += watch.lap();
  std::vector<PassCounts> counts(parts);
  PassOptions pass_options;
  pass_options.floor = options_.quality_floor;
  pass_options.most_tets =
      std::max(kDealing.least_full,
               kDealing.overfull * (all - kDealing.work_of_tet * count_tets()) / static_cast<double>(parts));
  const auto adapt_part = [&](std::size_t number, CavityMesh& part) {
    const SurfaceProjector project = options_.model ? make_projector(*options_.model) : SurfaceProjector();
    Passes passes(part, stage, project, pass_options, runner_);
    work.passes(passes);
    counts[number] = passes.counts();
  };
  const SideSplitOptions sides{work.longest, pass_options.floor, pass_options.most_tets, options_.model != nullptr};
  BackgroundTiles* const tiles = stage.looks_up() ? tiles_.get() : nullptr;
  const std::size_t split =
      adapt_in_parts(whole_, links_, std::move(dealing), {adapt_part, &stage, sides, tiles}, work_);
  seconds_.parts += watch.lap();
  last_counts_ = PassCounts();
  for (const PassCounts& part : counts) last_counts_.add(part);
  last_counts_.splits[static_cast<std::size_t>(Verdict::Done)] += split;
  counts_.add(last_counts_);
  runner_.advance();
}

// Of all ranks.
double Adapter::count_tets() const {
  std::array<std::int64_t, 1> sum{static_cast<std::int64_t>(whole_.size())};
  work_.sum(sum);
  return static_cast<double>(sum[0]);
}

// About how many tets it will become.
GrowingArray<float> Adapter::work_per_tet() const {
  GrowingArray<float> to_work;
  to_work.resize_for_overwrite(whole_.size());
  runner_.for_blocks(whole_.size(), kElementGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      const std::uint32_t* v = &whole_.to_vert[tet * 4];
      const Vec3& x = whole_.points[v[0]];
      const double volume = dot(cross(whole_.points[v[1]] - x, whole_.points[v[2]] - x), whole_.points[v[3]] - x) / 6;
      double density = 0;
      for (int i = 0; i < 4; ++i) density += 0.25 * std::sqrt(whole_.to_metric[v[i]].det);
      to_work[tet] = static_cast<float>(kDealing.work_of_tet + kDealing.tets_per_complexity * volume * density);
    }
  });
  return to_work;
}

Adapter::Fit Adapter::measure() const {
  struct Block {
    LengthCounts lengths;
    double least = 1;
  };
  const auto blocks = map_blocks(
      runner_, whole_.size(), kElementGrain, Block(), [&](std::size_t begin, std::size_t end, Block& result) {
        Block block;  // neighbouring results share lines of the cache
        for (std::size_t tet = begin; tet < end; ++tet) {
          std::array<std::uint32_t, 4> v;
          std::copy_n(&whole_.to_vert[tet * 4], 4, v.begin());
          block.least = std::min(block.least, cubed_mean_ratio(whole_.points, whole_.to_metric, v));
          block.lengths.add(edges_of_tet(whole_.points, whole_.to_metric, v.data()));
        }
        result = block;
      });
  std::array<std::int64_t, 3> sums{0, 0, static_cast<std::int64_t>(whole_.size()) * 6};
  std::array<double, 1> worst{-1};
  for (const Block& block : blocks) {
    sums[0] += block.lengths.unit, sums[1] += block.lengths.half_to_two;
    worst[0] = std::max(worst[0], -block.least);
  }
  work_.sum(sums);
  work_.max(worst);
  const auto all = static_cast<double>(std::max<std::int64_t>(1, sums[2]));
  return {static_cast<double>(sums[0]) / all, static_cast<double>(sums[1]) / all, -worst[0]};
}

}  // namespace tetloom::adapt
