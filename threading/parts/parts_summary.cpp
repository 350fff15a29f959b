#include "threading/parts/parts_summary.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/mesh/digest_sums.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/quality_values.hpp"
#include "core/mesh/quantile.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/edge_owners.hpp"
#include "threading/parts/owned_elements.hpp"

namespace tetloom {
namespace {

constexpr double kPercentile = 0.01;

// A part as a mesh in one piece, without fields and without the boundary elements that others own.
class OwnedMesh {
 public:
  OwnedMesh(const Part& part, PartId self) : part_(part), owned_(part, self) {
    const PartMesh& own = part.mesh;
    mesh.points.assign(own.points.begin(), own.points.end());
    for (const PackedEntity entity : own.vert_to_entity) mesh.point_to_entity.push_back(entity.unpack());
    for_each_cell_kind(mesh, [&](CellKind kind, auto& cells, auto& regions) {
      const CellBlock& block = own.block(kind);
      take_all(block.to_vert.span(), cells);
      regions.assign(block.to_region.begin(), block.to_region.end());
    });
    counts.assign(mesh.points.size(), 1);
    const auto& shared = part.boundary.vertices;
    for (std::size_t i = 0; i < shared.size(); ++i)
      counts[shared.entities[i]] = owner_of(shared.copies_of(i), self) == self ? 1 : 0;
    take_owned(BoundaryKind::Edge, mesh.edge_to_vert, mesh.edge_to_entity);
    take_owned(BoundaryKind::Triangle, mesh.tri_to_vert, mesh.tri_to_entity);
    take_owned(BoundaryKind::Quad, mesh.quad_to_vert, mesh.quad_to_entity);
  }

  Mesh mesh;
  std::vector<std::uint8_t> counts;  ///< of each point: this part owns it

 private:
  template <std::size_t N>
  static void take_all(std::span<const std::uint32_t> verts, std::vector<std::array<std::uint32_t, N>>& elements) {
    elements.resize(verts.size() / N);
    for (std::size_t i = 0; i < elements.size(); ++i) std::copy_n(verts.data() + i * N, N, elements[i].begin());
  }

  template <std::size_t N>
  void take_owned(BoundaryKind kind, std::vector<std::array<std::uint32_t, N>>& elements,
                  std::vector<std::uint32_t>& entities) {
    const BoundaryBlock& block = part_.mesh.block(kind);
    for (std::size_t i = 0; i < block.size(); ++i) {
      std::array<std::uint32_t, N> verts;
      std::copy_n(&block.to_vert[i * N], N, verts.begin());
      if (!owned_.has(verts)) continue;
      elements.push_back(verts), entities.push_back(block.to_entity[i]);
    }
  }

  const Part& part_;
  OwnedElements owned_;
};

// What one part gives.
struct PartFigures {
  DigestSums digest;
  QualityReport quality;
  QualityValues values;
  std::uint64_t unclassified = 0;
};

PartFigures look_at(const Part& part, PartId self, const SizeField* sizes, const MeasuredEdges& edges,
                    const TaskRunner& runner) {
  runner.check_cancelled();
  const OwnedMesh owned(part, self);
  PartFigures figures;
  figures.digest = digest_sums(owned.mesh, owned.counts, runner);
  figures.quality = compute_quality(owned.mesh, sizes, runner, figures.values, edges);
  for (std::size_t v = 0; v < owned.counts.size(); ++v)
    figures.unclassified += owned.counts[v] != 0 && !owned.mesh.point_to_entity[v].valid();
  return figures;
}

// Figures that are not lists, in one message.
struct QualityHead {
  CurvedQuality curved;
  std::array<std::size_t, kCellKinds> counts;
  std::size_t cells, inverted;
  double cell_volume, tet_volume, min_dihedral_deg, mean_ratio_min, mean_ratio_mean;
  std::size_t tets, inverted_tets, triangles;
  std::array<std::size_t, 10> mean_ratio_histogram;
  std::array<std::size_t, 18> dihedral_histogram;
  double shape_min, shape_mean, min_angle_deg, area;
  double min_scaled_jacobian;
  EdgeConformity tet_edges, triangle_edges;
};

QualityHead head_of(const QualityReport& q) {
  return {q.curved,
          q.cells.counts,
          q.cells.count,
          q.cells.inverted,
          q.cells.volume,
          q.tets.volume,
          q.tets.min_dihedral_deg,
          q.tets.mean_ratio_min,
          q.tets.mean_ratio_mean,
          q.tets.count,
          q.tets.inverted,
          q.triangles.count,
          q.tets.mean_ratio_histogram,
          q.tets.dihedral_histogram,
          q.triangles.shape_min,
          q.triangles.shape_mean,
          q.triangles.min_angle_deg,
          q.triangles.area,
          q.cells.min_scaled_jacobian,
          q.tets.edges,
          q.triangles.edges};
}

void put(const PartFigures& figures, MessageWriter& writer) {
  writer.put(figures.digest);
  writer.put(figures.unclassified);
  writer.put(head_of(figures.quality));
  writer.put_array(std::span<const RegionQuality>(figures.quality.cells.regions));
  writer.put_array(std::span<const FaceQuality>(figures.quality.triangles.faces));
}

// Means stand for sums until all is there.
class QualitySums {
 public:
  void add(const QualityHead& part) {
    const auto least = [](bool first, double own, double& all) { all = first ? own : std::min(all, own); };
    CellQuality& cells = all_.cells;
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) cells.counts[kind] += part.counts[kind];
    cells.count += part.cells, cells.inverted += part.inverted, cells.volume += part.cell_volume;
    cells.min_scaled_jacobian = std::min(cells.min_scaled_jacobian, part.min_scaled_jacobian);
    CurvedQuality& curved = all_.curved;
    curved.count += part.curved.count, curved.not_positive += part.curved.not_positive;
    curved.min_scaled_jacobian = std::min(curved.min_scaled_jacobian, part.curved.min_scaled_jacobian);
    curved.volume += part.curved.volume;
    TetQuality& tets = all_.tets;
    if (part.tets > 0) {
      least(tets.count == 0, part.min_dihedral_deg, tets.min_dihedral_deg);
      least(tets.count == 0, part.mean_ratio_min, tets.mean_ratio_min);
      tets.count += part.tets, tets.inverted += part.inverted_tets, tets.volume += part.tet_volume;
      tets.mean_ratio_mean += part.mean_ratio_mean * static_cast<double>(part.tets);
      for (std::size_t i = 0; i < 10; ++i) tets.mean_ratio_histogram[i] += part.mean_ratio_histogram[i];
      for (std::size_t i = 0; i < 18; ++i) tets.dihedral_histogram[i] += part.dihedral_histogram[i];
    }
    add(part.tet_edges, tets.edges);
    TriangleQuality& triangles = all_.triangles;
    add(part.triangle_edges, triangles.edges);
    if (part.triangles == 0) return;
    least(triangles.count == 0, part.shape_min, triangles.shape_min);
    least(triangles.count == 0, part.min_angle_deg, triangles.min_angle_deg);
    triangles.count += part.triangles, triangles.area += part.area;
    triangles.shape_mean += part.shape_mean * static_cast<double>(part.triangles);
  }

  void add(std::span<const RegionQuality> parts) {
    auto& regions = all_.cells.regions;
    for (const RegionQuality& part : parts) {
      RegionQuality& all = entry(regions, part.region, &RegionQuality::region);
      all.tets += part.tets, all.cells += part.cells, all.volume += part.volume;
    }
  }

  void add(std::span<const FaceQuality> parts) {
    auto& faces = all_.triangles.faces;
    for (const FaceQuality& part : parts) {
      FaceQuality& all = entry(faces, part.face, &FaceQuality::face);
      all.min_angle_deg = all.triangles == 0 ? part.min_angle_deg : std::min(all.min_angle_deg, part.min_angle_deg);
      all.triangles += part.triangles, all.area += part.area;
    }
  }

  QualityReport take() {
    if (all_.tets.count > 0) all_.tets.mean_ratio_mean /= static_cast<double>(all_.tets.count);
    if (all_.triangles.count > 0) all_.triangles.shape_mean /= static_cast<double>(all_.triangles.count);
    for (EdgeConformity* edges : {&all_.tets.edges, &all_.triangles.edges})
      if (edges->edges > 0)
        for (const auto mean : kEdgeMeans) edges->*mean /= static_cast<double>(edges->edges);
    return std::move(all_);
  }

 private:
  static constexpr std::array kEdgeMeans{&EdgeConformity::mean_length, &EdgeConformity::mean_length_ratio,
                                         &EdgeConformity::in_band};

  static void add(const EdgeConformity& part, EdgeConformity& all) {
    all.edges += part.edges;
    for (const auto mean : kEdgeMeans) all.*mean += part.*mean * static_cast<double>(part.edges);
  }

  // That of an entity, in a list that ascends.
  template <class Entry>
  static Entry& entry(std::vector<Entry>& entries, std::uint32_t entity, std::uint32_t Entry::*key) {
    auto at = std::ranges::lower_bound(entries, entity, {}, key);
    if (at == entries.end() || (*at).*key != entity) {
      at = entries.insert(at, Entry{});
      (*at).*key = entity;
    }
    return *at;
  }

  QualityReport all_;
};

PartsSummary add_up(Communicator& communicator, std::span<const PartFigures> own) {
  PartsSummary summary;
  DigestSums digest;
  QualitySums quality;
  gather(
      communicator,
      [&](MessageWriter& writer) {
        writer.put(std::uint64_t{own.size()});
        for (const PartFigures& figures : own) put(figures, writer);
      },
      [&](MessageReader& reader) {
        for (auto left = reader.get<std::uint64_t>(); left > 0; --left) {
          digest.add(reader.get<DigestSums>());
          summary.unclassified_points += reader.get<std::uint64_t>();
          quality.add(reader.get<QualityHead>());
          quality.add(reader.get_view<RegionQuality>());
          quality.add(reader.get_view<FaceQuality>());
        }
      });
  summary.points = digest.kinds[DigestSums::kPoints].count;
  summary.triangles = digest.kinds[DigestSums::kTriangles].count;
  summary.tets = digest.kinds[DigestSums::kCells[0]].count;
  summary.digest = digest_of(digest);
  summary.quality = quality.take();
  return summary;
}

double percentile_of(Communicator& communicator, const std::vector<std::span<const float>>& values,
                     const TaskRunner& runner) {
  std::vector<std::int64_t> counts = count_bins({}, runner);
  run_on_all(communicator, [&] {
    for (const std::span<const float> own : values) {
      const std::vector<std::int64_t> of_part = count_bins(own, runner);
      for (std::size_t bin = 0; bin < counts.size(); ++bin) counts[bin] += of_part[bin];
    }
  });
  communicator.sum(counts);
  const QuantileBins bins = find_bins(counts, kPercentile);
  std::vector<float> near;
  run_on_all(communicator, [&] {
    for (const std::span<const float> own : values) {
      const std::vector<float> of_part = values_in(own, bins, runner);
      near.insert(near.end(), of_part.begin(), of_part.end());
    }
  });
  return quantile_of(gather_lists<float>(communicator, near), bins);
}

}  // namespace

PartsSummary summarize_parts(const PartitionedMesh& mesh, const TaskRunner& runner, const SizeField* sizes) {
  Communicator& communicator = *mesh.communicator;
  const auto local = mesh.local();
  const EdgeOwners edges(mesh, runner);
  std::vector<PartFigures> figures(local.size());
  run_on_all(communicator, [&] {
    runner.for_each(local.size(), [&](std::size_t i) {
      const Part& part = mesh.parts.at(local[i]);
      figures[i] = look_at(part, local[i], sizes, edges.of(part, local[i]), runner);
    });
  });
  PartsSummary summary = add_up(communicator, figures);
  std::vector<std::span<const float>> ratios, shapes, jacobians;
  for (const PartFigures& of_part : figures) {
    ratios.emplace_back(of_part.values.mean_ratios.span());
    shapes.emplace_back(of_part.values.shapes.span());
    jacobians.emplace_back(of_part.values.jacobians.span());
  }
  QualityReport& quality = summary.quality;
  quality.tets.mean_ratio_p1 = percentile_of(communicator, ratios, runner);
  quality.triangles.shape_p1 = percentile_of(communicator, shapes, runner);
  if (quality.cells.count > quality.tets.count)
    quality.cells.scaled_jacobian_p1 = percentile_of(communicator, jacobians, runner);
  return summary;
}

}  // namespace tetloom
