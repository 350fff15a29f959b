#include "adapt/parts/home_tiles.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/lists.hpp"

namespace tetloom::adapt {

namespace {

bool is_isotropic(const Tensor& log) { return log == diagonal(log.xx, log.xx, log.xx); }

// What came from one rank, where it lies.
struct Packet {
  explicit Packet(const Bytes& bytes) {
    MessageReader reader(bytes);
    names = reader.get_view<BackgroundTet>(), numbers = reader.get_view<std::uint64_t>();
    to_vert = reader.get_view<FourVerts>(), links = reader.get_view<FourFaces>();
    regions = reader.get_view<std::uint32_t>();
    cells = reader.get_view<double>(), slopes = reader.get_view<Vec3>();
    to_given = reader.get_view<std::uint64_t>(), points = reader.get_view<Vec3>();
    logs = reader.get_view<Tensor>(), implied = reader.get_view<Tensor>();
    fields = reader.get_view<double>();
  }
  std::span<const BackgroundTet> names;
  std::span<const std::uint64_t> numbers, to_given;
  std::span<const FourVerts> to_vert;
  std::span<const FourFaces> links;
  std::span<const std::uint32_t> regions;
  std::span<const double> cells;
  std::span<const Vec3> slopes, points;
  std::span<const Tensor> logs, implied;
  std::span<const double> fields;
};

class HomeTiles {
 public:
  HomeTiles(const NameRange& range, const TileContents& contents)
      : range_(range),
        has_metric_(contents.has_metric),
        components_(contents.components),
        cell_components_(contents.cell_components),
        slope_components_(contents.has_slopes ? contents.cell_components : 0) {}

  std::vector<Bytes> run(std::vector<Bytes>&& given, const TaskRunner& runner) {
    join_verts(given);
    take_tets(given);
    std::vector<Bytes> tiles((to_vert_.size() + kTileTets - 1) / kTileTets);
    runner.for_each(tiles.size(), [&](std::size_t tile) { tiles[tile] = make_tile(tile * kTileTets); });
    return tiles;
  }

 private:
  // A vertex that came: its number, from which rank, and where in the message.
  struct Came {
    std::uint64_t number;
    std::uint32_t rank, slot;
    auto operator<=>(const Came&) const = default;
  };

  void join_verts(const std::vector<Bytes>& given) {
    const std::vector<Packet> packets(given.begin(), given.end());
    std::vector<Came> came;
    for (std::uint32_t r = 0; r < packets.size(); ++r) {
      from_slots_.emplace_back(packets[r].to_given.size());
      for (std::uint32_t i = 0; i < packets[r].to_given.size(); ++i) came.push_back({packets[r].to_given[i], r, i});
    }
    std::ranges::sort(came);
    for (std::size_t i = 0; i < came.size(); ++i) {
      const Came& one = came[i];
      if (i == 0 || one.number != came[i - 1].number) add_vert(packets[one.rank], one.slot);
      from_slots_[one.rank][one.slot] = static_cast<std::uint32_t>(points_.size() - 1);
    }
  }

  void add_vert(const Packet& packet, std::size_t slot) {
    points_.push_back(packet.points[slot]), implied_.push_back(packet.implied[slot]);
    if (has_metric_) logs_.push_back(packet.logs[slot]);
    const auto fields = packet.fields.subspan(slot * components_, components_);
    fields_.insert(fields_.end(), fields.begin(), fields.end());
  }

  void take_tets(std::vector<Bytes>& given) {
    const std::size_t count = range_.end - range_.begin;
    to_vert_.resize(count), links_.resize(count), numbers_.resize(count);
    regions_.resize(cell_components_ > 0 ? count : 0);
    cells_.resize(count * cell_components_), slopes_.resize(count * slope_components_);
    for (std::size_t r = 0; r < given.size(); ++r) {
      const Packet packet(given[r]);
      for (std::size_t i = 0; i < packet.names.size(); ++i) {
        const std::size_t at = packet.names[i] - range_.begin;
        for (std::size_t j = 0; j < 4; ++j) to_vert_[at][j] = from_slots_[r][packet.to_vert[i][j]];
        links_[at] = packet.links[i], numbers_[at] = packet.numbers[i];
        if (cell_components_ == 0) continue;
        regions_[at] = packet.regions[i];
        std::copy_n(&packet.cells[i * cell_components_], cell_components_, &cells_[at * cell_components_]);
        if (slope_components_ == 0) continue;
        std::copy_n(&packet.slopes[i * slope_components_], slope_components_, &slopes_[at * slope_components_]);
      }
      given[r] = Bytes();
    }
  }

  Bytes make_tile(std::size_t begin) const {
    const std::size_t count = std::min<std::size_t>(kTileTets, to_vert_.size() - begin);
    const auto [verts, to_vert] = number_verts(begin, count);
    std::vector<Vec3> points;
    std::vector<Tensor> logs, implied;
    std::vector<double> fields;
    for (const std::uint32_t v : verts) {
      points.push_back(points_[v]), implied.push_back(implied_[v]);
      if (has_metric_) logs.push_back(logs_[v]);
      for (std::size_t c = 0; c < components_; ++c) fields.push_back(fields_[v * components_ + c]);
    }
    std::vector<double> sizes;
    if (has_metric_ && std::ranges::all_of(logs, is_isotropic)) {
      for (const Tensor& log : logs) sizes.push_back(log.xx);
      logs.clear();
    }
    std::vector<std::uint16_t> boundary;
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        if (!links_[begin + i][j].valid()) boundary.push_back(static_cast<std::uint16_t>(i * 4 + j));
    const std::vector<std::uint32_t> linked = tiles_behind(begin, count);
    const auto links = short_links(begin, count, linked);
    const auto of_tets = [&](const auto& all, std::size_t each) {
      return std::span(all).subspan(begin * each, count * each);
    };
    return bytes_of({points, logs, sizes, implied, fields, to_vert, links, linked, of_tets(numbers_, 1),
                     of_tets(regions_, cell_components_ > 0 ? 1 : 0), of_tets(cells_, cell_components_),
                     of_tets(slopes_, slope_components_), boundary});
  }

  std::uint32_t tile_of(BackgroundTet tet) const {
    return static_cast<std::uint32_t>((tet - range_.first) / kTileTets);
  }

  // Ascending.
  std::vector<std::uint32_t> tiles_behind(std::size_t begin, std::size_t count) const {
    std::vector<std::uint32_t> tiles;
    for (std::size_t i = begin; i < begin + count; ++i) {
      for (const BackgroundFace face : links_[i]) {
        if (!face.valid()) continue;
        const std::uint32_t tile = tile_of(face.tet());
        if (!tiles.empty() && tile == tiles.back()) continue;  // most lie in the same
        if (!has(tiles, tile)) tiles.push_back(tile);
      }
    }
    std::ranges::sort(tiles);
    return tiles;
  }

  std::vector<std::array<FaceCode, 4>> short_links(std::size_t begin, std::size_t count,
                                                   std::span<const std::uint32_t> linked) const {
    std::vector<std::array<FaceCode, 4>> links(count);
    std::size_t at = 0;  // most are as the one before
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        const BackgroundFace face = links_[begin + i][j];
        if (!face.valid()) continue;
        const std::uint32_t tile = tile_of(face.tet());
        if (linked[at] != tile) at = static_cast<std::size_t>(std::ranges::lower_bound(linked, tile) - linked.begin());
        const auto place = static_cast<std::uint32_t>((face.tet() - range_.first) % kTileTets);
        links[i][j] = FaceCode(static_cast<std::uint32_t>(at) * kTileTets + place, face.side());
      }
    }
    return links;
  }

  // The vertices of a tile, and its tets by their places among these.
  struct TileVerts {
    std::vector<std::uint32_t> verts;  // ascending
    std::vector<std::array<std::uint16_t, 4>> to_vert;
  };

  // Those of a tile have few different ones: they are found in a table of about twice as many places.
  TileVerts number_verts(std::size_t begin, std::size_t count) const {
    constexpr std::uint32_t kPlaces = 8 * kTileTets;  // more than tets have corners
    struct Place {
      std::uint32_t vert = kNone;
      std::uint16_t number = 0;
    };
    std::vector<Place> table(kPlaces);
    const auto place_of = [&](std::uint32_t vert) -> Place& {
      std::uint32_t at = vert * 2654435761u >> 20;  // of 2^12 places (Knuth 1998, 6.4)
      while (table[at].vert != kNone && table[at].vert != vert) at = (at + 1) % kPlaces;
      return table[at];
    };
    TileVerts result;
    for (std::size_t i = begin; i < begin + count; ++i) {
      for (const std::uint32_t vert : to_vert_[i]) {
        Place& place = place_of(vert);
        if (place.vert == vert) continue;
        place.vert = vert;
        result.verts.push_back(vert);
      }
    }
    std::ranges::sort(result.verts);
    for (std::size_t k = 0; k < result.verts.size(); ++k)
      place_of(result.verts[k]).number = static_cast<std::uint16_t>(k);
    result.to_vert.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < 4; ++j) result.to_vert[i][j] = place_of(to_vert_[begin + i][j]).number;
    return result;
  }

  const NameRange range_;
  const bool has_metric_;
  const std::size_t components_, cell_components_, slope_components_;
  // Vertices that came, each once.
  std::vector<Vec3> points_;
  std::vector<Tensor> logs_, implied_;
  std::vector<double> fields_;
  std::vector<std::vector<std::uint32_t>> from_slots_;  // of each rank's message
  // Tets by their names.
  std::vector<FourVerts> to_vert_;
  std::vector<FourFaces> links_;
  std::vector<std::uint64_t> numbers_;
  std::vector<std::uint32_t> regions_;
  std::vector<double> cells_;
  std::vector<Vec3> slopes_;
};

}  // namespace

std::vector<Bytes> make_home_tiles(std::vector<Bytes>&& given, const NameRange& range, const TileContents& contents,
                                   const TaskRunner& runner) {
  return HomeTiles(range, contents).run(std::move(given), runner);
}

}  // namespace tetloom::adapt
