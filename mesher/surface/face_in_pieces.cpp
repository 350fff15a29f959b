#include "mesher/surface/face_in_pieces.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "core/base/lists.hpp"
#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/patch_optimizer.hpp"

namespace tetloom {
namespace {

constexpr std::uint32_t kOwn = 0x80000000u;
constexpr std::uint8_t kZoneLayers = 4;  // of triangles, on either side of a cut
constexpr double kJunctionReach = 10;    // in sizes: past the ends of zones that meet at a small angle
constexpr std::size_t kZonesAtOnce = 2, kJunctionsAtOnce = 4;  // that share one evaluator of the surface

}  // namespace

FaceInPieces::FaceInPieces(const GeometricModel& model, ModelFaceId face, const FaceSurroundings& surroundings,
                           FaceCut cut, const std::function<bool()>& keep_going)
    : model_(model), face_(face), surroundings_(surroundings), cut_(std::move(cut)), keep_going_(keep_going) {
  while (rim_count_ < cut_.vertices.size() && cut_.vertices[rim_count_].node != kNone) ++rim_count_;
  parts_.resize(junction_part(0) + cut_.junctions.size() + 1);
  link_zones_to_junctions();
}

void FaceInPieces::link_zones_to_junctions() {
  part_to_sources_.resize(parts_.size());
  zone_to_junctions_.resize(cut_.zones.size());
  for (std::uint32_t z = 0; z < cut_.zones.size(); ++z)
    part_to_sources_[zone_part(z)].assign(cut_.zones[z].begin(), cut_.zones[z].end());
  std::map<std::array<std::uint32_t, 2>, std::uint32_t> numbers;
  for (std::uint32_t z = 0; z < cut_.zones.size(); ++z) numbers[cut_.zones[z]] = z;
  for (std::uint32_t j = 0; j < cut_.junctions.size(); ++j) {
    const std::vector<std::uint32_t>& pieces = cut_.junctions[j];
    std::vector<std::uint32_t>& sources = part_to_sources_[junction_part(j)];
    sources = pieces;
    for (std::size_t a = 0; a < pieces.size(); ++a)
      for (std::size_t b = a + 1; b < pieces.size(); ++b) {
        const auto zone = numbers.find({pieces[a], pieces[b]});
        if (zone == numbers.end()) continue;
        sources.push_back(static_cast<std::uint32_t>(zone_part(zone->second)));
        zone_to_junctions_[zone->second].push_back(j);
      }
    std::ranges::sort(sources);
  }
}

// ---- vertices of the face: those of the cut, then those of the parts ----------------------------------------------

void FaceInPieces::number_vertices(std::size_t first_part, std::size_t end_part) {
  for (std::size_t p = first_part; p < end_part; ++p)
    parts_[p].first = p == 0 ? static_cast<std::uint32_t>(cut_.vertices.size())
                             : parts_[p - 1].first + static_cast<std::uint32_t>(parts_[p - 1].own.size());
  for (std::size_t p = end_part; p < parts_.size(); ++p) parts_[p].first = kNone;
}

const PatchVertex& FaceInPieces::vertex(std::uint32_t id) const {
  if (id < cut_.vertices.size()) return cut_.vertices[id];
  const auto after = std::ranges::upper_bound(parts_, id, {}, &Part::first);
  const Part& part = *(after - 1);
  return part.own[id - part.first];
}

PatchVertex& FaceInPieces::vertex(std::uint32_t id) {
  return const_cast<PatchVertex&>(static_cast<const FaceInPieces*>(this)->vertex(id));
}

const PatchVertex& FaceInPieces::vertex_of(const Part& part, std::uint32_t vert) const {
  return vert & kOwn ? part.own[vert & ~kOwn] : vertex(vert);
}

FaceInPieces::FaceTriangle FaceInPieces::in_face(const Part& part, FaceTriangle triangle) {
  for (std::uint32_t& v : triangle.verts)
    if (v & kOwn) v = part.first + (v & ~kOwn);
  return triangle;
}

// ---- pieces -------------------------------------------------------------------------------------------------------

Patch FaceInPieces::piece_patch(const FacePiece& piece, PolygonVerdict& verdict) const {
  Patch patch;
  std::vector<Vec2> plane;
  for (const std::uint32_t v : piece.vertices) {
    patch.vertices.push_back(cut_.vertices[v]);
    if (v >= rim_count_) patch.vertices.back().node = kStill | v;
    plane.push_back(patch.vertices.back().place.plane);
  }
  PolygonTriangulation polygon = triangulate_polygon(plane, piece.segments);
  verdict = polygon.verdict;
  patch.topology = std::move(polygon.triangulation);
  patch.has_poles = cut_.has_poles;
  return patch;
}

void FaceInPieces::mesh_piece(std::size_t piece) {
  PolygonVerdict verdict;
  Patch patch = piece_patch(cut_.pieces[piece], verdict);
  parts_[piece].failed = verdict != PolygonVerdict::Ok;
  if (parts_[piece].failed) return;
  const auto geometry = model_.face_geometry(face_);
  const PatchSurface surface(*geometry, surroundings_.sizes, cut_.scale);
  reserve_expected(patch);
  refine_frontal(patch, surface, keep_going_);
  sort_spatially(patch);
  optimize_patch(patch, surface, {}, keep_going_);
  take_piece(piece, patch);
}

/// How far the vertices of a piece are from its cuts, and which part they would go to.
struct FaceInPieces::Layers {
  std::vector<std::uint8_t> layer;
  std::vector<std::uint32_t> label;
};

FaceInPieces::Layers FaceInPieces::find_layers(const FacePiece& piece, const Patch& patch) const {
  constexpr std::uint8_t kFar = 0xff;
  Layers layers{std::vector<std::uint8_t>(patch.vertices.size(), kFar),
                std::vector<std::uint32_t>(patch.vertices.size(), kNone)};
  std::vector<std::uint32_t> queue;
  for (std::uint32_t v = 0; v < piece.vertices.size(); ++v) {
    const CutVertex& kind = cut_.kinds[piece.vertices[v]];
    if (kind.zone == CutVertex::kNone && kind.junction == CutVertex::kNone) continue;
    layers.layer[v] = 0;
    layers.label[v] =
        static_cast<std::uint32_t>(kind.zone != CutVertex::kNone ? zone_part(kind.zone) : junction_part(kind.junction));
    queue.push_back(v);
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    const std::uint32_t v = queue[k];
    if (layers.layer[v] == kZoneLayers) continue;
    const auto reach = [&](std::uint32_t w) {
      if (layers.layer[w] != kFar) return;
      layers.layer[w] = static_cast<std::uint8_t>(layers.layer[v] + 1);
      layers.label[w] = layers.label[v];
      queue.push_back(w);
    };
    patch.topology.for_each_outgoing(v, [&](std::uint32_t h) {
      reach(patch.topology.target(h));
      reach(patch.topology.apex(h));
      return true;
    });
  }
  return layers;
}

void FaceInPieces::take_piece(std::size_t number, const Patch& patch) {
  const FacePiece& piece = cut_.pieces[number];
  const Layers layers = find_layers(piece, patch);
  Part& part = parts_[number];
  std::vector<std::uint32_t> ids(piece.vertices);
  ids.resize(patch.vertices.size(), kNone);
  for (std::size_t v = piece.vertices.size(); v < ids.size(); ++v) {
    if (patch.topology.outgoing(static_cast<std::uint32_t>(v)) == kNone) continue;
    ids[v] = kOwn | static_cast<std::uint32_t>(part.own.size());
    part.own.push_back(patch.vertices[v]);
  }
  const Triangulation& topology = patch.topology;
  for (std::uint32_t tri = 0; tri < topology.slots(); ++tri) {
    if (!topology.alive(tri)) continue;
    const auto verts = topology.triangle(tri);
    FaceTriangle triangle{{ids[verts[0]], ids[verts[1]], ids[verts[2]]}, 0};
    for (std::uint32_t i = 0; i < 3; ++i)
      if (topology.fixed(3 * tri + i) && triangle.verts[i] < rim_count_ && triangle.verts[(i + 1) % 3] < rim_count_)
        triangle.fixed = static_cast<std::uint8_t>(triangle.fixed | 1u << i);
    const auto nearest = *std::ranges::min_element(verts, {}, [&](std::uint32_t v) { return layers.layer[v]; });
    if (std::ranges::all_of(verts, [&](std::uint32_t v) { return layers.layer[v] <= kZoneLayers; }))
      part.loose.push_back({layers.label[nearest], triangle});
    else
      part.kept.push_back(triangle);
  }
  std::ranges::stable_sort(part.loose, {}, &LooseTriangle::label);
}

// ---- zones and junctions ------------------------------------------------------------------------------------------

std::vector<FaceInPieces::FaceTriangle> FaceInPieces::gather(std::size_t part,
                                                             std::span<const std::uint32_t> sources) const {
  std::vector<FaceTriangle> triangles;
  for (const std::uint32_t source : sources)
    for (const LooseTriangle& loose :
         std::ranges::equal_range(parts_[source].loose, static_cast<std::uint32_t>(part), {}, &LooseTriangle::label))
      triangles.push_back(in_face(parts_[source], loose.triangle));
  return triangles;
}

namespace {

/// Triangles of a face as a patch of their own; `ids` are the vertices of the face, ascending.
struct Region {
  Patch patch;
  std::vector<std::uint32_t> ids;
  std::vector<std::uint8_t> still;  // per vertex: on the rim of the region
};

template <class Triangles>
Region make_region(const Triangles& triangles) {
  Region region;
  for (const auto& triangle : triangles)
    region.ids.insert(region.ids.end(), triangle.verts.begin(), triangle.verts.end());
  sort_unique(region.ids);
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
  for (const auto& triangle : triangles) {
    auto& local = tri_to_vert.emplace_back();
    for (std::size_t i = 0; i < 3; ++i)
      local[i] =
          static_cast<std::uint32_t>(std::ranges::lower_bound(region.ids, triangle.verts[i]) - region.ids.begin());
  }
  Triangulation& topology = region.patch.topology;
  topology = Triangulation::from_triangles(static_cast<std::uint32_t>(region.ids.size()), tri_to_vert);
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    for (std::uint32_t i = 0; i < 3; ++i)
      if (triangles[t].fixed >> i & 1) topology.fix(3 * t + i, 1);
  region.still.assign(region.ids.size(), 0);
  for (std::uint32_t h = 0; h < topology.half_edges(); ++h)
    if (topology.twin(h) == kNone) region.still[topology.origin(h)] = region.still[topology.target(h)] = 1;
  return region;
}

}  // namespace

// Vertices inside of the triangles move, here alone; those on their rim are read by others, and hold still.
void FaceInPieces::improve(std::size_t number, const std::vector<FaceTriangle>& triangles,
                           const PatchSurface& surface) {
  if (triangles.empty()) return;
  Region region = make_region(triangles);
  Patch& patch = region.patch;
  patch.has_poles = cut_.has_poles;
  for (std::size_t v = 0; v < region.ids.size(); ++v) {
    patch.vertices.push_back(std::as_const(*this).vertex(region.ids[v]));
    if (region.ids[v] >= rim_count_) patch.vertices.back().node = region.still[v] ? kStill | region.ids[v] : kNone;
  }
  optimize_patch(patch, surface, {}, keep_going_);
  Part& part = parts_[number];
  std::vector<std::uint32_t> ids(region.ids);
  ids.resize(patch.vertices.size(), kNone);
  for (std::uint32_t v = 0; v < ids.size(); ++v) {
    const bool used = patch.topology.outgoing(v) != kNone, given = v < region.ids.size();
    if (given && !used) part.dropped.push_back(ids[v]);
    if (given && used && patch.vertices[v].node == kNone) {
      vertex(ids[v]) = patch.vertices[v];
      part.moved.push_back(ids[v]);
    }
    if (given || !used) continue;
    ids[v] = kOwn | static_cast<std::uint32_t>(part.own.size());
    part.own.push_back(patch.vertices[v]);
  }
  for (std::uint32_t tri = 0; tri < patch.topology.slots(); ++tri) {
    if (!patch.topology.alive(tri)) continue;
    const auto [a, b, c] = patch.topology.triangle(tri);
    std::uint8_t fixed = 0;
    for (std::uint32_t i = 0; i < 3; ++i)
      if (patch.topology.fixed(3 * tri + i)) fixed = static_cast<std::uint8_t>(fixed | 1u << i);
    part.kept.push_back({{ids[a], ids[b], ids[c]}, fixed});
  }
}

// What is near the ends of a zone goes to the nearest of its junctions.
void FaceInPieces::hand_to_junctions(std::uint32_t zone) {
  Part& part = parts_[zone_part(zone)];
  std::vector<FaceTriangle> kept;
  for (const FaceTriangle& triangle : part.kept) {
    Vec3 center;
    for (const std::uint32_t v : triangle.verts) center += vertex_of(part, v).place.point / 3.0;
    double least = HUGE_VAL;
    std::uint32_t nearest = 0;
    for (const std::uint32_t j : zone_to_junctions_[zone]) {
      const PatchVertex& at = cut_.vertices[cut_.junction_to_vertex[j]];
      const double away = distance(center, at.place.point) / at.size;
      if (away < least) least = away, nearest = j;
    }
    if (least < kJunctionReach)
      part.loose.push_back({static_cast<std::uint32_t>(junction_part(nearest)), triangle});
    else
      kept.push_back(triangle);
  }
  part.kept = std::move(kept);
  std::ranges::stable_sort(part.loose, {}, &LooseTriangle::label);
}

void FaceInPieces::improve_parts(std::size_t first_part, std::size_t end_part, std::size_t at_once,
                                 const SharedWork& work) {
  const auto for_each_of = [&](std::size_t block, const auto& visit) {
    const std::size_t begin = first_part + block * at_once;
    for (std::size_t part = begin; part < std::min(begin + at_once, end_part); ++part) visit(part);
  };
  const auto make = [&](std::size_t block) {
    const auto geometry = model_.face_geometry(face_);
    const PatchSurface surface(*geometry, surroundings_.sizes, cut_.scale);
    for_each_of(block, [&](std::size_t part) {
      improve(part, gather(part, part_to_sources_[part]), surface);
      if (part < junction_part(0)) hand_to_junctions(static_cast<std::uint32_t>(part - zone_part(0)));
    });
  };
  const std::vector<double> blocks((end_part - first_part + at_once - 1) / at_once, 1.0);
  work.for_each(blocks, {make,
                         [&](std::size_t block, MessageWriter& writer) {
                           for_each_of(block, [&](std::size_t part) { put_part(part, writer); });
                         },
                         [&](std::size_t block, MessageReader& reader) {
                           for_each_of(block, [&](std::size_t part) { take_part(part, reader); });
                         }});
  number_vertices(first_part, end_part);
}

std::optional<FaceMesh> FaceInPieces::join(const SharedWork& work) {
  if (std::ranges::any_of(parts_, &Part::failed)) return {};
  number_vertices(0, zone_part(0));
  improve_parts(zone_part(0), junction_part(0), kZonesAtOnce, work);
  improve_parts(junction_part(0), parts_.size() - 1, kJunctionsAtOnce, work);
  number_vertices(parts_.size() - 1, parts_.size());
  split_taken_chords();
  return extract(work.runner());
}

}  // namespace tetloom
