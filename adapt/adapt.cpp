#include "adapt/adapt.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/adapt_on_ranks.hpp"
#include "adapt/input_checks.hpp"
#include "adapt/kernel/passes.hpp"
#include "adapt/metric/background.hpp"
#include "adapt/parts/model_fit.hpp"
#include "adapt/parts/rounds.hpp"
#include "core/base/mix_bits.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/volume/model_projector.hpp"

namespace tetloom {

namespace {

using namespace adapt;

constexpr double kTetsPerPart = 1e5;
constexpr double kTetsPerComplexity = 10;
constexpr std::size_t kGrain = std::size_t{1} << 12;
constexpr std::size_t kMostStages = 40;
constexpr std::size_t kMostRounds = 12;  // at the metric itself
constexpr double kWorthARound = 0.001;   // of the share of unit edges
constexpr double kEnough = 0.985;        // of it
constexpr double kNearlyAll = 0.9999;    // of edges of lengths in [1/2, 2]
constexpr double kMovable = 0.92;        // mean ratio below which the vertices of a tet move
constexpr double kCollapsed = 0.73;      // a little above the shortest: what is collapsed and split does not alternate
constexpr double kLongest = 1.4142135623730951, kShortest = 0.7071067811865476;

// What is done to each part in one round.
using Work = std::function<void(Passes&)>;

// Two rounds for each stage, so that the sides of parts, where nothing is split, differ between them.
void grow(Passes& passes) { passes.split_edges(2), passes.swap(0.6); }

void settle(Passes& passes) {
  passes.split_edges(1.6), passes.collapse_edges(0.7, 1.45), passes.swap(0.6), passes.smooth(0.85);
}

void finish(Passes& passes) { passes.collapse_edges(kCollapsed, kLongest), passes.swap(0.8), passes.smooth(kMovable); }

void refine_and_finish(Passes& passes) { passes.split_edges(kLongest), finish(passes); }

class Adapter {
 public:
  Adapter(const Mesh& mesh, const MetricField& metric, const MetricFunction& function, const AdaptOptions& options,
          const SharedWork& work)
      : mesh_(mesh),
        function_(function),
        options_(options),
        work_(work),
        runner_(work.runner()),
        whole_(make_whole_mesh(mesh, runner_)) {
    if (options.model) require_model_fits(whole_, mesh, *options.model, runner_);
    // Tets may have been turned when they were linked.
    std::vector<TetVerts> tets(whole_.size());
    for (std::size_t tet = 0; tet < tets.size(); ++tet) std::copy_n(&whole_.to_vert[tet * 4], 4, tets[tet].begin());
    const TetView view{whole_.points.span(), tets};
    implied_ = implied_metric(view, runner_);
    background_.emplace(view, metric, runner_);
    links_ = take_share(whole_, work_);
  }

  void run(AdaptResult& result) {
    runner_.begin_stage(Stage::Adapt, 0);
    double ratio = 2;
    for (std::size_t stage = 0; stage < kMostStages; ++stage, ratio *= 2) {
      if (refinement() <= ratio) break;
      round(ratio, grow);
      round(ratio, settle);
    }
    round(HUGE_VAL, refine_and_finish);
    Lengths best;
    for (std::size_t i = 0, idle = 0; i < kMostRounds && idle < 2; ++i) {
      const Lengths lengths = measure_lengths();
      if (lengths.unit > kEnough && lengths.half_to_two > kNearlyAll) break;
      idle = lengths.unit < best.unit + kWorthARound && lengths.half_to_two <= best.half_to_two ? idle + 1 : 0;
      best = {std::max(best.unit, lengths.unit), std::max(best.half_to_two, lengths.half_to_two)};
      round(HUGE_VAL, refine_and_finish);
    }
    Stopwatch watch;
    round(HUGE_VAL, finish);
    watch.lap();
    whole_ = gather_shares(whole_, links_, work_);
    work_.each([&] {
      if (work_.rank() != 0) return;
      result.mesh = make_mesh_of(whole_, mesh_);
      result.report.transfers =
          transfer_fields(mesh_, *background_, result.mesh, options_.transfer, options_.cell_shape, runner_);
    });
    result.report.operations = sum_of_counts();
    result.report.rounds = rounds_;
    result.report.most_parts = most_parts_;
    result.report.last_parts = last_parts_;
    result.report.stages.metric = metric_seconds_, result.report.stages.dealing = dealing_seconds_;
    result.report.stages.parts = parts_seconds_, result.report.stages.result = watch.lap();
  }

  MetricField metric_of_result() const {
    MetricField metric;
    for (const VertexMetric& m : whole_.to_metric) metric.logs.push_back(log(m.tensor));
    return metric;
  }

 private:
  // Of all ranks.
  PassCounts sum_of_counts() const {
    PassCounts sum;
    for (const Bytes& bytes : work_.all_gather([&](MessageWriter& writer) { writer.put(counts_); }))
      sum.add(MessageReader(bytes).get<PassCounts>());
    return sum;
  }

  // The largest ratio of sizes of the mesh that was given to those asked for, where vertices are now.
  double refinement() {
    const MetricStage stage(*background_, implied_, function_, 1);
    const std::size_t count = whole_.points.size(), blocks = (count + kGrain - 1) / kGrain;
    std::vector<double> most(blocks, 0);
    runner_.for_blocks(count, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        std::uint32_t hint = whole_.to_hint[v];
        most[begin / kGrain] = std::max(most[begin / kGrain], stage.refinement_at(whole_.points[v], hint));
        whole_.to_hint[v] = hint;
      }
    });
    std::array<double, 1> all{0};
    for (const double one : most) all[0] = std::max(all[0], one);
    work_.max(all);
    return all[0];
  }

  // One round at a stage of the metric.
  void round(double ratio, const Work& work) {
    Stopwatch watch;
    const MetricStage stage(*background_, implied_, function_, ratio);
    runner_.for_blocks(whole_.points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        std::uint32_t hint = whole_.to_hint[v];
        const Tensor tensor = stage.at(whole_.points[v], hint);
        // Where the stage asks for something else than the last one, everything is looked at again.
        if (!(tensor == whole_.to_metric[v].tensor)) whole_.to_state[v] = kHasChanged | kUnsettled;
        whole_.to_metric[v] = {tensor, det(tensor)};
        whole_.to_hint[v] = hint;
      }
    });
    metric_seconds_ += watch.lap();
    const std::vector<float> to_work = work_per_tet();
    const double per_part = options_.tets_per_part > 0 ? options_.tets_per_part : kTetsPerPart;
    const auto parts = static_cast<std::size_t>(std::max(1.0, std::round(sum_of_work(to_work, work_) / per_part)));
    last_parts_ = parts, most_parts_ = std::max(most_parts_, parts);
    Dealing dealing = deal_tets(whole_, links_, to_work, parts, rounds_++, work_);
    dealing_seconds_ += watch.lap();
    std::vector<PassCounts> counts(parts);
    const PassOptions pass_options{options_.quality_floor};
    const auto adapt_part = [&](std::size_t number, CavityMesh& part) {
      const tets::SurfaceProjector project =
          options_.model ? volume::make_projector(*options_.model) : tets::SurfaceProjector();
      Passes passes(part, stage, project, pass_options, runner_);
      work(passes);
      counts[number] = passes.counts();
    };
    adapt_in_parts(whole_, links_, std::move(dealing), adapt_part, work_);
    parts_seconds_ += watch.lap();
    for (const PassCounts& part : counts) counts_.add(part);
    runner_.advance();
  }

  // About how many tets it will become.
  std::vector<float> work_per_tet() const {
    std::vector<float> to_work(whole_.size());
    runner_.for_blocks(whole_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t tet = begin; tet < end; ++tet) {
        const std::uint32_t* v = &whole_.to_vert[tet * 4];
        const Vec3& x = whole_.points[v[0]];
        const double volume = dot(cross(whole_.points[v[1]] - x, whole_.points[v[2]] - x), whole_.points[v[3]] - x) / 6;
        double density = 0;
        for (int i = 0; i < 4; ++i) density += 0.25 * std::sqrt(whole_.to_metric[v[i]].det);
        to_work[tet] = static_cast<float>(0.7 + kTetsPerComplexity * volume * density);
      }
    });
    return to_work;
  }

  // Shares of edges with lengths in [1/sqrt 2, sqrt 2] and [1/2, 2], each counted by every tet that has it.
  struct Lengths {
    double unit = 0, half_to_two = 0;
  };

  Lengths measure_lengths() const {
    using Counts = std::array<std::int64_t, 3>;
    std::vector<Counts> counts((whole_.size() + kGrain - 1) / kGrain, Counts{});
    runner_.for_blocks(whole_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      auto& [unit, half_to_two, all] = counts[begin / kGrain];
      for (std::size_t tet = begin; tet < end; ++tet) {
        for (const auto& [i, j] : kEdgeCorners) {
          const std::uint32_t a = whole_.to_vert[tet * 4 + i], b = whole_.to_vert[tet * 4 + j];
          const double length =
              edge_length(whole_.to_metric[a].tensor, whole_.to_metric[b].tensor, whole_.points[b] - whole_.points[a]);
          unit += length >= kShortest && length <= kLongest;
          half_to_two += length >= 0.5 && length <= 2;
        }
      }
    });
    Counts sum{0, 0, static_cast<std::int64_t>(whole_.size()) * 6};
    for (const Counts& block : counts) sum[0] += block[0], sum[1] += block[1];
    work_.sum(sum);
    const auto all = static_cast<double>(std::max<std::int64_t>(1, sum[2]));
    return {static_cast<double>(sum[0]) / all, static_cast<double>(sum[1]) / all};
  }

  const Mesh& mesh_;
  const MetricFunction& function_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  WholeMesh whole_;  // between rounds the share of it that this rank has
  ShareLinks links_;
  std::vector<Tensor> implied_;
  std::optional<BackgroundMesh> background_;
  PassCounts counts_;
  std::size_t rounds_ = 0, most_parts_ = 0, last_parts_ = 0;
  double metric_seconds_ = 0, dealing_seconds_ = 0, parts_seconds_ = 0;
};

void check_options(const AdaptOptions& options) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::InvalidArgument, message); };
  if (!(options.quality_floor >= 0 && options.quality_floor < 1)) refuse("the quality floor must be in [0, 1)");
  if (options.gradation != 0 && !(options.gradation > 1)) refuse("the gradation must be above 1, or 0 for none");
  if (options.threads < 0) refuse("the number of threads must not be negative");
  if (!(options.tets_per_part >= 0)) refuse("the number of tets per part must not be negative");
  if (options.parts < 0) refuse("the number of parts must not be negative");
}

template <class Run>
AdaptResult guarded(const Run& run) {
  AdaptResult result;
  Stopwatch watch;
  try {
    run(result);
    result.status = AdaptStatus::Ok;
  } catch (const Error& error) {
    result.errors.push_back(error.diagnostic());
    result.status = error.code() == ErrorCode::Cancelled ? AdaptStatus::Cancelled : AdaptStatus::Failed;
    result.mesh = Mesh();
  } catch (const std::bad_alloc&) {
    result.errors.push_back(Diagnostic{ErrorCode::OutOfMemory, "not enough memory to adapt the mesh", {}, {}, {}});
    result.mesh = Mesh();
  }
  result.report.seconds = watch.lap();
  return result;
}

// What ranks give differs where they read different files, say; it would leave them waiting for each other.
void require_same_input(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                        const SharedWork& work) {
  if (work.rank_count() == 1) return;
  std::uint64_t hash = 0;
  const auto add = [&](const auto& values) {
    hash = mix_bits(hash ^ values.size());
    for (const std::byte byte : std::as_bytes(std::span(values)))
      hash = hash * 0x100000001b3u ^ std::to_integer<std::uint64_t>(byte);
  };
  work.each([&] {
    add(mesh.points), add(mesh.tet_to_vert), add(mesh.tri_to_vert), add(metric.logs);
    add(std::array<double, 5>{options.quality_floor, options.gradation, options.tets_per_part, 1.0 * options.parts,
                              static_cast<double>(options.cell_shape)});
    for (const std::string& name : options.transfer) add(name);
  });
  for (const Bytes& bytes : work.all_gather([&](MessageWriter& writer) { writer.put(hash); }))
    if (MessageReader(bytes).get<std::uint64_t>() != hash)
      throw Error(ErrorCode::InvalidArgument, "the ranks were not given the same mesh, metric and options");
}

// What rank 0 has measured.
MetricConformity share_conformity(const MetricConformity& measured, const SharedWork& work) {
  return MessageReader(work.all_gather([&](MessageWriter& writer) { writer.put(measured); })[0])
      .get<MetricConformity>();
}

class AdaptRun {
 public:
  AdaptRun(const Mesh& mesh, const MetricField* given, const MetricFunction& function, const AdaptOptions& options,
           const SharedWork& work)
      : mesh_(mesh), given_(given), function_(function), options_(options), work_(work) {}

  void run(AdaptResult& result) {
    Stopwatch watch;
    work_.each([&] { prepare(result); });
    require_same_input(mesh_, metric_, options_, work_);
    std::optional<Adapter> adapter;
    work_.each([&] { adapter.emplace(mesh_, metric_, function_, options_, work_); });
    result.report.stages.set_up = watch.lap();
    adapter->run(result);
    watch.lap();
    work_.each([&] {
      if (work_.rank() == 0)
        result.report.after = measure_conformity(result.mesh, adapter->metric_of_result(), work_.runner_for_one());
    });
    result.report.after = share_conformity(result.report.after, work_);
    result.report.stages.result += watch.lap();
  }

 private:
  void prepare(AdaptResult& result) {
    const TaskRunner& runner = work_.runner();
    check_options(options_);
    check_mesh(mesh_, runner);
    check_transfer(mesh_, options_.transfer);
    metric_ = given_ ? *given_ : metric_from_function(function_, mesh_.points, runner);
    check_metric(metric_, mesh_);
    if (options_.gradation > 0 && given_) {
      const TetView view{mesh_.points, mesh_.tet_to_vert};
      limit_gradation(metric_, mesh_.points, VertexGraph(view, runner), options_.gradation, runner);
    }
    result.report.before = measure_conformity(mesh_, metric_, runner);
    check_complexity(result.report.before.complexity);
  }

  const Mesh& mesh_;
  const MetricField* given_;
  const MetricFunction& function_;
  const AdaptOptions& options_;
  const SharedWork& work_;
  MetricField metric_;
};

AdaptResult adapt_to(const Mesh& mesh, const MetricField* given, const MetricFunction& function,
                     const AdaptOptions& options, Communicator* ranks, const Host& host) {
  return guarded([&](AdaptResult& result) {
    const SharedWork work(std::max(0, options.threads), host, ranks, options.trace);
    work.together([&] { AdaptRun(mesh, given, function, options, work).run(result); });
  });
}

}  // namespace

AdaptResult adapt_mesh(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, nullptr, host);
}

AdaptResult adapt_mesh(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric, const AdaptOptions& options,
                       const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, nullptr, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const MetricField& metric, const AdaptOptions& options,
                                Communicator& ranks, const Host& host) {
  return adapt_to(mesh, &metric, {}, options, &ranks, host);
}

AdaptResult adapt_mesh_on_ranks(const Mesh& mesh, const std::function<Tensor(const Vec3&)>& metric,
                                const AdaptOptions& options, Communicator& ranks, const Host& host) {
  return adapt_to(mesh, nullptr, metric, options, &ranks, host);
}

}  // namespace tetloom
