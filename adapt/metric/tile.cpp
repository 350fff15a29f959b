#include "adapt/metric/tile.hpp"

#include <algorithm>

namespace tetloom::adapt {

Tile Tile::read(const Bytes& bytes) {
  MessageReader reader(bytes);
  Tile tile;
  tile.points = reader.get_view<Vec3>();
  tile.logs = reader.get_view<Tensor>(), tile.sizes = reader.get_view<double>();
  tile.implied = reader.get_view<Tensor>();
  tile.fields = reader.get_view<double>();
  tile.to_vert = reader.get_view<std::array<std::uint16_t, 4>>();
  tile.links = reader.get_view<std::array<FaceCode, 4>>();
  tile.linked = reader.get_view<std::uint32_t>();
  tile.numbers = reader.get_view<std::uint64_t>();
  tile.regions = reader.get_view<std::uint32_t>();
  tile.cells = reader.get_view<double>(), tile.slopes = reader.get_view<Vec3>();
  tile.boundary = reader.get_view<std::uint16_t>();
  return tile;
}

void put_tile(const Tile& tile, MessageWriter& writer) {
  writer.put_array(tile.points);
  writer.put_array(tile.logs), writer.put_array(tile.sizes), writer.put_array(tile.implied);
  writer.put_array(tile.fields);
  writer.put_array(tile.to_vert), writer.put_array(tile.links), writer.put_array(tile.linked);
  writer.put_array(tile.numbers);
  writer.put_array(tile.regions);
  writer.put_array(tile.cells), writer.put_array(tile.slopes);
  writer.put_array(tile.boundary);
}

Bytes bytes_of(const Tile& tile) {
  constexpr std::size_t kLengths = 320;  // of arrays, and what aligns them
  MessageWriter writer;
  writer.reserve(kLengths + tile.points.size_bytes() + tile.logs.size_bytes() + tile.sizes.size_bytes() +
                 tile.implied.size_bytes() + tile.fields.size_bytes() + tile.to_vert.size_bytes() +
                 tile.links.size_bytes() + tile.linked.size_bytes() + tile.numbers.size_bytes() +
                 tile.regions.size_bytes() + tile.cells.size_bytes() + tile.slopes.size_bytes() +
                 tile.boundary.size_bytes());
  put_tile(tile, writer);
  return writer.take();
}

void add_boxes(const Tile& tile, std::uint32_t number, std::vector<TileBox>& tets, std::vector<TileBox>& faces) {
  for (std::uint32_t place = 0; place < tile.to_vert.size(); ++place) {
    if (place % kTetsOfBox == 0) tets.push_back({{}, number, place});
    for (const Vec3& x : tile.corners(place)) tets.back().box.add(x);
  }
  for (std::uint32_t i = 0; i < tile.boundary.size(); ++i) {
    if (i % kFacesOfBox == 0) faces.push_back({{}, number, i});
    const auto corners = tile.corners(tile.boundary[i] / 4);
    for (const std::uint8_t corner : kFaceVerts[tile.boundary[i] % 4]) faces.back().box.add(corners[corner]);
  }
}

}  // namespace tetloom::adapt
