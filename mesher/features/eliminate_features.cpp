#include "mesher/features/eliminate_features.hpp"

#include <algorithm>
#include <memory>
#include <tuple>

#include "core/base/lists.hpp"
#include "core/spatial/bvh.hpp"
#include "mesher/features/shape_check.hpp"

namespace tetloom {
namespace {

using namespace features;

std::vector<std::uint32_t> find_small_triangles(const Mesh& mesh, const FeatureElimination& how,
                                                const TaskRunner& runner) {
  constexpr std::size_t kBlock = std::size_t{1} << 14;
  const std::size_t count = mesh.tri_to_vert.size();
  std::vector<std::vector<std::uint32_t>> found((count + kBlock - 1) / kBlock);
  runner.for_blocks(count, kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      const auto& [a, b, c] = mesh.tri_to_vert[t];
      const double tolerance = (how.tolerances[a] + how.tolerances[b] + how.tolerances[c]) / 3;
      if (least_height(mesh.points[a], mesh.points[b], mesh.points[c]) < 1.001 * tolerance)
        found[begin / kBlock].push_back(static_cast<std::uint32_t>(t));
    }
  });
  return joined(found);
}

/// The balls in which nothing is eliminated, to be asked for a place.
class KeptPlaces {
 public:
  KeptPlaces(std::span<const KeptPlace> places, const TaskRunner& runner) : places_(places) {
    std::vector<Box3> boxes;
    for (const auto& [center, radius] : places) {
      const Vec3 reach{radius, radius, radius};
      Box3& box = boxes.emplace_back();
      box.add(center - reach);
      box.add(center + reach);
    }
    bvh_ = build_bvh(boxes, runner);
  }
  bool has(const Vec3& x) const {
    Box3 box;
    box.add(x);
    return any_near(bvh_, box, [&](std::uint32_t i) { return distance(places_[i].center, x) <= places_[i].radius; });
  }

 private:
  std::span<const KeptPlace> places_;
  Bvh bvh_;
};

/// What the zones of a mesh become, put together to a mesh.
class ZoneAssembly {
 public:
  ZoneAssembly(const Mesh& mesh, const Zones& zones, std::span<const ZoneChange* const> changes)
      : mesh_(mesh), zones_(zones), changes_(changes) {}

  EliminationResult run() {
    for (const ZoneChange* change : changes_) {
      result_.collapses += change->collapses;
      result_.snaps += change->snaps;
    }
    if (result_.collapses + result_.snaps == 0) return {};
    Mesh& made = result_.mesh.emplace();
    made.face_to_sides = mesh_.face_to_sides;
    made.entities = mesh_.entities;
    put_points(made);
    put_triangles(made);
    put_pieces(made);
    find_absorbed(made);
    return std::move(result_);
  }

 private:
  void put_points(Mesh& made) {
    made.points = mesh_.points;
    made.point_to_entity = mesh_.point_to_entity;
    std::vector<std::uint8_t> is_gone(mesh_.points.size(), 0), is_touched(mesh_.points.size(), 0);
    for (std::size_t z = 0; z < changes_.size(); ++z) {
      const ZoneChange& change = *changes_[z];
      for (std::size_t i = 0; i < change.items.points.size(); ++i) {
        const std::uint32_t v = zones_.items[z].points[i];
        made.points[v] = change.items.points[i];
        made.point_to_entity[v] = change.items.point_to_entity[i];
        is_gone[v] = change.is_gone[i];
        is_touched[v] = change.is_touched[i];
      }
    }
    new_ids_.assign(mesh_.points.size(), kNone);
    std::uint32_t next = 0;
    for (std::uint32_t v = 0; v < new_ids_.size(); ++v) {
      if (is_gone[v]) continue;
      if (is_touched[v]) result_.changed.push_back(next);
      made.points[next] = made.points[v];
      made.point_to_entity[next] = made.point_to_entity[v];
      new_ids_[v] = next++;
    }
    made.points.resize(next);
    made.point_to_entity.resize(next);
  }

  // Items of zones stand where those were of which they come; `put` takes the points of one, and its entity.
  template <class Items, class Put>
  void put_items(const Items& verts, const std::vector<std::uint32_t>& entities,
                 const std::vector<std::uint32_t>& item_to_zone, const auto& of_change, const Put& put) const {
    struct Next {
      std::uint32_t given = 0;  // item of the zone
      std::size_t made = 0;     // item of what it becomes
    };
    std::vector<Next> next(changes_.size());
    for (std::size_t i = 0; i < verts.size(); ++i) {
      const std::uint32_t zone = item_to_zone[i];
      auto now = verts[i];
      if (zone == kNone || changes_[zone]->is_empty()) {
        for (std::uint32_t& v : now) v = new_ids_[v];
        put(now, entities[i]);
        continue;
      }
      const auto& [made, made_entities, sources] = of_change(*changes_[zone]);
      const std::uint32_t given = next[zone].given++;
      for (std::size_t& k = next[zone].made; k < made.size() && sources[k] == given; ++k) {
        now = made[k];
        for (std::uint32_t& v : now) v = new_ids_[zones_.items[zone].points[v]];
        put(now, made_entities[k]);
      }
    }
  }

  void put_triangles(Mesh& made) const {
    const auto of_change = [](const ZoneChange& change) {
      return std::tie(change.items.triangles, change.items.tri_to_face, change.tri_source);
    };
    put_items(mesh_.tri_to_vert, mesh_.tri_to_entity, zones_.tri_to_zone, of_change,
              [&](const Triangle& verts, std::uint32_t face) {
                made.tri_to_vert.push_back(verts);
                made.tri_to_entity.push_back(face);
              });
  }

  void put_pieces(Mesh& made) const {
    const auto of_change = [](const ZoneChange& change) {
      return std::tie(change.items.pieces, change.items.piece_to_edge, change.piece_source);
    };
    put_items(mesh_.edge_to_vert, mesh_.edge_to_entity, zones_.piece_to_zone, of_change,
              [&](const Piece& verts, std::uint32_t edge) {
                made.edge_to_vert.push_back(verts);
                made.edge_to_entity.push_back(edge);
              });
  }

  // What the given mesh had something of, and the new one has not; found by the first of its points.
  void find_absorbed(const Mesh& made) {
    const std::array<std::vector<std::uint32_t>, 3> had = first_points(mesh_), has = first_points(made);
    for (std::size_t dim = 0; dim < 3; ++dim)
      for (std::uint32_t i = 0; i < had[dim].size(); ++i)
        if (had[dim][i] != kNone && (i >= has[dim].size() || has[dim][i] == kNone))
          add_absorbed({static_cast<int>(dim), i}, had[dim][i]);
  }

  // Of every model vertex, edge and face of which a mesh has something.
  static std::array<std::vector<std::uint32_t>, 3> first_points(const Mesh& mesh) {
    std::array<std::vector<std::uint32_t>, 3> first;
    const auto note = [](std::uint32_t index, std::uint32_t point, std::vector<std::uint32_t>& list) {
      if (list.size() <= index) list.resize(index + 1, kNone);
      if (list[index] == kNone) list[index] = point;
    };
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v)
      if (mesh.point_to_entity[v].dim == 0) note(mesh.point_to_entity[v].index, v, first[0]);
    for (std::size_t p = 0; p < mesh.edge_to_vert.size(); ++p)
      note(mesh.edge_to_entity[p], mesh.edge_to_vert[p][0], first[1]);
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
      note(mesh.tri_to_entity[t], mesh.tri_to_vert[t][0], first[2]);
    return first;
  }

  void add_absorbed(ModelEntity entity, std::uint32_t point) {
    const ZoneChange& change = *changes_[zones_.point_to_zone[point]];
    const std::uint32_t now = change.now[zones_.point_in_zone[point]];
    result_.absorbed.push_back({entity, change.items.point_to_entity[now], change.moved[now]});
  }

  const Mesh& mesh_;
  const Zones& zones_;
  std::span<const ZoneChange* const> changes_;
  std::vector<std::uint32_t> new_ids_;  // per point of the given mesh
  EliminationResult result_;
};

}  // namespace

EliminationResult eliminate_small_features(const Mesh& mesh, const FeatureElimination& how, const TaskRunner& runner,
                                           KnownZones* known) {
  const std::vector<std::uint32_t> small = find_small_triangles(mesh, how, runner);
  if (small.empty()) return {};
  const Zones zones = find_zones(mesh, small);
  const KeptPlaces kept(how.kept, runner);
  const auto take_zone = [&](std::size_t z) {
    const ZoneItems& numbers = zones.items[z];
    Zone zone{take_items(mesh, numbers, zones.point_in_zone), {}, {}, {}, {}};
    for (const std::uint32_t v : numbers.points) {
      zone.tolerances.push_back(how.tolerances[v]);
      zone.sizes.push_back(how.sizes[v]);
      zone.is_locked.push_back(zones.is_near_border[v] || kept.has(mesh.points[v]));
    }
    for (std::uint32_t i = 0; i < numbers.triangles.size(); ++i)
      if (std::ranges::binary_search(small, numbers.triangles[i])) zone.small.push_back(i);
    return zone;
  };
  KnownZones none;
  KnownZones& before = known ? *known : none;
  std::vector<std::shared_ptr<const KnownZone>> done(zones.items.size());
  std::vector<double> work;
  for (const ZoneItems& items : zones.items) work.push_back(static_cast<double>(items.triangles.size()));
  runner.for_each_largest_first(work, [&](std::size_t z) {
    Zone zone = take_zone(z);
    done[z] = before.find(zone);
    if (done[z]) return;
    ZoneChange change = eliminate_in_zone(zone, mesh.face_to_sides, runner);
    done[z] = std::make_shared<const KnownZone>(std::move(zone), std::move(change));
  });
  before = KnownZones(done);
  std::vector<const ZoneChange*> changes;
  for (const auto& zone : done) changes.push_back(&zone->change);
  return ZoneAssembly(mesh, zones, changes).run();
}

}  // namespace tetloom
