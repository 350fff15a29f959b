// The background in tiles over ranks: what it says of places and metrics, and what is at hand for it.
#include "adapt/metric/background_tiles.hpp"

#include <catch2/catch.hpp>

#include "adapt/adapter.hpp"
#include "adapt/kernel/metric_stage.hpp"
#include "adapt/metric/background.hpp"
#include "adapt/metric/background_search.hpp"
#include "adapt/parts/needed_tiles.hpp"
#include "adapt/parts/rounds.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/adapt/touching_blocks.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

/// A box with a slot from above, of 6 * (3 * cuts)³ * 7 / 9 tets.
Mesh make_u(int cuts) {
  return Blocks(3, cuts, [](const Block& block) { return block[0] == 1 && block[1] > 0 ? -1 : 0; }).run();
}

MetricField random_metric(const Mesh& mesh, bool isotropic = false) {
  RandomTensors random(5);
  MetricField metric;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Tensor log = random.tensor();
    metric.logs.push_back(isotropic ? diagonal(log.xx, log.xx, log.xx) : log);
  }
  return metric;
}

/// A mesh, the background that it is in one piece, and the same in tiles.
struct Spread {
  BackgroundMesh whole;
  std::vector<Tensor> implied;
  AdapterShare made;
  WholeMesh& share = made.mesh;
  ShareLinks& links = made.links;
  std::unique_ptr<BackgroundTiles>& tiles = made.tiles;

  Spread(const Mesh& mesh, const MetricField& metric, const SharedWork& work)
      : whole(tets_of(mesh), metric, work.runner()),
        implied(implied_metric(whole.mesh())),
        made(share_of(slice_of(mesh, metric, {}, work.rank(), work.rank_count()), {}, {}, work)) {}
};

/// Calls body(spread, work) on all of some ranks.
void on_ranks(const Mesh& mesh, const MetricField& metric, int ranks,
              const std::function<void(Spread&, const SharedWork&)>& body) {
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const SharedWork work(1, Host(), &communicator);
    work.together([&] {
      Spread spread(mesh, metric, work);
      body(spread, work);
    });
  });
}

bool operator==(const BackgroundPlace& a, const BackgroundPlace& b) { return a.tet == b.tet && a.weights == b.weights; }

/// What the tiles say of x, with the tet's number in the mesh that was given.
struct Said {
  BackgroundPlace place;
  Tensor log, implied;
};

Said say(const BackgroundTiles& tiles, const Vec3& x, BackgroundTet hint) {
  Said said{BackgroundSearch(tiles).locate(x, hint), {}, {}};
  said.log = tiles.log_metric_at(said.place), said.implied = tiles.implied_log_at(said.place);
  said.place.tet = tiles.number(said.place.tet);
  return said;
}

}  // namespace

TEST_CASE("places, metrics and implied metrics in tiles are those of the whole mesh, bit by bit", "[tiles]") {
  const Mesh mesh = make_u(4);
  const MetricField metric = random_metric(mesh, GENERATE(false, true));
  for (const int ranks : {1, 2, 3, 5}) {
    CAPTURE(ranks);
    std::vector<std::size_t> wrong(static_cast<std::size_t>(ranks), 0), outside(wrong);
    on_ranks(mesh, metric, ranks, [&](Spread& spread, const SharedWork& work) {
      RandomTensors random(static_cast<unsigned>(7 + work.rank()));
      const auto rank = static_cast<std::size_t>(work.rank());
      for (int i = 0; i < 300; ++i) {
        // In the box, in its slot, and beside it; hints that are near and others that are far.
        const Vec3 x{random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2)};
        const auto vert = static_cast<std::size_t>(random.uniform(0, static_cast<double>(spread.share.points.size())));
        const BackgroundTet hint = spread.share.to_hint[vert];
        Said said;
        BackgroundTet number = kNoTet;
        spread.tiles->until_found(work, [&] {
          spread.tiles->finds([&] { number = spread.tiles->number(hint), said = say(*spread.tiles, x, hint); });
        });
        const BackgroundPlace place = spread.whole.locate(x, number);
        wrong[rank] += !(place == said.place) || !(spread.whole.log_metric_at(place) == said.log) ||
                       !(spread.whole.implied_log_at(place, spread.implied) == said.implied);
        outside[rank] += *std::ranges::min_element(place.weights) == 0;
      }
    });
    CHECK(std::ranges::count(wrong, 0) == ranks);
    CHECK(std::ranges::count_if(outside, [](std::size_t count) { return count > 50; }) == ranks);
  }
}

TEST_CASE("vertices begin in the first of the tets that have them", "[tiles]") {
  const Mesh mesh = make_u(3);
  std::vector<std::size_t> wrong(3, 0);
  on_ranks(mesh, random_metric(mesh), 3, [&](Spread& spread, const SharedWork& work) {
    const auto has = [](const TetVerts& tet, std::uint32_t v) { return std::ranges::count(tet, v) != 0; };
    for (std::size_t v = 0; v < spread.share.points.size(); ++v) {
      const auto given = static_cast<std::uint32_t>(spread.links.to_number[v]);
      std::uint32_t number = kNone;
      spread.tiles->until_found(work, [&] {
        spread.tiles->finds(
            [&] { number = static_cast<std::uint32_t>(spread.tiles->number(spread.share.to_hint[v])); });
      });
      const auto first = std::ranges::find_if(mesh.tet_to_vert, [&](const TetVerts& tet) { return has(tet, given); });
      wrong[static_cast<std::size_t>(work.rank())] += number != first - mesh.tet_to_vert.begin();
      if (v >= 50) break;  // ranks must look up equally often
    }
  });
  CHECK(wrong == std::vector<std::size_t>(3, 0));
}

TEST_CASE("a tile that is not at hand is missed, there once it was fetched, and missed again when dropped", "[tiles]") {
  const Mesh mesh = make_u(4);
  std::vector<std::size_t> found(2, 0), right(2, 0);
  on_ranks(mesh, random_metric(mesh), 2, [&](Spread& spread, const SharedWork& work) {
    BackgroundTiles& tiles = *spread.tiles;
    const auto rank = static_cast<std::size_t>(work.rank());
    // The first tet of the other rank's first tile: the tiles of rank 1 come last.
    const std::uint32_t tile = rank == 0 ? static_cast<std::uint32_t>(tiles.tile_count() - 1) : 0;
    const auto look = [&] { static_cast<void>(tiles.number(tiles.name_of(tile, 0))); };
    const bool before = tiles.finds(look);
    tiles.until_found(work, [&] { found[rank] += tiles.finds(look); });
    tiles.drop_fetched();
    const bool dropped = tiles.finds(look);
    tiles.fetch_only({tile}, work);
    right[rank] = !before && !dropped && tiles.finds(look);
  });
  CHECK(found == std::vector<std::size_t>(2, 1));
  CHECK(right == std::vector<std::size_t>(2, 1));
}

TEST_CASE("the tiles where a part lies have all places in it", "[tiles]") {
  const Mesh mesh = make_u(5);
  std::vector<std::size_t> misses(3, 1), at_hand(3, 0);
  on_ranks(mesh, random_metric(mesh), 3, [&](Spread& spread, const SharedWork& work) {
    const auto rank = static_cast<std::size_t>(work.rank());
    BackgroundTiles& tiles = *spread.tiles;
    const std::vector<float> even(spread.share.size(), 1);
    Dealing dealing = deal_tets(spread.share, spread.links, even, 6, 1, work);
    RoundShare moved = move_tets(spread.share, spread.links, std::move(dealing.to_part), 6, work);
    const std::vector<PartOfWhole> parts =
        cut_parts(moved, static_cast<std::uint32_t>(2 * work.rank()), 2, work.runner());
    std::vector<std::uint32_t> needed = needed_tiles(parts, tiles, work.runner());
    at_hand[rank] = needed.size();
    tiles.fetch_only(std::move(needed), work);
    RandomTensors random(3);
    misses[rank] = 0;
    for (const PartOfWhole& part : parts) {
      for (std::size_t tet = 0; tet < part.mesh.mesh.size(); ++tet) {
        const std::uint32_t* v = part.mesh.verts(static_cast<std::uint32_t>(tet));
        Vec3 x = part.mesh.point(v[0]);
        for (int i = 1; i < 4; ++i) x += 0.3 * random.uniform(0, 1) * (part.mesh.point(v[i]) - part.mesh.point(v[0]));
        misses[rank] += !tiles.finds([&] { say(tiles, x, part.mesh.to_hint[v[0]]); });
      }
    }
  });
  CHECK(misses == std::vector<std::size_t>(3, 0));
  for (const std::size_t count : at_hand) CHECK(count > 1);
}

/// Adapts two parts on two ranks; `adapt` is given a tet of a tile that is not at hand.
void in_two_parts(Spread& spread, const SharedWork& work,
                  const std::function<void(CavityMesh& part, BackgroundTet elsewhere)>& adapt) {
  const std::vector<float> even(spread.share.size(), 1);
  const auto last = static_cast<std::uint32_t>(spread.tiles->tile_count() - 1);
  const BackgroundTet elsewhere = spread.tiles->name_of(work.rank() == 0 ? last : 0, 0);
  RoundWork round;
  round.tiles = spread.tiles.get();
  round.adapt = [&](std::size_t, CavityMesh& part) {
    spread.tiles->drop_fetched();
    adapt(part, elsewhere);
  };
  adapt_in_parts(spread.share, spread.links, deal_tets(spread.share, spread.links, even, 2, 0, work), round, work);
}

TEST_CASE("a part that lacks a tile waits for it where it is", "[tiles]") {
  const Mesh mesh = make_u(4);
  std::vector<std::size_t> calls(2, 0), wrong(2, 1);
  on_ranks(mesh, random_metric(mesh), 2, [&](Spread& spread, const SharedWork& work) {
    const auto rank = static_cast<std::size_t>(work.rank());
    in_two_parts(spread, work, [&](CavityMesh& part, BackgroundTet elsewhere) {
      ++calls[rank];
      for (Vec3& x : part.mesh.points) x.x += 2;
      static_cast<void>(spread.tiles->number(elsewhere));
      for (Vec3& x : part.mesh.points) x.y += 2;
    });
    wrong[rank] = 0;
    for (const Vec3& x : spread.share.points) wrong[rank] += x.x < 2 || x.x > 3 || x.y < 2 || x.y > 3;
  });
  CHECK(calls == std::vector<std::size_t>(2, 1));
  CHECK(wrong == std::vector<std::size_t>(2, 0));
}

TEST_CASE("a part that waits is left where another fails", "[tiles]") {
  const Mesh mesh = make_u(4);
  bool went_on = false;
  const auto run = [&] {
    on_ranks(mesh, random_metric(mesh), 2, [&](Spread& spread, const SharedWork& work) {
      in_two_parts(spread, work, [&](CavityMesh&, BackgroundTet elsewhere) {
        if (work.rank() == 0) throw Error(ErrorCode::InvalidArgument, "not this part");
        static_cast<void>(spread.tiles->number(elsewhere));
        went_on = true;
      });
    });
  };
  CHECK_THROWS_WITH(run(), "not this part");
  CHECK_FALSE(went_on);
}
