#include "mesher/layers/layered_mesh.hpp"

#include <algorithm>
#include <array>
#include <new>

#include "core/base/grain.hpp"
#include "core/base/page_size.hpp"
#include "mesher/layers/point_numbers.hpp"
#include "mesher/layers/stack_elements.hpp"

namespace tetloom::layers {
namespace {

constexpr std::size_t kElements = 1u << 16;  // elements of one task

using CellCounts = std::array<std::size_t, kCellKinds>;

template <std::size_t N>
constexpr std::size_t kKind = static_cast<std::size_t>(kind_of_cell(N));

class Assembly {
 public:
  Assembly(const LayerGrowth& growth, const Mesh& given, Mesh&& filled, bool all_tets, const TaskRunner& runner)
      : growth_(growth),
        walls_(growth.walls()),
        mesh_(std::move(filled)),
        numbers_(growth, mesh_.points.size()),
        all_tets_(all_tets),
        runner_(runner) {
    mesh_.entities = given.entities;
    mesh_.face_to_sides = given.face_to_sides;
  }

  Mesh run() {
    drop_unused_points();
    drop_tops();
    add_level_points();
    add_edges();
    add_cells();
    add_sides();
    return std::move(mesh_);
  }

 private:
  void drop_unused_points() {
    if (numbers_.dropped() == 0) return;
    std::size_t kept = 0;
    for (std::size_t v = 0; v < mesh_.points.size(); ++v) {
      if (!numbers_.is_used(v)) continue;
      mesh_.points[kept] = mesh_.points[v];
      mesh_.point_to_entity[kept++] = mesh_.point_to_entity[v];
    }
    mesh_.points.resize(kept);
    mesh_.point_to_entity.resize(kept);
    renumber(mesh_.edge_to_vert), renumber(mesh_.tri_to_vert), renumber(mesh_.tet_to_vert);
  }

  template <class Element>
  void renumber(std::vector<Element>& elements) const {
    runner_.for_blocks(elements.size(), kElements, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::uint32_t& v : elements[i]) v = static_cast<std::uint32_t>(numbers_.in_mesh(v));
    });
  }

  // The model's surface is what is left, and the walls below the layers.
  void drop_tops() {
    const LayeredSurface& surface = growth_.surface();
    std::size_t kept = 0;
    for (std::size_t t = 0; t < surface.is_top.size(); ++t) {
      if (surface.is_top[t]) continue;
      mesh_.tri_to_vert[kept] = mesh_.tri_to_vert[t];
      mesh_.tri_to_entity[kept++] = mesh_.tri_to_entity[t];
    }
    mesh_.tri_to_vert.resize(kept);
    mesh_.tri_to_entity.resize(kept);
    for (std::array<std::uint32_t, 3> verts : surface.covered) {
      for (std::uint32_t& v : verts) v = static_cast<std::uint32_t>(numbers_.in_mesh(v));
      mesh_.tri_to_vert.push_back(verts);
    }
    mesh_.tri_to_entity.insert(mesh_.tri_to_entity.end(), surface.covered_to_entity.begin(),
                               surface.covered_to_entity.end());
  }

  std::uint32_t number(const CurveLevel& at) const {
    return static_cast<std::uint32_t>(numbers_.in_mesh(numbers_.made(at)));
  }

  StackVertices vertices_of(std::uint32_t stack) const {
    return {growth_, stack, numbers_.apex_in_mesh(stack),
            [&](std::uint32_t curve) { return numbers_.curve_in_mesh(curve); }};
  }

  template <class T>
  void make_room(std::vector<T>& items, std::size_t count) const {
    reserve_touched(items, count, runner_);
    items.resize(count);
  }

  void add_level_points() {
    const auto all = static_cast<std::size_t>(numbers_.in_mesh(numbers_.count()));
    if (all >= kNone) throw std::bad_alloc();
    make_room(mesh_.points, all);
    make_room(mesh_.point_to_entity, all);
    runner_.for_blocks(walls_.curve_count(), kElementGrain, [&](std::size_t begin, std::size_t end) {
      for (auto c = static_cast<std::uint32_t>(begin); c < end; ++c)
        for (int level = 1; level < growth_.counts().count(c); ++level) {
          const std::uint32_t v = number({c, level});
          mesh_.points[v] = growth_.counts().point(c, level);
          mesh_.point_to_entity[v] = growth_.sides().entity_of(c);
        }
    });
  }

  void add_edges() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c)
      for_each_layer_edge(growth_, c, [&](const CurveLevel& lower, const CurveLevel& upper) {
        mesh_.edge_to_vert.push_back({number(lower), number(upper)});
        mesh_.edge_to_entity.push_back(growth_.sides().entity_of(c).index);
      });
  }

  // Counted first, then written side by side, each block of stacks to its own places.
  void add_cells() {
    const std::vector<CellCounts> counts = map_blocks<CellCounts>(
        runner_, walls_.stack_count(), kElementGrain, {}, [&](std::size_t begin, std::size_t end, CellCounts& count) {
          for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s)
            for_each_stack_cell(growth_, s, all_tets_, [&](const auto& verts, int) {
              ++count[kKind<std::tuple_size_v<std::decay_t<decltype(verts)>>>];
            });
        });
    std::vector<CellCounts> first{{mesh_.tet_to_vert.size(), 0, 0, 0}};
    for (const CellCounts& count : counts) {
      first.push_back(first.back());
      for (std::size_t kind = 0; kind < kCellKinds; ++kind) first.back()[kind] += count[kind];
    }
    make_cells(first.back());
    runner_.for_blocks(walls_.stack_count(), kElementGrain, [&](std::size_t begin, std::size_t end) {
      write_cells(begin, end, first[begin / kElementGrain]);
    });
  }

  void make_cells(const CellCounts& counts) {
    make_room(mesh_.tet_to_vert, counts[0]), make_room(mesh_.tet_to_entity, counts[0]);
    make_room(mesh_.pyramid_to_vert, counts[1]), make_room(mesh_.pyramid_to_entity, counts[1]);
    make_room(mesh_.prism_to_vert, counts[2]), make_room(mesh_.prism_to_entity, counts[2]);
    make_room(mesh_.hex_to_vert, counts[3]), make_room(mesh_.hex_to_entity, counts[3]);
    for (std::size_t kind = 1; kind < kCellKinds; ++kind)
      cells_before_[kind] = cells_before_[kind - 1] + counts[kind - 1];
    for (const std::string_view name : {kLayerField, kHeightField, kStackField}) {
      MeshField& field = mesh_.cell_fields.emplace_back(MeshField{std::string(name), 1, {}});
      make_room(field.values, cells_before_.back() + counts.back());
    }
  }

  void write_cells(std::size_t begin, std::size_t end, CellCounts next) {
    const auto fields = std::span(mesh_.cell_fields).last(3);
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s) {
      const StackVertices vertices = vertices_of(s);
      int last = 0;
      double height = 0;
      for_each_stack_cell(growth_, s, all_tets_, [&](const auto& places, int layer) {
        constexpr std::size_t kKindOfThis = kKind<std::tuple_size_v<std::decay_t<decltype(places)>>>;
        if (layer != last) height = height_of_layer(growth_, s, layer);
        last = layer;
        const std::size_t cell = next[kKindOfThis]++, value = cells_before_[kKindOfThis] + cell;
        put(vertices.at(places), walls_.wall_of(s).region, cell);
        fields[0].values[value] = layer;
        fields[1].values[value] = height;
        fields[2].values[value] = static_cast<double>(s + 1);
      });
    }
  }

  void put(const std::array<std::uint32_t, 4>& tet, std::uint32_t region, std::size_t cell) {
    mesh_.tet_to_vert[cell] = tet, mesh_.tet_to_entity[cell] = region;
  }
  void put(const std::array<std::uint32_t, 5>& pyramid, std::uint32_t region, std::size_t cell) {
    mesh_.pyramid_to_vert[cell] = pyramid, mesh_.pyramid_to_entity[cell] = region;
  }
  void put(const std::array<std::uint32_t, 6>& prism, std::uint32_t region, std::size_t cell) {
    mesh_.prism_to_vert[cell] = prism, mesh_.prism_to_entity[cell] = region;
  }
  void put(const std::array<std::uint32_t, 8>& hex, std::uint32_t region, std::size_t cell) {
    mesh_.hex_to_vert[cell] = hex, mesh_.hex_to_entity[cell] = region;
  }

  // Quadrilaterals and triangles of layers on side faces.
  void add_sides() {
    for (const WallRim& rim : walls_.rims) {
      const StackVertices vertices = vertices_of(rim.wall);
      for_each_side_element(growth_, rim, all_tets_,
                            [&](const auto& places) { add_on_face(vertices.at(places), rim.side_face); });
    }
  }
  void add_on_face(const std::array<std::uint32_t, 3>& triangle, std::uint32_t face) {
    mesh_.tri_to_vert.push_back(triangle), mesh_.tri_to_entity.push_back(face);
  }
  void add_on_face(const std::array<std::uint32_t, 4>& quad, std::uint32_t face) {
    mesh_.quad_to_vert.push_back(quad), mesh_.quad_to_entity.push_back(face);
  }

  const LayerGrowth& growth_;
  const Walls& walls_;
  Mesh mesh_;
  const PointNumbers numbers_;
  const bool all_tets_;
  const TaskRunner& runner_;
  std::array<std::size_t, kCellKinds> cells_before_{};  // in fields, of kinds that come first
};

}  // namespace

Mesh make_layered_mesh(const LayerGrowth& growth, const Mesh& given, Mesh&& filled, bool all_tets,
                       const TaskRunner& runner) {
  runner.check_cancelled();
  return Assembly(growth, given, std::move(filled), all_tets, runner).run();
}

}  // namespace tetloom::layers
