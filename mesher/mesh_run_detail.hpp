#pragma once
// What all ways of meshing a model have in common: sizes and surface; the volume is filled by whoever calls.
#include <functional>
#include <vector>

#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/communicator.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

struct FillingReport {
  std::vector<Diagnostic> errors, warnings;
  FillingFigures figures;
};

/// Called once at most, when there is a surface that may be filled: the mesh, from which the input is made. In
/// SharedWork::together, for its ranks.
using FillVolume = std::function<FillingReport(const VolumeInput&, const VolumeOptions&, const SharedWork&, Mesh&)>;

/// As make_mesh, where the volume is what `fill` makes of it. Whatever it throws is in the result. `ranks`, where there
/// are some, share the work on sizes and surface; they have the same surface then, and come to `fill` together or not
/// at all.
MeshResult run_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host, const FillVolume& fill,
                    Communicator* ranks = nullptr);

}  // namespace tetloom
