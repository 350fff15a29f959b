#pragma once
// The .mapbc file beside a UGRID file: for every face its tag, the code of its boundary condition and its name.
#include <filesystem>

#include "core/io/atomic_file.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

/// "wing.mapbc" of "wing.lb8.ugrid" and "wing.ugrid". Pre: `path` ends in `extension`, in any case.
std::filesystem::path mapbc_beside(const std::filesystem::path& path, std::string_view extension);

/// Fills `file`, which will replace what stands at `path`. Codes are those that the file at `path` has for the tags; 0,
/// which stands for none, of others. Errors: those of AtomicFile; InputUnreadable for a file at `path` that is none of
/// the kind, and is left as it is then.
void write_mapbc(const Mesh& mesh, const std::filesystem::path& path, AtomicFile& file, const CancelToken* cancel);

/// Gives the faces of `mesh` the names in the file, where there is one: several faces of one name are a group, and
/// "face_12" of face 12 is no name. Errors: InputUnreadable with the line, Cancelled.
void read_mapbc(const std::filesystem::path& path, Mesh& mesh, const CancelToken* cancel);

}  // namespace tetloom::detail
