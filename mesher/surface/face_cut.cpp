#include "mesher/surface/face_cut.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/triangle_sharing.hpp"

namespace tetloom {
namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;
constexpr double kCoarsening = 16;  // of the triangles that are shared out: about 60 of them make a piece

// ---- how many triangles -------------------------------------------------------------------------------------------

// Triangles per area of the plane.
double density(const PatchPlace& place, double size) {
  return kTrianglesPerSquare * norm(cross(place.du, place.dv)) / (size * size);
}

// By samples, in four parts where they differ.
double count_triangles(const PatchSurface& surface, const Vec2& a, const Vec2& b, const Vec2& c, int depth) {
  const double area = 0.5 * cross(b - a, c - a);
  double sum = 0, least = HUGE_VAL, most = 0;
  for (const Vec3& w : {Vec3{1, 1, 1} / 3, Vec3{0.6, 0.2, 0.2}, Vec3{0.2, 0.6, 0.2}, Vec3{0.2, 0.2, 0.6}}) {
    const PatchPlace place = surface.at_plane(w.x * a + w.y * b + w.z * c);
    const double here = density(place, surface.size_at(place.point));
    sum += here / 4;
    least = std::min(least, here);
    most = std::max(most, here);
  }
  constexpr double kFew = 50, kSpread = 1.2;
  if (depth == 0 || area * most < kFew || most < kSpread * least) return area * sum;
  const Vec2 ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
  return count_triangles(surface, a, ab, ca, depth - 1) + count_triangles(surface, ab, b, bc, depth - 1) +
         count_triangles(surface, ca, bc, c, depth - 1) + count_triangles(surface, ab, bc, ca, depth - 1);
}

double count_triangles(const PatchSurface& surface, const PatchVertex& a, const PatchVertex& b, const PatchVertex& c) {
  constexpr double kFew = 4;
  constexpr int kDepth = 4;
  const double mean = (density(a.place, a.size) + density(b.place, b.size) + density(c.place, c.size)) / 3;
  const double count = 0.5 * cross(b.place.plane - a.place.plane, c.place.plane - a.place.plane) * mean;
  if (count < kFew) return count;
  return count_triangles(surface, a.place.plane, b.place.plane, c.place.plane, kDepth);
}

// ---- chains -------------------------------------------------------------------------------------------------------

// The points that divide a straight line of the plane evenly in units of the size.
class ChainDivider {
 public:
  ChainDivider(const PatchSurface& surface, const PatchVertex& from, const PatchVertex& to)
      : surface_(surface), from_(from), to_(to) {}

  std::vector<PatchVertex> run() {
    constexpr int kDepth = 12;
    table_.push_back({0, 0});
    refine({0, from_.place, from_.size}, {1, to_.place, to_.size}, kDepth);
    const double total = table_.back().length;
    const auto count = static_cast<std::size_t>(std::max(1.0, std::round(total)));
    std::vector<PatchVertex> points;
    for (std::size_t i = 1; i < count; ++i)
      points.push_back(vertex_at(share_at(total * static_cast<double>(i) / static_cast<double>(count))));
    return points;
  }

 private:
  struct Sample {
    double share;
    PatchPlace place;
    double size;
  };
  struct Entry {
    double share, length;
  };

  PatchVertex vertex_at(double share) const {
    const Vec2 step = to_.place.plane - from_.place.plane;
    PatchVertex vertex;
    vertex.place = surface_.at_plane(from_.place.plane + share * step);
    vertex.size = surface_.size_at(vertex.place.point);
    return vertex;
  }

  // Lengths per unit of the share, in units of the size.
  double speed(const Sample& sample) const {
    const Vec2 step = to_.place.plane - from_.place.plane;
    return norm(step.u * sample.place.du + step.v * sample.place.dv) / sample.size;
  }

  void refine(const Sample& a, const Sample& b, int depth) {
    const PatchVertex middle = vertex_at(0.5 * (a.share + b.share));
    const Sample m{0.5 * (a.share + b.share), middle.place, middle.size};
    const double length = (speed(a) + 4 * speed(m) + speed(b)) * (b.share - a.share) / 6;
    if (length > 1 && depth > 0) {
      refine(a, m, depth - 1);
      refine(m, b, depth - 1);
      return;
    }
    table_.push_back({b.share, table_.back().length + length});
  }

  double share_at(double length) const {
    const auto above = std::ranges::upper_bound(table_, length, {}, &Entry::length);
    if (above == table_.end()) return 1;
    const Entry &b = *above, &a = *(above - 1);
    return a.share + (b.share - a.share) * (length - a.length) / (b.length - a.length);
  }

  const PatchSurface& surface_;
  const PatchVertex &from_, &to_;
  std::vector<Entry> table_;
};

// ---- the cut ------------------------------------------------------------------------------------------------------

class Cutter {
 public:
  Cutter(const Patch& coarse, const std::vector<std::uint32_t>& piece, std::size_t rim_count)
      : mesh_(coarse.topology), coarse_(coarse), piece_(piece) {
    cut_.vertices.assign(coarse.vertices.begin(), coarse.vertices.begin() + static_cast<std::ptrdiff_t>(rim_count));
    numbers_.assign(coarse.vertices.size(), kNone);
    for (std::uint32_t v = 0; v < rim_count; ++v) numbers_[v] = v;
  }

  FaceCut run(const PatchSurface& surface) {
    for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h)
      if (is_cut(h) && h < mesh_.twin(h)) divide(h, surface);
    cut_.pieces.resize(1 + *std::ranges::max_element(piece_));
    std::vector<std::vector<std::uint32_t>> outlines(cut_.pieces.size());  // half-edges
    for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h)
      if (is_cut(h) || mesh_.twin(h) == kNone || mesh_.fixed(h)) outlines[piece_[h / 3]].push_back(h);
    for (std::size_t p = 0; p < outlines.size(); ++p) outline(outlines[p], cut_.pieces[p]);
    classify();
    return std::move(cut_);
  }

 private:
  bool is_cut(std::uint32_t h) const {
    return mesh_.twin(h) != kNone && !mesh_.fixed(h) && piece_[h / 3] != piece_[mesh_.twin(h) / 3];
  }

  std::uint32_t number(std::uint32_t v) {
    if (numbers_[v] == kNone) {
      numbers_[v] = static_cast<std::uint32_t>(cut_.vertices.size());
      cut_.vertices.push_back(coarse_.vertices[v]);
    }
    return numbers_[v];
  }

  void divide(std::uint32_t h, const PatchSurface& surface) {
    const std::uint32_t a = mesh_.origin(h), b = mesh_.target(h);
    number(a), number(b);
    auto& chain = chains_[h];
    for (const PatchVertex& vertex : ChainDivider(surface, coarse_.vertices[a], coarse_.vertices[b]).run()) {
      chain.push_back(static_cast<std::uint32_t>(cut_.vertices.size()));
      cut_.vertices.push_back(vertex);
    }
  }

  void outline(const std::vector<std::uint32_t>& half_edges, FacePiece& piece) {
    std::map<std::uint32_t, std::uint32_t> local;
    const auto id = [&](std::uint32_t v) {
      const auto [at, is_new] = local.try_emplace(v, static_cast<std::uint32_t>(piece.vertices.size()));
      if (is_new) piece.vertices.push_back(v);
      return at->second;
    };
    for (const std::uint32_t h : half_edges) {
      std::vector<std::uint32_t> chain;
      if (is_cut(h)) {
        chain = chains_.at(std::min(h, mesh_.twin(h)));
        if (mesh_.twin(h) < h) std::ranges::reverse(chain);
      }
      std::uint32_t last = id(number(mesh_.origin(h)));
      chain.push_back(number(mesh_.target(h)));
      for (const std::uint32_t v : chain) {
        const std::uint32_t next = id(v);
        piece.segments.push_back({last, next});
        last = next;
      }
    }
  }

  void classify() {
    std::vector<std::vector<std::uint32_t>> meeting(cut_.vertices.size());
    for (std::uint32_t p = 0; p < cut_.pieces.size(); ++p)
      for (const std::uint32_t v : cut_.pieces[p].vertices) meeting[v].push_back(p);
    std::map<std::array<std::uint32_t, 2>, std::uint32_t> zones;
    cut_.kinds.resize(cut_.vertices.size());
    for (std::uint32_t v = 0; v < meeting.size(); ++v) {
      if (meeting[v].size() < 2) continue;
      if (meeting[v].size() == 2 && cut_.vertices[v].node == kNone) {
        const std::array pair{meeting[v][0], meeting[v][1]};
        cut_.kinds[v].zone = zones.try_emplace(pair, static_cast<std::uint32_t>(zones.size())).first->second;
        if (cut_.kinds[v].zone == cut_.zones.size()) cut_.zones.push_back(pair);
        continue;
      }
      cut_.kinds[v].junction = static_cast<std::uint32_t>(cut_.junctions.size());
      cut_.junctions.push_back(meeting[v]);
      cut_.junction_to_vertex.push_back(v);
    }
  }

  const Triangulation& mesh_;
  const Patch& coarse_;
  const std::vector<std::uint32_t>& piece_;                     // per coarse triangle
  std::vector<std::uint32_t> numbers_;                          // coarse vertex → vertex of the cut
  std::map<std::uint32_t, std::vector<std::uint32_t>> chains_;  // by the smaller half-edge
  FaceCut cut_;
};

}  // namespace

double estimate_triangles(const RimPatch& face, const PatchSurface& surface) {
  if (face.polygon.verdict != PolygonVerdict::Ok) return 0;
  double count = 0;
  const Triangulation& topology = face.polygon.triangulation;
  for (std::uint32_t tri = 0; tri < topology.slots(); ++tri) {
    const auto [a, b, c] = topology.triangle(tri);
    count += count_triangles(surface, face.vertices[a], face.vertices[b], face.vertices[c]);
  }
  return count;
}

std::optional<FaceCut> cut_face(const RimPatch& face, const PatchSurface& surface, double triangles,
                                const std::function<bool()>& keep_going) {
  const auto wanted = static_cast<std::uint32_t>(std::min(1e6, std::round(triangles / kTrianglesPerPiece)));
  if (wanted < 2 || face.polygon.verdict != PolygonVerdict::Ok) return {};
  Patch coarse{face.polygon.triangulation, face.vertices, face.rim.repeats_nodes};
  refine_frontal(coarse, surface, keep_going, {.factor = kCoarsening});
  if (!keep_going()) return {};
  coarse.topology.compact();
  for (PatchVertex& vertex : coarse.vertices) vertex.size = surface.size_at(vertex.place.point);
  std::vector<double> weights(coarse.topology.slots());
  for (std::uint32_t tri = 0; tri < weights.size(); ++tri) {
    const auto [a, b, c] = coarse.topology.triangle(tri);
    weights[tri] = count_triangles(surface, coarse.vertices[a], coarse.vertices[b], coarse.vertices[c]);
  }
  const std::vector<std::uint32_t> pieces = share_triangles(coarse, weights, wanted);
  FaceCut cut = Cutter(coarse, pieces, face.vertices.size()).run(surface);
  if (cut.pieces.size() < 2) return {};
  cut.scale = face.scale;
  cut.has_poles = face.rim.repeats_nodes;
  return cut;
}

std::optional<FaceCut> cut_large_face(const GeometricModel& model, ModelFaceId face,
                                      const FaceSurroundings& surroundings, const std::function<bool()>& keep_going) {
  constexpr double kLeast = 1.5 * kTrianglesPerPiece;
  const SizeField& sizes = surroundings.sizes;
  const auto triangles_at = [&](double size) { return model.area(face) * kTrianglesPerSquare / (size * size); };
  if (triangles_at(sizes.smallest()) < kLeast) return {};
  const auto geometry = model.face_geometry(face);
  if (geometry->parametrization() != Parametrization::Smooth) return {};
  const RimPatch rim = make_rim_patch(model.topology(), face, *geometry, surroundings.rim, sizes);
  const PatchSurface surface(*geometry, sizes, rim.scale);
  const double triangles = sizes.is_uniform() ? triangles_at(sizes.largest()) : estimate_triangles(rim, surface);
  return triangles < kLeast ? std::nullopt : cut_face(rim, surface, triangles, keep_going);
}

}  // namespace tetloom
