#include "bench/support/snappy.hpp"

#include <cmath>
#include <fstream>
#include <sstream>

#include "bench/support/child_process.hpp"
#include "bench/support/peer.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << "FoamFile { version 2.0; format ascii; class dictionary; object " << path.filename().string()
                      << "; }\n"
                      << text;
}

std::string text_of(const Vec3& x) {
  return "(" + exact_text(x.x) + " " + exact_text(x.y) + " " + exact_text(x.z) + ")";
}

// Cubes of the edge asked for, half of one beyond the box.
void write_background(const SnappyTask& task, const fs::path& folder) {
  const Vec3 margin{1.5 * task.edge, 1.5 * task.edge, 1.5 * task.edge};
  const Vec3 low = task.low - margin, extent = task.high + margin - low;
  const auto cells = [&](double length) { return std::ceil(length / task.edge); };
  const Vec3 counts{cells(extent.x), cells(extent.y), cells(extent.z)};
  std::ostringstream text;
  text << "scale 1;\nvertices (\n";
  for (int z = 0; z < 2; ++z)
    for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}})
      text << text_of({low.x + x * counts.x * task.edge, low.y + y * counts.y * task.edge,
                       low.z + z * counts.z * task.edge})
           << "\n";
  text << ");\nblocks (hex (0 1 2 3 4 5 6 7) " << text_of(counts) << " simpleGrading (1 1 1));\nedges ();\n"
       << "boundary ();\nmergePatchPairs ();\n";
  write(folder / "system/blockMeshDict", text.str());
}

void write_settings(const SnappyTask& task, const fs::path& folder) {
  write(folder / "system/controlDict",
        "application snappyHexMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
        "writeControl timeStep; writeInterval 1; writeFormat binary; writePrecision 10;\n");
  write(folder / "system/fvSchemes",
        "gradSchemes { default Gauss linear; } divSchemes { default none; } ddtSchemes { default steadyState; }\n"
        "laplacianSchemes { default Gauss linear corrected; } interpolationSchemes { default linear; }\n"
        "snGradSchemes { default corrected; }\n");
  write(folder / "system/fvSolution", "solvers {}\n");
  std::ostringstream text;
  text << "castellatedMesh true; snap true; addLayers true; mergeTolerance 1e-6;\n"
       << "geometry { surface.stl { type triSurfaceMesh; name wall; } }\n"
       << "castellatedMeshControls { maxLocalCells 20000000; maxGlobalCells 50000000; minRefinementCells 0;\n"
       << "nCellsBetweenLevels 2; features (); refinementSurfaces { wall { level (0 0); } } resolveFeatureAngle 30;\n"
       << "refinementRegions {} locationInMesh " << text_of(task.inside) << "; allowFreeStandingZoneFaces true; }\n"
       << "snapControls { nSmoothPatch 3; tolerance 2; nSolveIter 30; nRelaxIter 5; }\n"
       << "addLayersControls { relativeSizes false; layers { wall { nSurfaceLayers " << task.count << "; } }\n"
       << "expansionRatio " << task.growth << "; firstLayerThickness " << exact_text(task.first_height)
       << "; minThickness " << exact_text(task.first_height / 10) << ";\n"
       << "nGrow 0; featureAngle 130; nRelaxIter 5; nSmoothSurfaceNormals 1; nSmoothNormals 3; nSmoothThickness 10;\n"
       << "maxFaceThicknessRatio 0.5; maxThicknessToMedialRatio 0.3; minMedianAxisAngle 90;\n"
       << "nBufferCellsNoExtrude 0; nLayerIter 50; }\n"
       << "meshQualityControls { maxNonOrtho 65; maxBoundarySkewness 20; maxInternalSkewness 4; maxConcave 80;\n"
       << "minVol 1e-13; minTetQuality -1e30; minArea -1; minTwist 0.02; minDeterminant 0.001; minFaceWeight 0.05;\n"
       << "minVolRatio 0.01; minTriangleTwist -1; nSmoothScale 4; errorReduction 0.75; }\n";
  write(folder / "system/snappyHexMeshDict", text.str());
}

ChildResult run_in(const fs::path& folder, const std::string& program) {
  return run_child({"sh", "-c",
                    "export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam}; exec " + program + " -case '" +
                        folder.string() + "'"});
}

}  // namespace

bool has_snappy() { return is_installed("snappyHexMesh") && is_installed("blockMesh"); }

SnappySample run_snappy(const SnappyTask& task, const fs::path& folder) {
  fs::remove_all(folder);
  write_background(task, folder);
  write_settings(task, folder);
  fs::create_directories(folder / "constant/triSurface");
  fs::copy_file(task.surface, folder / "constant/triSurface/surface.stl");
  SnappySample sample;
  for (const std::string& program : {std::string("blockMesh"), std::string("snappyHexMesh -overwrite")}) {
    const ChildResult child = run_in(folder, program);
    sample.seconds += child.seconds;
    if (child.exit_status != 0) {
      sample.failure = child.output.substr(child.output.size() > 300 ? child.output.size() - 300 : 0);
      return sample;
    }
    if (program != "blockMesh") read_snappy(child.output, sample);
  }
  fs::remove_all(folder);
  return sample;
}

}  // namespace tetloom::bench
