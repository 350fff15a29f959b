#pragma once
// What a run of real_models knows of one model: the model itself, and what tetloom and Gmsh made of it.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tetloom/ids.hpp"

namespace tetloom::bench {

/// The model as `tetloom info` describes it, and its facets as the bench reads them.
struct ModelFacts {
  double diagonal = 0;           ///< of the bounding box, model length; 0 where it is not known
  std::vector<double> volumes;   ///< of the regions
  bool facets = false;           ///< an STL or OBJ file
  bool closed_manifold = false;  ///< of facets: every edge has two, equal points merged
  std::string error;             ///< why it cannot be described

  double volume() const;
  /// Regions that enclose anything.
  std::size_t good_regions() const;
};

/// A mesh file, judged by core/mesh, whoever wrote it.
struct MeshFigures {
  std::uint64_t tets = 0, triangles = 0, inverted = 0, regions = 0;
  double volume = 0;
  double min_dihedral_deg = 0, ratio_mean = 0, ratio_p1 = 0, ratio_min = 0;
  double edges_in_band = 0;                ///< of edges with length / size in [0.707, 1.414]; 0: no sizes to judge by
  std::optional<double> surface_distance;  ///< from the model, see surface_distance.hpp; where it was asked for
  std::string problem;                     ///< the first that validate_mesh finds; empty: none
};
void to_json(nlohmann::json& json, const MeshFigures& figures);
void from_json(const nlohmann::json& json, MeshFigures& figures);

/// One mesher on one model. `failure` is what it said when it made no mesh; empty with a mesh.
struct MesherRun {
  int exit_status = -1;
  bool timed_out = false;
  double seconds = 0, cpu_seconds = 0;  ///< of the whole process
  std::uint64_t peak_bytes = 0;
  std::string failure;
  std::optional<MeshFigures> mesh;

  double tets_per_second() const;
};

struct StageTimes {
  double total = 0, read = 0, size_field = 0, surface = 0, volume = 0, check = 0, write = 0;  ///< seconds
};

/// The tet with the smallest angle, and what of the model forces it.
struct WorstAngle {
  double dihedral_deg = 0, cause_deg = 0, cause_length = 0;  ///< as in the report
  std::string cause;                                         ///< as in the report; empty where nothing forces it
  std::string entities;                                      ///< "face 3, edge 7"
};

struct RealModel {
  std::string name;
  std::filesystem::path path;
  ModelFacts facts;
  MesherRun tetloom;
  std::optional<MesherRun> gmsh;
  StageTimes stages;  ///< of tetloom
  std::string digest;
  std::vector<std::string> warnings;
  std::optional<WorstAngle> worst;
};

/// The solids that tetloom has made anew, as its report says: lists that follow each other, each numbered in the model
/// that the last one left.
std::vector<std::vector<ModelRegionId>> rebuilt_solids(const nlohmann::json& report);

/// Takes what `tetloom info --report` says.
void take_description(const nlohmann::json& report, ModelFacts& facts);

/// Takes what `tetloom mesh --report` says; of failed and cancelled runs as well. A report without some of it is
/// fine.
void take_report(const nlohmann::json& report, RealModel& model);

/// How tetloom's run stands: "valid", or in two or three words what is wrong with it. Valid: it ended with 0, in time,
/// the mesh has no problem and no inverted tet, all regions are filled, and the volume is within 1 % of the model's.
/// A model without regions has a surface mesh.
std::string verdict(const RealModel& model);
bool is_valid(const RealModel& model);

/// The same for Gmsh, whose meshes may have what validate_mesh calls a problem; "-" where it did not run.
std::string gmsh_verdict(const RealModel& model);
bool is_gmsh_valid(const RealModel& model);

/// Whether both have meshed it, so that their times can be compared: tetloom's run is valid, and Gmsh has left tets of
/// at least 95 % of the volume.
bool can_compare(const RealModel& model);

nlohmann::json to_json(const RealModel& model);

}  // namespace tetloom::bench
