#include "mesher/volume/lattice_filling.hpp"

#include <chrono>
#include <cstdio>
#include <numeric>
#include <utility>

#include "mesher/lattice/lattice_core.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/optimizer.hpp"
#include "mesher/tets/shell.hpp"

namespace tetloom::volume {

namespace {

using tets::Fault;
using tets::TetMesh;

struct Lap {
  const char* n;
  std::chrono::steady_clock::time_point t = std::chrono::steady_clock::now();
  Lap(const char* a) : n(a) {}
  ~Lap() {
    fprintf(stderr, "  %-12s %.4f\n", n, std::chrono::duration<double>(std::chrono::steady_clock::now() - t).count());
  }
};

class LatticeFiller {
 public:
  LatticeFiller(const Complex& complex, const intersection::TriangleTree& tree, const SizeField& sizes,
                const TaskRunner& runner)
      : complex_(complex), tree_(tree), sizes_(sizes), runner_(runner) {}

  LatticeFilling run() {
    LatticeFilling filling;
    filling.mesh.points = GrowingArray<Vec3>(std::span(complex_.points));
    const lattice::LatticeCore core = make_core(filling.mesh);
    Fault fault = make_shell(filling.mesh, core);
    if (!fault.any()) {
      Lap l("join");
      fault = join_shell(filling.mesh, std::move(shell_), core.open_faces, surface());
    }
    if (!fault.any()) {Lap l("optimise"); tets::OptimizeOptions o; o.fixed_points=(std::uint32_t)complex_.points.size(); o.strong_gradation=!sizes_.is_uniform(); auto r=optimize(filling.mesh,o,runner_); fprintf(stderr,"edges %zu moves %zu ins %zu  least %g->%g mean %g->%g below %zu dih %g belowdih %zu forced %zu\n",r.edges_removed,r.vertices_moved,r.points_inserted,r.least_before,r.least,r.mean_before,r.mean,r.below_goal,r.least_dihedral,r.below_dihedral,r.forced);}
    filling.verdict = {std::move(fault.message), std::move(fault.triangles), fault.point};
    fprintf(stderr, "core %zu open %zu shell verts %zu all tets %zu points %zu\n", core_size_, core.open_faces.size(),
            core.shell_verts.size(), filling.mesh.size(), filling.mesh.points.size());
    return filling;
  }

 private:
  tets::Surface surface() const { return {complex_.tri_to_vert, complex_.tri_to_sides}; }

  lattice::LatticeCore make_core(TetMesh& mesh) {
    lattice::LatticeRequest request{&tree_, complex_.tri_to_sides, {}, &sizes_};
    for (const Vec3& x : complex_.points) request.box.add(x);
    std::vector<lattice::LevelPoints> levels;
    {
      Lap l("points");
      levels = make_lattice_points(request, runner_);
    }
    Lap l("core");
    auto c = emit_core(mesh, levels);
    core_size_ = mesh.size();
    return c;
  }

  Fault make_shell(TetMesh& mesh, const lattice::LatticeCore& core) {
    std::vector<std::uint32_t> verts(complex_.points.size());
    std::iota(verts.begin(), verts.end(), 0u);
    verts.insert(verts.end(), core.shell_verts.begin(), core.shell_verts.end());
    shell_.points = std::move(mesh.points);
    {
      Lap l("delaunay");
      const tets::DelaunayResult delaunay = make_delaunay(shell_, verts, runner_);
      if (!delaunay.duplicates.empty())
        return {"points of the surface coincide", {}, complex_.points[delaunay.duplicates[0].vert]};
    }
    fprintf(stderr, "shell delaunay %zu\n", shell_.size());
    {
      Lap l("fixcore");
      if (const std::size_t missing = fix_core_faces(shell_, mesh, core.open_faces); missing > 0)
        return {std::to_string(missing) + " faces of the lattice core are not in the shell", {}, shell_.points[0]};
    }
    Lap l("fixsurf");
    return fix_surface();
  }

  Fault fix_surface() {
    tets::TriangleTable table(complex_.tri_to_vert.size());
    for (std::uint32_t t = 0; t < complex_.tri_to_vert.size(); ++t) table.add(complex_.tri_to_vert[t], t);
    std::vector<char> found(complex_.tri_to_vert.size(), 0);
    for (tets::FaceCode face = 0; face < shell_.to_neighbor.size(); ++face) {
      const auto v = verts_of(shell_, face);
      if (v[0] >= complex_.points.size() || v[1] >= complex_.points.size() || v[2] >= complex_.points.size()) continue;
      const auto* entry = table.find(tets::sorted(v));
      if (!entry) continue;
      found[entry->value] = 1;
      shell_.to_fixed[face / 4] = static_cast<std::uint8_t>(shell_.to_fixed[face / 4] | 1 << face % 4);
    }
    Fault fault;
    for (std::uint32_t t = 0; t < found.size(); ++t) {
      if (!found[t]) fault.triangles.push_back(t);
    }
    if (fault.triangles.empty()) return fault;
    fault.message = std::to_string(fault.triangles.size()) + " surface triangles are not faces of the mesh";
    const auto& [a, b, c] = complex_.tri_to_vert[fault.triangles[0]];
    fault.point = (complex_.points[a] + complex_.points[b] + complex_.points[c]) / 3;
    return fault;
  }

  const Complex& complex_;
  const intersection::TriangleTree& tree_;
  const SizeField& sizes_;
  const TaskRunner& runner_;
  TetMesh shell_;
  std::size_t core_size_ = 0;
};

}  // namespace

LatticeFilling fill_by_lattice(const Complex& complex, const intersection::TriangleTree& tree, const SizeField& sizes,
                               const TaskRunner& runner) {
  return LatticeFiller(complex, tree, sizes, runner).run();
}

Filling to_filling(TetMesh&& mesh, std::size_t given) {
  Filling filling;
  mesh.to_neighbor.release();
  mesh.to_fixed.release();
  std::vector<std::uint32_t> to_new(mesh.points.size(), tets::kNone);
  for (const std::uint32_t v : mesh.to_vert) to_new[v] = 0;
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (v >= given && to_new[v] == tets::kNone) continue;
    to_new[v] = static_cast<std::uint32_t>(filling.points.size());
    filling.points.push_back(mesh.points[v]);
  }
  mesh.points.release();
  filling.tet_to_vert.resize(mesh.to_region.size());
  for (std::size_t tet = 0; tet < filling.tet_to_vert.size(); ++tet) {
    for (std::size_t i = 0; i < 4; ++i) filling.tet_to_vert[tet][i] = to_new[mesh.to_vert[tet * 4 + i]];
  }
  mesh.to_vert.release();
  filling.tet_to_region.assign(mesh.to_region.begin(), mesh.to_region.end());
  mesh.to_region.release();
  return filling;
}

}  // namespace tetloom::volume
