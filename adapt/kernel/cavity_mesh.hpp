#pragma once
// The mesh of one part while it is adapted, and the one operation that changes its topology.
//
// An operation is a *core* of one to four vertices that a simplex of the mesh has, the *cavity* of all tets that have
// it, and a point p. Each tet of the cavity gives one tet for each vertex of the core, with p in that vertex's place;
// those that would have p twice vanish. With core and p as below this is
//   {a}           b a neighbour   collapse of a into b        {a}        p = a, elsewhere   motion
//   {a, b}        new             split of an edge            {a, b}     c on its ring      edge swap
//   {a, b, c}     new             a point in a face           {a, b, c}  an apex            face swap 2-3
//   {a, b, c, d}  new             a point in a tet
// Motion changes no links: it is evaluated alone, with a as both core and p, and never carried out.
// Triangles of the surface and pieces of model edges that have the core change in the same way. So all of them are one
// piece of code: what fills the cavity anew is the star of p (the cavity operator of Loseille & Löhner 2013, here with
// cavities that follow from the core, so that links follow by counting, without a search). Where nothing of the surface
// lies at an edge, any triangulation of its ring may take its place, not only those of one vertex: `replace_ring`.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/kernel/metric_stage.hpp"
#include "adapt/kernel/surface_map.hpp"
#include "adapt/metric/tet_edges.hpp"
#include "core/tets/edge_ring.hpp"
#include "core/tets/tet_editor.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/tet_quality.hpp"
#include "tetloom/part_mesh.hpp"

namespace tetloom::adapt {

using tets::FaceCode;
using tets::kDeadQuality;
using tets::TetMesh;

// Bits of a vertex's state. Where nothing has changed, what was refused before is not asked again.
/// In this round, a tet at the vertex was replaced, or it moved far.
inline constexpr std::uint8_t kChanged = 1;
/// The same in the round before.
inline constexpr std::uint8_t kHasChanged = 2;
/// The vertex may move: a tet at it was replaced, or another vertex of one moved far.
inline constexpr std::uint8_t kUnsettled = 4;

/// Something for each tet of a cavity: a vector whose room is there from the start, so that adding asks for nothing.
template <class T>
class CavityList {
 public:
  static constexpr std::size_t kRoom = 260;  // the tets of a cavity and what is found before there are too many

  std::size_t size() const { return size_; }
  const T* data() const { return items_.data(); }
  T* data() { return items_.data(); }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }
  operator std::span<const T>() const { return {items_.data(), size_}; }
  const T& operator[](std::size_t i) const { return items_[i]; }
  void push_back(const T& item) { items_[size_++] = item; }
  void clear() { size_ = 0; }
  /// Pre: the items are there.
  void set_size(std::size_t size) { size_ = size; }

 private:
  std::vector<T> items_ = std::vector<T>(kRoom);
  std::size_t size_ = 0;
};

/// The tets that have a core.
struct Cavity {
  static constexpr std::size_t kMostTets = 256;

  std::array<std::uint32_t, 4> core;
  std::uint32_t core_size = 0;
  CavityList<std::uint32_t> tets;
  CavityList<std::array<std::uint8_t, 4>> corners;  ///< of each tet, where the vertices of the core are in it
  std::vector<FaceCode> surface;  ///< fixed faces that have the core, of those with tets on both sides the lower code
  double least = 2;               ///< cubed quality of the worst tet

  bool is_core(std::uint32_t vert) const {
    for (std::uint32_t k = 0; k < core_size; ++k)
      if (core[k] == vert) return true;
    return false;
  }
};

/// Cubed qualities of what an operation would make, in the order tet · core vertex; 2 for what vanishes.
using MadeQualities = std::vector<float>;

/// The tets of a part that adaptation changes, with what it has to know of them and of their vertices.
class CavityMesh {
 public:
  TetMesh mesh;
  GrowingArray<float> to_quality;           ///< cubed quality of each tet in the metric; kDeadQuality for dead ones
  GrowingArray<VertexMetric> to_metric;     ///< per vertex
  GrowingArray<PackedEntity> to_entity;     ///< per vertex: what it is classified on
  GrowingArray<std::uint32_t> vert_to_tet;  ///< a tet that has the vertex; kNone: none has
  GrowingArray<BackgroundTet> to_hint;      ///< per vertex: for the metric's source
  GrowingArray<std::uint8_t> to_frozen;     ///< per vertex: it stays, and so do all triangles and edges it has
  GrowingArray<std::uint8_t> to_state;      ///< per vertex: what has changed at it: kChanged, kHasChanged, kUnsettled
  SurfaceMap surface;

  const Vec3& point(std::uint32_t v) const { return mesh.points[v]; }
  const std::uint32_t* verts(std::uint32_t tet) const { return &mesh.to_vert[std::size_t{tet} * 4]; }
  std::uint32_t corner_of(std::uint32_t tet, std::uint32_t vert) const {
    const std::uint32_t* v = verts(tet);
    return v[0] == vert ? 0 : v[1] == vert ? 1 : v[2] == vert ? 2 : v[3] == vert ? 3 : 4;
  }
  int dim_of(std::uint32_t v) const {
    const ModelEntity entity = to_entity[v].unpack();
    return entity.valid() ? entity.dim : 3;
  }

  /// Cubed mean ratio in the metric of the vertex at which the metric's determinant is largest; 0 unless orient3d > 0,
  /// exactly. So is all that is evaluated here: what has a quality above 0 is positive.
  double quality_of(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const;
  /// Tets of a larger cubed quality, however it was computed, are positive for sure; see surely_positive_quality.
  double surely_positive() const { return surely_positive_; }
  double length_of(std::uint32_t a, std::uint32_t b) const;
  TetEdges edges_of(std::uint32_t tet) const { return edges_of_tet(mesh.points, to_metric, verts(tet)); }
  /// The vertices of the i-th tet at an edge that the edge does not have. Pre: `shell` is the cavity of an edge.
  std::array<std::uint32_t, 2> beside_edge(const Cavity& shell, std::size_t i) const;
  /// Whether anything has changed at a vertex of the tet, in this round or the one before.
  bool is_active(std::uint32_t tet) const {
    const std::uint32_t* v = verts(tet);
    return ((to_state[v[0]] | to_state[v[1]] | to_state[v[2]] | to_state[v[3]]) & (kChanged | kHasChanged)) != 0;
  }

  /// All vertices of the tet have changed.
  void mark_changed(std::uint32_t tet) {
    for (int j = 0; j < 4; ++j) to_state[verts(tet)[j]] |= kChanged | kUnsettled;
  }

  /// Fills `cavity` with the tets that have `core`. False where it has too many; what is in it then is of no use. Pre:
  /// `tet` has the core.
  bool collect(std::span<const std::uint32_t> core, std::uint32_t tet, Cavity& cavity) const;
  /// The same for an edge that may be swapped: false as well as soon as a tet is worse than `tet`, or there are more
  /// than `most`.
  bool collect_around_worst(const std::array<std::uint32_t, 2>& edge, std::uint32_t tet, std::size_t most,
                            Cavity& cavity) const;
  /// A tet that has the edge; kNone where the mesh has no such edge.
  std::uint32_t find_edge(std::uint32_t a, std::uint32_t b, Cavity& scratch) const;

  /// The worst cubed quality of what `p` in the place of the core would make; 0 where one of that would not be
  /// positive; something not above `goal` as soon as that is certain. `made` is filled as far as it got.
  double evaluate(const Cavity& cavity, std::uint32_t p, double goal, MadeQualities& made) const;
  /// The same, faster where most of it will be needed. Pre: no tet of the cavity has p unless it is the core.
  double evaluate_all(const Cavity& cavity, std::uint32_t p, double goal, MadeQualities& made) const;
  /// Whether surface and mesh would remain manifold where p takes the place of the core.
  bool is_sound(const Cavity& cavity, std::uint32_t p) const;
  /// Carries it out. Pre: evaluate > 0 with these `made`, is_sound. The core loses p's cavity: vertices of a core of
  /// one have no tets any more.
  void reconnect(const Cavity& cavity, std::uint32_t p, const MadeQualities& qualities);
  /// The tets `made` take the place of `old`, which are of one region and have no fixed faces between them.
  void replace(std::span<const std::uint32_t> old, std::span<const tets::NewTet> made);

  /// The ring of an edge, with its ends in the order that the ring's sense asks for. False where it has more vertices
  /// than there is room for. Pre: `shell` is the cavity of an edge without fixed faces, collected from `shell.tets[0]`.
  bool find_ring(const Cavity& shell, tets::EdgeRing& ring) const;
  /// Puts the tets over a triangulation of the ring in the place of those around the edge; their qualities are
  /// computed.
  void replace_ring(const tets::EdgeRing& ring, std::span<const tets::RingTriangle> triangles);

  /// Has the tets around one fetched, which will be asked for soon.
  void prefetch_behind(std::uint32_t tet) const {
    for (std::uint32_t j = 0; j < 4; ++j) {
      const FaceCode behind = mesh.behind({tet, j});
      if (!behind.valid()) continue;
      const std::size_t first = FaceCode(behind.tet(), 0).index();
      __builtin_prefetch(&mesh.to_vert[first]);
      __builtin_prefetch(&mesh.to_neighbor[first]);
    }
  }
  std::uint32_t add_vertex(const Vec3& x, const Tensor& metric, PackedEntity entity, BackgroundTet hint);
  void set_metric(std::uint32_t v, const Tensor& metric);
  void drop_last_vertex();
  /// Drops what is dead; `along_curve`: vertices then stand along a Hilbert curve, tets by their lowest vertices,
  /// otherwise all stay in their order. Returns, of each vertex, the number that it had.
  GrowingArray<std::uint32_t> renumber(bool along_curve);
  /// Computes `to_quality` and `vert_to_tet`, when all else is there.
  void start();

  /// All that it has, for another rank that goes on with it as this one would.
  void put(MessageWriter& writer) const;
  static CavityMesh get(MessageReader& reader);

 private:
  void note_metric(const VertexMetric& metric) {
    surely_positive_ = std::max(surely_positive_, surely_positive_quality(metric));
  }
  bool makes_positive(const Cavity& cavity, std::uint32_t p) const;
  bool collect_ball(std::uint32_t tet, Cavity& cavity) const;
  bool collect_shell(std::uint32_t tet, std::size_t most, double least, Cavity& cavity) const;
  void add_fixed_faces(std::uint32_t tet, std::uint32_t own, Cavity& cavity) const;
  void start_cavity(std::span<const std::uint32_t> core, Cavity& cavity) const;
  bool collect_few(std::uint32_t tet, Cavity& cavity) const;
  void add_to(Cavity& cavity, std::uint32_t tet, const std::array<std::uint8_t, 4>& corners) const;
  void stamp(const Cavity& cavity) const;
  GrowingArray<std::uint32_t> find_verts(bool along_curve) const;
  GrowingArray<std::uint32_t> find_tets(bool by_verts) const;
  void permute_verts(std::span<const std::uint32_t> sources);
  void permute_tets(std::span<const std::uint32_t> sources);
  using ModelEdgeEnd = std::pair<std::uint32_t, std::uint32_t>;  // a vertex, and the edge that leads to it
  // A tet of a cavity that gives way, and what is made in its place.
  struct OldTet {
    std::array<FaceCode, 4> behind;
    std::array<std::uint32_t, 4> ids;  // with p in the place of each vertex of the core; unless it vanishes
    std::uint32_t apex;                // the corner at p; 4: none
    std::uint8_t fixed;
    bool vanishes() const { return apex < 4; }
    bool is_fixed(std::uint32_t face) const { return (fixed >> face & 1) != 0; }
  };
  void take_pieces(const Triangle& corners, std::uint32_t core, std::vector<ModelEdgeEnd>& ends);
  void split_piece(const std::array<std::uint32_t, 4>& ends, std::uint32_t p);
  void change_surface(const Cavity& cavity, std::uint32_t p);
  void remember(const Cavity& cavity, std::uint32_t p);
  void write_star(const Cavity& cavity, std::uint32_t p, const MadeQualities& qualities);
  void pass_triangle(const Cavity& cavity, std::size_t i);
  void link_made(const Cavity& cavity, std::size_t i, std::uint32_t k);
  void note_made(std::uint32_t tet);

  double surely_positive_ = 0;  // the largest for all metrics that there were
  tets::TetEditor editor_;
  mutable GrowingArray<std::uint32_t> slot_;  // of a tet in the last cavity
  // Scratch of reconnect.
  std::vector<OldTet> star_;
  std::vector<std::uint32_t> old_, vanishing_, regions_;
  std::vector<tets::NewTet> made_;
};

}  // namespace tetloom::adapt
