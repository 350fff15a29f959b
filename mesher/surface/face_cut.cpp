#include "mesher/surface/face_cut.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/triangle_sharing.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

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

  /// `divide_all`: for pairs of coarse vertices, the points between them.
  template <class DivideAll>
  FaceCut run(const DivideAll& divide_all) {
    std::vector<std::uint32_t> edges;  // by the smaller half-edge
    std::vector<std::array<const PatchVertex*, 2>> ends;
    for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h) {
      if (!is_cut(h) || mesh_.twin(h) < h) continue;
      edges.push_back(h);
      ends.push_back({&coarse_.vertices[mesh_.origin(h)], &coarse_.vertices[mesh_.target(h)]});
    }
    const std::vector<std::vector<PatchVertex>> chains = divide_all(ends);
    for (std::size_t i = 0; i < edges.size(); ++i) add_chain(edges[i], chains[i]);
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

  void add_chain(std::uint32_t h, const std::vector<PatchVertex>& points) {
    number(mesh_.origin(h)), number(mesh_.target(h));
    auto& chain = chains_[h];
    for (const PatchVertex& vertex : points) {
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

namespace {

/// A face that is worth cutting.
class LargeFace {
 public:
  LargeFace(const GeometricModel& model, ModelFaceId face, const SizeField& sizes, const RimPatch& rim,
            const TaskRunner& runner)
      : model_(model), face_(face), sizes_(sizes), rim_(rim), runner_(runner) {}

  std::optional<FaceCut> cut(const PatchSurface& surface, double triangles) const {
    const auto wanted = static_cast<std::uint32_t>(std::min(1e6, std::round(triangles / kTrianglesPerPiece)));
    if (wanted < 2) return {};
    Patch coarse{rim_.polygon.triangulation, rim_.vertices, rim_.rim.repeats_nodes};
    refine_frontal(coarse, surface, [&] { return !runner_.cancelled(); }, {.factor = kCoarsening});
    runner_.check_cancelled();
    coarse.topology.compact();
    for (PatchVertex& vertex : coarse.vertices) vertex.size = surface.size_at(vertex.place.point);
    const std::vector<std::uint32_t> pieces = share_triangles(coarse, weigh(coarse), wanted);
    FaceCut cut = Cutter(coarse, pieces, rim_.vertices.size()).run([&](const auto& ends) { return divide(ends); });
    if (cut.pieces.size() < 2) return {};
    cut.scale = rim_.scale;
    cut.has_poles = rim_.rim.repeats_nodes;
    return cut;
  }

 private:
  // Calls body(i, surface) for 0 <= i < count, with a surface for every block.
  template <class Body>
  void for_each(std::size_t count, const Body& body) const {
    constexpr std::size_t kBlock = 256;
    runner_.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
      const auto geometry = model_.face_geometry(face_);
      const PatchSurface surface(*geometry, sizes_, rim_.scale);
      for (std::size_t i = begin; i < end; ++i) body(i, surface);
    });
  }

  std::vector<double> weigh(const Patch& coarse) const {
    std::vector<double> weights(coarse.topology.slots());
    for_each(weights.size(), [&](std::size_t tri, const PatchSurface& surface) {
      const auto [a, b, c] = coarse.topology.triangle(static_cast<std::uint32_t>(tri));
      weights[tri] = count_triangles(surface, coarse.vertices[a], coarse.vertices[b], coarse.vertices[c]);
    });
    return weights;
  }

  std::vector<std::vector<PatchVertex>> divide(const std::vector<std::array<const PatchVertex*, 2>>& ends) const {
    std::vector<std::vector<PatchVertex>> chains(ends.size());
    for_each(ends.size(), [&](std::size_t i, const PatchSurface& surface) {
      chains[i] = ChainDivider(surface, *ends[i][0], *ends[i][1]).run();
    });
    return chains;
  }

  const GeometricModel& model_;
  ModelFaceId face_;
  const SizeField& sizes_;
  const RimPatch& rim_;
  const TaskRunner& runner_;
};

}  // namespace

std::optional<FaceCut> cut_large_face(const GeometricModel& model, ModelFaceId face,
                                      const FaceSurroundings& surroundings, const TaskRunner& runner) {
  constexpr double kLeast = 1.5 * kTrianglesPerPiece;
  const SizeField& sizes = surroundings.sizes;
  const auto triangles_at = [&](double size) { return model.area(face) * kTrianglesPerSquare / (size * size); };
  if (triangles_at(sizes.smallest()) < kLeast) return {};
  const auto geometry = model.face_geometry(face);
  if (geometry->parametrization() != Parametrization::Smooth) return {};
  const RimPatch rim = make_rim_patch(model.topology(), face, *geometry, surroundings.rim, sizes);
  if (rim.polygon.verdict != PolygonVerdict::Ok) return {};
  const PatchSurface surface(*geometry, sizes, rim.scale);
  const double triangles = sizes.is_uniform() ? triangles_at(sizes.largest()) : estimate_triangles(rim, surface);
  if (triangles < kLeast) return {};
  return LargeFace(model, face, sizes, rim, runner).cut(surface, triangles);
}

}  // namespace tetloom
