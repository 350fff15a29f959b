#include "mesher/layers/layered_parts.hpp"

#include <algorithm>
#include <array>

#include "core/base/lists.hpp"
#include "mesher/layers/stack_elements.hpp"

namespace tetloom::layers {
namespace {

constexpr std::array<std::string_view, 3> kFields{kLayerField, kHeightField, kStackField};

// The vertices of a part that have been made with a number below that of level points, by that number.
class KnownVertices {
 public:
  KnownVertices(const PartMesh& part, std::uint64_t end) {
    for (std::uint32_t v = 0; v < part.vertex_count(); ++v)
      if (part.vert_to_global[v] < end) known_.emplace_back(part.vert_to_global[v], v);
    std::ranges::sort(known_);
  }
  std::uint32_t find(std::uint64_t made) const {
    const auto at = std::ranges::lower_bound(known_, made, {}, [](const auto& known) { return known.first; });
    return at != known_.end() && at->first == made ? at->second : kNone;
  }

 private:
  std::vector<std::pair<std::uint64_t, std::uint32_t>> known_;
};

// The local vertices of curves in one part.
class PartCurves {
 public:
  PartCurves(const LayerGrowth& growth, const PointNumbers& numbers, std::span<const std::uint32_t> stacks)
      : growth_(growth), numbers_(numbers) {
    for (const std::uint32_t stack : stacks) {
      const auto more = growth.walls().curves_of(stack);
      curves_.insert(curves_.end(), more.begin(), more.end());
      if (const std::uint32_t apex = numbers.made_apex(stack); apex != kNone) apexes_.push_back({stack, apex});
    }
    sort_unique(curves_);
  }

  std::span<const std::uint32_t> curves() const { return curves_; }

  /// Adds what the part does not have: feet, tops and apexes by their numbers, then points between them, curve by
  /// curve.
  void add_vertices(PartMesh& part) {
    add_ends(part);
    const KnownVertices known(part, numbers_.surface_points());
    for (const std::uint32_t c : curves_) {
      const int count = growth_.counts().count(c);
      CurveVertices& vertices = vertices_.emplace_back();
      vertices.foot = known.find(numbers_.made({c, 0}));
      vertices.top = known.find(numbers_.made({c, count}));
      vertices.first_level = static_cast<std::uint32_t>(part.vertex_count());
      for (int level = 1; level < count; ++level)
        add(numbers_.made({c, level}), growth_.counts().point(c, level), part);
    }
    for (auto& [stack, apex] : apexes_) apex = known.find(apex);
  }

  /// Pre: the curve is one of these, and `add_vertices` has been called.
  const CurveVertices& vertices_of(std::uint32_t curve) const {
    return vertices_[static_cast<std::size_t>(std::ranges::lower_bound(curves_, curve) - curves_.begin())];
  }
  /// The apex of one of the stacks, or none.
  std::uint32_t apex_of(std::uint32_t stack) const {
    const auto found = std::ranges::lower_bound(apexes_, stack, {}, &Apex::stack);
    return found != apexes_.end() && found->stack == stack ? found->vertex : kNone;
  }

 private:
  struct Apex {
    std::uint32_t stack, vertex;  // at first the number as it was made
  };

  void add_ends(PartMesh& part) const {
    const KnownVertices known(part, numbers_.surface_points());
    std::vector<std::uint64_t> missing;
    for (const std::uint32_t c : curves_)
      for (const int level : {0, growth_.counts().count(c)})
        if (const std::uint64_t made = numbers_.made({c, level}); known.find(made) == kNone) missing.push_back(made);
    for (const auto& [stack, apex] : apexes_)
      if (known.find(apex) == kNone) missing.push_back(apex);
    sort_unique(missing);
    for (const std::uint64_t made : missing) add(made, growth_.surface().mesh.points[made], part);
  }

  static void add(std::uint64_t made, const Vec3& point, PartMesh& part) {
    part.points.push_back(point);
    part.vert_to_global.push_back(made);
  }

  const LayerGrowth& growth_;
  const PointNumbers& numbers_;
  std::vector<std::uint32_t> curves_;  // ascending
  std::vector<CurveVertices> vertices_;
  std::vector<Apex> apexes_;  // ascending by stack
};

std::array<std::uint32_t, 3> key_of(std::array<std::uint32_t, 3> verts) {
  std::ranges::sort(verts);
  return verts;
}

// A wall triangle is there already where the part has tets on its other side.
std::vector<std::array<std::uint32_t, 3>> triangle_keys(const PartMesh& part) {
  const auto& verts = part.block(BoundaryKind::Triangle).to_vert;
  std::vector<std::array<std::uint32_t, 3>> keys;
  for (std::size_t i = 0; i < verts.size(); i += 3) keys.push_back(key_of({verts[i], verts[i + 1], verts[i + 2]}));
  std::ranges::sort(keys);
  return keys;
}

template <std::size_t N>
void append(const std::array<std::uint32_t, N>& verts, std::uint32_t entity, BoundaryBlock& block) {
  block.to_vert.append(std::span<const std::uint32_t>(verts));
  block.to_entity.push_back(entity);
}

// Adds the elements of one stack after the other to a part.
class StackWriter {
 public:
  StackWriter(const LayerGrowth& growth, const PartCurves& curves, bool all_tets, PartMesh& part)
      : growth_(growth), curves_(curves), all_tets_(all_tets), part_(part), known_(triangle_keys(part)) {
    for (const std::string_view name : kFields) part.cell_fields.push_back({std::string(name), 1, {}});
    fields_ = std::span(part.cell_fields).last(kFields.size());
    for (CellField& field : fields_) field.values[0].resize(part.block(CellKind::Tet).size(), 0);
  }

  void add_cells(std::uint32_t stack) {
    const StackVertices vertices = vertices_of(stack);
    const std::uint32_t region = growth_.walls().wall_of(stack).region;
    for_each_stack_cell(growth_, stack, all_tets_, [&](const auto& places, int layer) {
      const CellKind kind = kind_of_cell(places.size());
      part_.block(kind).to_vert.append(std::span<const std::uint32_t>(vertices.at(places)));
      part_.block(kind).to_region.push_back(region);
      const std::array<double, kFields.size()> values{static_cast<double>(layer),
                                                      height_of_layer(growth_, stack, layer), stack + 1.0};
      for (std::size_t f = 0; f < values.size(); ++f)
        fields_[f].values[static_cast<std::size_t>(kind)].push_back(values[f]);
    });
  }

  void add_foot(std::uint32_t wall) {
    const WallTriangle& triangle = growth_.walls().triangles[wall];
    std::array<std::uint32_t, 3> foot;
    for (std::size_t i = 0; i < 3; ++i) foot[i] = curves_.vertices_of(triangle.curves[i]).foot;
    if (!triangle.is_front) std::swap(foot[1], foot[2]);
    if (std::ranges::binary_search(known_, key_of(foot))) return;
    append(foot, growth_.given().tri_to_entity[triangle.triangle], part_.block(BoundaryKind::Triangle));
  }

  void add_side(const WallRim& rim) {
    const StackVertices vertices = vertices_of(rim.wall);
    for_each_side_element(growth_, rim, all_tets_, [&](const auto& places) {
      append(vertices.at(places), rim.side_face,
             part_.block(places.size() == 3 ? BoundaryKind::Triangle : BoundaryKind::Quad));
    });
  }

 private:
  StackVertices vertices_of(std::uint32_t stack) const {
    return {growth_, stack, curves_.apex_of(stack), [&](std::uint32_t curve) { return curves_.vertices_of(curve); }};
  }

  const LayerGrowth& growth_;
  const PartCurves& curves_;
  const bool all_tets_;
  PartMesh& part_;
  const std::vector<std::array<std::uint32_t, 3>> known_;
  std::span<CellField> fields_;
};

}  // namespace

PartLayers::PartLayers(const LayerGrowth& growth, std::uint64_t after_volume, bool all_tets)
    : growth_(growth), numbers_(growth, after_volume), all_tets_(all_tets) {
  const auto& rims = growth.walls().rims;
  rims_.resize(rims.size());
  for (std::uint32_t r = 0; r < rims.size(); ++r) rims_[r] = r;
  std::ranges::stable_sort(rims_, {}, [&](std::uint32_t r) { return rims[r].wall; });
  wall_to_rim_.assign(growth.walls().triangles.size() + 1, 0);
  for (const WallRim& rim : rims) ++wall_to_rim_[rim.wall + 1];
  for (std::size_t w = 1; w < wall_to_rim_.size(); ++w) wall_to_rim_[w] += wall_to_rim_[w - 1];
}

std::vector<std::uint32_t> PartLayers::take_tops(PartMesh& part) const {
  BoundaryBlock& block = part.block(BoundaryKind::Triangle);
  std::vector<std::uint32_t> stacks;
  std::size_t kept = 0;
  for (std::size_t t = 0; t < block.size(); ++t) {
    const std::uint32_t triangle = block.to_entity[t];
    if (growth_.surface().is_top[triangle]) {
      if (is_first_of_stack(triangle)) stacks.push_back(growth_.surface().tri_to_stack[triangle]);
      continue;
    }
    for (std::size_t i = 0; i < 3; ++i) block.to_vert[3 * kept + i] = block.to_vert[3 * t + i];
    block.to_entity[kept++] = triangle;
  }
  block.to_vert.resize(3 * kept);
  block.to_entity.resize(kept);
  std::ranges::sort(stacks);
  return stacks;
}

// A stack of several tops goes where the tet on the first one is.
bool PartLayers::is_first_of_stack(std::uint32_t triangle) const {
  const auto& tri_to_stack = growth_.surface().tri_to_stack;
  return triangle == 0 || tri_to_stack[triangle - 1] != tri_to_stack[triangle];
}

void PartLayers::add_stacks(std::span<const std::uint32_t> stacks, PartMesh& part) const {
  const Walls& walls = growth_.walls();
  PartCurves curves(growth_, numbers_, stacks);
  curves.add_vertices(part);
  StackWriter writer(growth_, curves, all_tets_, part);
  for (std::size_t i = 0; i < stacks.size(); ++i) {
    writer.add_cells(stacks[i]);
    if (walls.is_fan(stacks[i])) continue;
    // The stack on the other side of a wall has the same foot.
    const bool is_twin = i > 0 && walls.triangles[stacks[i - 1]].triangle == walls.triangles[stacks[i]].triangle;
    if (!is_twin) writer.add_foot(stacks[i]);
    for (std::uint32_t r = wall_to_rim_[stacks[i]]; r < wall_to_rim_[stacks[i] + 1]; ++r)
      writer.add_side(walls.rims[rims_[r]]);
  }
}

ModelEntity PartLayers::entity_of(std::uint64_t made) const {
  if (made < numbers_.first_level_point()) return {};
  return growth_.sides().entity_of(numbers_.curve_of(made));
}

void PartLayers::add_edges(std::span<const std::uint32_t> stacks, PartMesh& part) const {
  PartCurves curves(growth_, numbers_, stacks);
  const KnownVertices known(part, numbers_.count());
  const auto vertex = [&](const CurveLevel& at) { return known.find(numbers_.made(at)); };
  for (const std::uint32_t c : curves.curves())
    for_each_layer_edge(growth_, c, [&](const CurveLevel& lower, const CurveLevel& upper) {
      append(std::array{vertex(lower), vertex(upper)}, growth_.sides().entity_of(c).index,
             part.block(BoundaryKind::Edge));
    });
}

std::vector<FieldInfo> PartLayers::fields() {
  std::vector<FieldInfo> fields;
  for (const std::string_view name : kFields) fields.push_back({std::string(name), 1});
  return fields;
}

void PartLayers::number_as_in_mesh(PartMesh& part) const {
  for (std::uint64_t& global : part.vert_to_global) global = numbers_.in_mesh(global);
}

}  // namespace tetloom::layers
