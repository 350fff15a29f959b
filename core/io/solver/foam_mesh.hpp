#pragma once
// One polyMesh of OpenFOAM: a whole mesh, or a part of one, which is the mesh of one processor.
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "core/base/local_numbers.hpp"
#include "core/io/solver/foam_faces.hpp"

namespace tetloom::detail {

/// Where a part stands among the others.
struct FoamPart {
  std::uint32_t number = 0;
  std::vector<FoamSharedFace> shared;
};

/// `mesh` outlives the object. Thread safety: const members from any thread.
class FoamMesh {
 public:
  /// `named` has the groups of the whole mesh, see name_groups. Errors: InvalidArgument (too many cells).
  FoamMesh(const Mesh& mesh, Groups named, const FoamPart& part, const BlockLoop& loop);
  FoamMesh(const FoamMesh&) = delete;
  FoamMesh& operator=(const FoamMesh&) = delete;

  /// How many faces each patch and each zone has: patches of the groups of faces, that of faces in no group, zones of
  /// the groups. All parts of a mesh have the same patches and zones: those in which one of them has faces.
  std::vector<std::int64_t> counts() const;

  /// Writes the files of polyMesh into `folder`, which is there, with the patches and zones whose `counts` are not 0.
  /// Errors: OutputFailed, Cancelled.
  void write(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
             const CancelToken* cancel) const;

  /// Whether `write` makes a file of that name, or OpenFOAM notes something of the mesh under it.
  static bool is_file_name(const std::string& name);

 private:
  template <class PrintItem>
  void write_list(const std::filesystem::path& path, const char* type, std::size_t count, std::size_t bytes,
                  const PrintItem& print_item, const CancelToken* cancel, const std::string& note = {}) const;
  void write_points(const std::filesystem::path& folder, const CancelToken* cancel) const;
  void write_faces(const std::filesystem::path& folder, const CancelToken* cancel) const;
  void write_owners(const std::filesystem::path& folder, const CancelToken* cancel) const;
  void write_boundary(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
                      const CancelToken* cancel) const;
  void write_cell_zones(const std::filesystem::path& folder, const CancelToken* cancel) const;
  void write_face_zones(const std::filesystem::path& folder, const std::vector<std::int64_t>& counts,
                        const CancelToken* cancel) const;

  const Mesh& mesh_;
  const BlockLoop& loop_;
  const std::uint32_t part_;
  const CellFaces cell_faces_;
  const Groups groups_;
  const FoamFaces faces_;
  LocalNumbers points_;  // the vertices of cells, ascending: OpenFOAM takes no others
};

}  // namespace tetloom::detail
