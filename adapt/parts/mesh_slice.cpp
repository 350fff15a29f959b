#include "adapt/parts/mesh_slice.hpp"

#include <algorithm>
#include <new>
#include <utility>

#include "core/base/lists.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"

namespace tetloom::adapt {

namespace {

// Cuts the slice of one rank out of a mesh.
class SliceCutter {
 public:
  SliceCutter(const Mesh& mesh, const MetricField& metric) : mesh_(mesh), metric_(metric) {}

  MeshSlice run(std::size_t first, std::size_t count, const std::vector<std::string>& fields) {
    mark_own(first, count);
    take_tets(first, count);
    choose_triangles();
    take_points();
    renumber_tets();
    take_triangles();
    take_edges();
    take_fields(mesh_.point_fields, fields, slice_.to_vert_number, slice_.mesh.point_fields);
    take_fields(mesh_.cell_fields, fields, slice_.to_tet_number, slice_.mesh.cell_fields);
    slice_.mesh.entities = mesh_.entities, slice_.mesh.face_to_sides = mesh_.face_to_sides;
    slice_.vert_count = mesh_.points.size();
    return std::move(slice_);
  }

 private:
  template <class Verts>
  bool is_near(const Verts& verts) const {
    return std::ranges::any_of(verts, [&](std::uint32_t v) { return own_[v] != 0; });
  }

  void mark_own(std::size_t first, std::size_t count) {
    own_.resize(mesh_.points.size(), 0);
    for (std::size_t tet = first; tet < first + count; ++tet)
      for (const std::uint32_t v : mesh_.tet_to_vert[tet]) own_[v] = 1;
  }

  void take_tets(std::size_t first, std::size_t count) {
    for (std::uint32_t tet = 0; tet < mesh_.tet_to_vert.size(); ++tet) {
      if (tet == first) slice_.begin = slice_.to_tet_number.size();
      if (!is_near(mesh_.tet_to_vert[tet])) continue;
      slice_.to_tet_number.push_back(first_number() + tet);
      slice_.mesh.tet_to_vert.push_back(mesh_.tet_to_vert[tet]);
      slice_.mesh.tet_to_entity.push_back(mesh_.tet_to_entity[tet]);
    }
    if (count == 0) slice_.begin = slice_.to_tet_number.size();
    slice_.end = slice_.begin + count;
  }

  // Those at own vertices, and those that no tet touches.
  void choose_triangles() {
    std::vector<std::uint8_t> is_used(mesh_.points.size(), 0);
    for (const auto& verts : mesh_.tet_to_vert)
      for (const std::uint32_t v : verts) is_used[v] = 1;
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
      const auto& verts = mesh_.tri_to_vert[t];
      const bool is_lost = std::ranges::none_of(verts, [&](std::uint32_t v) { return is_used[v] != 0; });
      if (is_near(verts) || is_lost) triangles_.push_back(t);
    }
  }

  void take_points() {
    to_local_.resize(mesh_.points.size(), kNone);
    for (const auto& verts : slice_.mesh.tet_to_vert)
      for (const std::uint32_t v : verts) to_local_[v] = 0;
    for (const std::uint32_t t : triangles_)
      for (const std::uint32_t v : mesh_.tri_to_vert[t]) to_local_[v] = 0;
    for (std::uint32_t v = 0; v < to_local_.size(); ++v) {
      if (to_local_[v] == kNone) continue;
      to_local_[v] = static_cast<std::uint32_t>(slice_.to_vert_number.size());
      slice_.to_vert_number.push_back(first_number() + v);
      slice_.is_own.push_back(own_[v]);
      slice_.mesh.points.push_back(mesh_.points[v]);
      if (!mesh_.point_to_entity.empty()) slice_.mesh.point_to_entity.push_back(mesh_.point_to_entity[v]);
      slice_.metric.logs.push_back(metric_.logs[v]);
    }
  }

  void renumber_tets() {
    for (auto& verts : slice_.mesh.tet_to_vert)
      for (std::uint32_t& v : verts) v = to_local_[v];
  }

  void take_triangles() {
    for (const std::uint32_t t : triangles_) {
      slice_.mesh.tri_to_vert.push_back(mesh_.tri_to_vert[t]);
      for (std::uint32_t& v : slice_.mesh.tri_to_vert.back()) v = to_local_[v];
      slice_.mesh.tri_to_entity.push_back(mesh_.tri_to_entity[t]);
    }
  }

  void take_edges() {
    for (std::size_t e = 0; e < mesh_.edge_to_vert.size(); ++e) {
      const auto [a, b] = mesh_.edge_to_vert[e];
      if (!is_near(mesh_.edge_to_vert[e]) || to_local_[a] == kNone || to_local_[b] == kNone) continue;
      slice_.mesh.edge_to_vert.push_back({to_local_[a], to_local_[b]});
      slice_.mesh.edge_to_entity.push_back(mesh_.edge_to_entity[e]);
    }
  }

  static void take_fields(const std::vector<MeshField>& given, const std::vector<std::string>& names,
                          const std::vector<Number>& numbers, std::vector<MeshField>& made) {
    for (const MeshField& field : given) {
      if (std::ranges::count(names, field.name) == 0) continue;
      std::vector<double>& values = made.emplace_back(MeshField{field.name, field.components, {}}).values;
      const auto n = static_cast<std::size_t>(field.components);
      values.reserve(numbers.size() * n);
      for (const Number number : numbers)
        for (std::size_t c = 0; c < n; ++c) values.push_back(field.values[(number - first_number()) * n + c]);
    }
  }

  const Mesh& mesh_;
  const MetricField& metric_;
  std::vector<std::uint8_t> own_;
  std::vector<std::uint32_t> triangles_, to_local_;
  MeshSlice slice_;
};

void put_mesh(const MeshSlice& slice, MessageWriter& writer) {
  const Mesh& mesh = slice.mesh;
  const auto place_of = [&](std::uint32_t v) {
    return static_cast<std::uint32_t>(slice.to_vert_number[v] - first_number());
  };
  const auto places_of = [&](auto verts) {
    for (std::uint32_t& v : verts) v = place_of(v);
    return verts;
  };
  const auto is_own = [&](const auto& verts) {
    return std::ranges::all_of(verts, [&](std::uint32_t v) { return slice.is_own[v] != 0; });
  };
  const auto put_elements = [&](const auto& elements, const std::vector<std::uint32_t>& entities, std::size_t begin,
                                std::size_t end, const auto& takes) {
    std::decay_t<decltype(elements)> verts;
    std::vector<std::uint32_t> of;
    for (std::size_t i = begin; i < end; ++i)
      if (takes(elements[i])) verts.push_back(places_of(elements[i])), of.push_back(entities[i]);
    writer.put_array(std::span<const typename decltype(verts)::value_type>(verts));
    writer.put_array(std::span<const std::uint32_t>(of));
  };
  put_elements(mesh.tet_to_vert, mesh.tet_to_entity, slice.begin, slice.end, [](const auto&) { return true; });
  put_elements(mesh.tri_to_vert, mesh.tri_to_entity, 0, mesh.tri_to_vert.size(), is_own);
  put_elements(mesh.edge_to_vert, mesh.edge_to_entity, 0, mesh.edge_to_vert.size(), is_own);
  std::vector<std::uint32_t> own;
  for (std::uint32_t v = 0; v < slice.is_own.size(); ++v)
    if (slice.is_own[v] != 0) own.push_back(v);
  const auto put_values = [&](auto of) { writer.put_each(own, of); };
  put_values(place_of);
  put_values([&](std::uint32_t v) { return mesh.points[v]; });
  put_values([&](std::uint32_t v) { return mesh.point_to_entity.empty() ? ModelEntity() : mesh.point_to_entity[v]; });
  put_values([&](std::uint32_t v) { return slice.metric.logs[v]; });
  for (const MeshField& field : mesh.point_fields)
    for (int c = 0; c < field.components; ++c)
      put_values([&](std::uint32_t v) {
        return field.values[v * static_cast<std::size_t>(field.components) + static_cast<std::size_t>(c)];
      });
  for (const MeshField& field : mesh.cell_fields) {
    const auto n = static_cast<std::size_t>(field.components);
    writer.put_array(std::span<const double>(field.values).subspan(slice.begin * n, (slice.end - slice.begin) * n));
  }
}

void take_points(MessageReader& reader, MeshWithMetric& whole) {
  const auto numbers = reader.get_view<std::uint32_t>();
  const auto points = reader.get_view<Vec3>();
  const auto entities = reader.get_view<ModelEntity>();
  const auto logs = reader.get_view<Tensor>();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    whole.mesh.points[numbers[i]] = points[i], whole.mesh.point_to_entity[numbers[i]] = entities[i];
    whole.metric.logs[numbers[i]] = logs[i];
  }
  for (MeshField& field : whole.mesh.point_fields) {
    const auto n = static_cast<std::size_t>(field.components);
    for (std::size_t c = 0; c < n; ++c) {
      const auto values = reader.get_view<double>();
      for (std::size_t i = 0; i < numbers.size(); ++i) field.values[numbers[i] * n + c] = values[i];
    }
  }
}

// Elements that several ranks have stay once.
template <class Elements>
void drop_copies(Elements& elements, std::vector<std::uint32_t>& entities) {
  std::vector<std::pair<typename Elements::value_type, std::uint32_t>> sorted;
  for (std::uint32_t i = 0; i < elements.size(); ++i) {
    sorted.emplace_back(elements[i], i);
    std::ranges::sort(sorted.back().first);
  }
  std::ranges::sort(sorted);
  Elements kept;
  std::vector<std::uint32_t> of;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    if (i > 0 && sorted[i].first == sorted[i - 1].first) continue;
    kept.push_back(elements[sorted[i].second]), of.push_back(entities[sorted[i].second]);
  }
  elements = std::move(kept), entities = std::move(of);
}

}  // namespace

OwnTets MeshSlice::own_tets(const SharedWork& work) const {
  OwnTets own{begin, end, {}, {}};
  own.sum = [&work](ExactSum& sum) { work.sum(std::span(&sum, 1)); };
  own.largest = [&work](std::span<double> values) { work.max(values); };
  return own;
}

MeshSlice slice_of(const Mesh& mesh, const MetricField& metric, const std::vector<std::string>& fields, int rank,
                   int rank_count) {
  const auto r = static_cast<std::size_t>(rank);
  std::vector<Number> firsts = equal_ranges(mesh.tet_to_vert.size(), static_cast<std::size_t>(rank_count));
  MeshSlice slice = SliceCutter(mesh, metric).run(firsts[r] - firsts[0], firsts[r + 1] - firsts[r], fields);
  slice.first_tets = std::move(firsts);
  return slice;
}

MeshWithMetric gather_slices(const MeshSlice& slice, const SharedWork& work) {
  if (slice.tet_count() >= CellPlace::kMaxTets) throw std::bad_alloc();
  MeshWithMetric whole;
  Mesh& mesh = whole.mesh;
  mesh.entities = slice.mesh.entities, mesh.face_to_sides = slice.mesh.face_to_sides;
  mesh.points.resize(slice.vert_count), mesh.point_to_entity.resize(slice.vert_count);
  whole.metric.logs.resize(slice.vert_count);
  for (const MeshField& field : slice.mesh.point_fields)
    mesh.point_fields.push_back({field.name, field.components,
                                 std::vector<double>(slice.vert_count * static_cast<std::size_t>(field.components))});
  for (const MeshField& field : slice.mesh.cell_fields) mesh.cell_fields.push_back({field.name, field.components, {}});
  std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) { put_mesh(slice, writer); });
  for (Bytes& bytes : given) {
    MessageReader reader(bytes);
    const auto take = [&](auto& elements, std::vector<std::uint32_t>& entities) {
      const auto verts = reader.get_view<typename std::decay_t<decltype(elements)>::value_type>();
      const auto of = reader.get_view<std::uint32_t>();
      elements.insert(elements.end(), verts.begin(), verts.end()),
          entities.insert(entities.end(), of.begin(), of.end());
    };
    take(mesh.tet_to_vert, mesh.tet_to_entity);
    take(mesh.tri_to_vert, mesh.tri_to_entity);
    take(mesh.edge_to_vert, mesh.edge_to_entity);
    take_points(reader, whole);
    for (MeshField& field : mesh.cell_fields) {
      const auto values = reader.get_view<double>();
      field.values.insert(field.values.end(), values.begin(), values.end());
    }
    bytes = Bytes();
  }
  drop_copies(mesh.tri_to_vert, mesh.tri_to_entity);
  drop_copies(mesh.edge_to_vert, mesh.edge_to_entity);
  return whole;
}

}  // namespace tetloom::adapt
