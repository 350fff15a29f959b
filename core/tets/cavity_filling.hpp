#pragma once
// How tets take the place of others that fill the same polyhedron. A section through it:
//   +---+---+         +-------+          +-------+    A face of an old tet lies inside, between two of them, or on the
//   |\  |  /|         |       |          |\     /|    boundary, with something or nothing behind it. A face of a new
//   | \ | / |  open   |       |  close   | \   / |    tet meets the boundary or another new one. They meet by their
//   +--\|/--+  ---->  +       +  ---->   +--\ /--+    vertices: the order and shape of the cavity do not matter.
//    \  |  /           \     /            \  |  /
//     \ | /             \   /              \ | /
//      \|/               \ /                \|/
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "core/tets/triangle_verts.hpp"

namespace tetloom::tets {

/// Remembers the boundary of a cavity, and links what takes its place: `open`, `swap_surface` where the surface
/// changes, then vertices, regions and ids are the caller's to write, then `close`. Linear; nothing is allocated but
/// for cavities larger than all before. Where tets overlap, several faces may have the same vertices: any two of those
/// that are left meet, those behind two tets between the same vertices, say.
class CavityFilling {
 public:
  /// Begins with the cavity `old`, for which `made_count` tets will be made. Reads the mesh alone.
  void open(const TetMesh& mesh, std::span<const std::uint32_t> old, std::size_t made_count);

  /// Triangles of the surface give way to others: those `before` that bound the mesh need not be met, those `after` are
  /// fixed, and may have a tet on one side only. Pre: `after` has none of `before`.
  void swap_surface(std::span<const TriangleVerts> before, std::span<const TriangleVerts> after);

  /// Links the tets `made`, whose vertices are there and of which no face is fixed. Faces that were fixed stay so, on
  /// the boundary as well as those inside that are still there. Returns whether every face met another one: false,
  /// where the polyhedra differ, and the links are of no use.
  bool close(TetMesh& mesh, std::span<const std::uint32_t> made);

 private:
  enum class State : std::uint8_t {
    Gone,   // inside of the cavity, or met
    Outer,  // on the boundary: `code` is the face behind it, kNone where nothing is
    Made,   // of a tet that is made: `code` is that face
    Wanted  // must be fixed where it is made
  };
  struct Key {
    std::uint64_t lower;  // the lowest vertex, then the next
    std::uint32_t highest;
    bool operator==(const Key&) const = default;
  };
  struct Slot {
    Key key;
    FaceCode code;
    FaceCode own;  // of a face on the boundary, as one of the cavity
    std::uint32_t stamp = 0;
    State state;
    bool is_fixed;
  };

  static Key key_of(const TriangleVerts& verts);
  static bool is_unmet(const Slot& slot) { return slot.state == State::Outer || slot.state == State::Made; }
  template <class Accept>
  Slot& find(const Key& key, const Accept& accept);
  void add_old(const TetMesh& mesh, FaceCode face);
  void add_made(TetMesh& mesh, FaceCode face);
  void meet(TetMesh& mesh, Slot& slot, FaceCode face, bool is_fixed);
  void meet_rest(TetMesh& mesh);

  std::vector<Slot> slots_;  // open addressing; those of another stamp are empty
  std::vector<Key> after_;
  std::uint32_t stamp_ = 0;
  int shift_ = 0;
  std::size_t unmet_ = 0;
};

}  // namespace tetloom::tets
