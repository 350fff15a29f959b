#pragma once
// A large face that is meshed in pieces: all pieces at once, then what lies along the cuts, then what lies around the
// places where cuts meet.
//
//      +--------+--------+    1. pieces: each by itself, the chains of the cut as its rim
//      |   A   :|:   B   |    2. zones: the triangles within a few layers of the cut between two pieces; the chain is
//      |    : :J: :      |       free to move and change, the rest holds still
//      +------/ \--------+    3. junctions: the same around J, where zones meet
//      |     : C :       |
//
// Within a step, no two tasks touch the same triangle or move the same vertex; what they share holds still. The mesh
// depends on the cut alone, whatever the threads and their order.
#include <functional>

#include "mesher/surface/face_cut.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// One large face while its pieces are meshed.
class FaceInPieces {
 public:
  /// Refers to its arguments, which must outlive it.
  FaceInPieces(const GeometricModel& model, ModelFaceId face, const FaceSurroundings& surroundings, FaceCut cut,
               const std::function<bool()>& keep_going);

  std::size_t piece_count() const { return cut_.pieces.size(); }
  /// About how many triangles a piece has.
  static constexpr double piece_work() { return kTrianglesPerPiece; }
  /// Different pieces may be meshed at once. Errors: those of the face's geometry.
  void mesh_piece(std::size_t piece);
  /// For a piece whose meshing threw.
  void fail_piece(std::size_t piece) { parts_[piece].failed = true; }

  /// A piece that another rank has meshed.
  void put_part(std::size_t number, MessageWriter& writer) const;
  void take_part(std::size_t number, MessageReader& reader);

  /// After all pieces: puts them together. None where a piece could not be meshed: the face must be meshed whole. Ranks
  /// share the zones and the junctions.
  std::optional<FaceMesh> join(const SharedWork& work);

 private:
  struct FaceTriangle {
    std::array<std::uint32_t, 3> verts;  ///< of the face, or kOwn | index into `Part::own`
    std::uint8_t fixed = 0;              ///< bit i: the edge from vertex i is a piece of a model edge
  };
  struct LooseTriangle {
    std::uint32_t label;  ///< of the part that it goes to
    FaceTriangle triangle;
  };
  /// A piece, a zone or a junction.
  struct Part {
    std::uint32_t first = 0;             ///< number of the first of `own` among the vertices of the face
    std::vector<PatchVertex> own;        ///< vertices made here
    std::vector<FaceTriangle> kept;      ///< done
    std::vector<LooseTriangle> loose;    ///< go to a later part, sorted by its label
    std::vector<std::uint32_t> dropped;  ///< vertices of the face that are no longer used
    std::vector<std::uint32_t> moved;    ///< vertices of the face that lie elsewhere now
    bool failed = false;
  };
  struct Layers;

  std::size_t zone_part(std::uint32_t zone) const { return cut_.pieces.size() + zone; }
  std::size_t junction_part(std::uint32_t junction) const { return zone_part(0) + cut_.zones.size() + junction; }

  void link_zones_to_junctions();
  void number_vertices(std::size_t first_part, std::size_t end_part);
  PatchVertex& vertex(std::uint32_t id);
  const PatchVertex& vertex(std::uint32_t id) const;
  const PatchVertex& vertex_of(const Part& part, std::uint32_t vert) const;
  static FaceTriangle in_face(const Part& part, FaceTriangle triangle);

  Patch piece_patch(const FacePiece& piece, PolygonVerdict& verdict) const;
  void take_piece(std::size_t piece, const Patch& patch);
  Layers find_layers(const FacePiece& piece, const Patch& patch) const;

  void improve_parts(std::size_t first_part, std::size_t end_part, std::size_t at_once, const SharedWork& work);
  std::vector<FaceTriangle> gather(std::size_t part, std::span<const std::uint32_t> sources) const;
  void improve(std::size_t part, const std::vector<FaceTriangle>& triangles, const PatchSurface& surface);
  void hand_to_junctions(std::uint32_t zone);

  struct TakenChord;
  void split_taken_chords();
  std::vector<TakenChord> find_taken_chords() const;
  void split_at(const TakenChord& chord, std::uint32_t vertex);

  FaceMesh extract(const TaskRunner& runner);
  bool has_area(const Part& part, const FaceTriangle& triangle) const;

  const GeometricModel& model_;
  ModelFaceId face_;
  const FaceSurroundings& surroundings_;
  FaceCut cut_;
  const std::function<bool()>& keep_going_;
  std::uint32_t rim_count_ = 0;
  std::vector<Part> parts_;                                    // pieces, zones, junctions, split chords
  std::vector<std::vector<std::uint32_t>> part_to_sources_;    // parts whose loose triangles it takes, ascending
  std::vector<std::vector<std::uint32_t>> zone_to_junctions_;  // ascending
};

}  // namespace tetloom
