#pragma once
// The command line, as values.
#include <filesystem>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

#include "apps/tetloom/entity_groups.hpp"
#include "apps/tetloom/wall_layers.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/io.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/model.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {

/// The command line of `mesh`.
struct MeshCommand {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path sizes_file;  ///< empty: none
  std::filesystem::path report;      ///< empty: none
  ReadOptions read;
  MeshOptions options;
  WriteOptions write;
  std::vector<GroupWish> groups;
  std::filesystem::path groups_file;  ///< empty: none
  LayersWish layers;
  double far_field = 0;        ///< the model is put into a box so many times as large; 0: it is not
  double metres_per_unit = 0;  ///< of the output; 0: the model's unit
  bool in_parts = false;  ///< the output holds parts: options.parts of them, or as many as the volume was filled in
  bool quiet = false;
};

/// The command line of `info`.
struct InfoCommand {
  std::filesystem::path input;
  std::filesystem::path report;
  ReadOptions read;
  int threads = 0;  ///< 0: all cores
  bool quiet = false;
};

/// The command line of `check`.
struct CheckCommand {
  std::filesystem::path input;
  std::filesystem::path report;
  int threads = 0;  ///< 0: all cores
  bool quiet = false;
};

/// The command line of `partition`.
struct PartitionCommand {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path report;  ///< empty: none
  BalanceOptions balance;
  int threads = 0;  ///< 0: all cores
  bool quiet = false;
};

/// The command line of `adapt`.
struct AdaptCommand {
  std::filesystem::path input;
  std::filesystem::path output;
  std::filesystem::path report;  ///< empty: none
  std::filesystem::path model;   ///< empty: none
  ReadOptions read;              ///< of the model
  // Where the metric comes from: one of these is not empty.
  std::filesystem::path metric_file;
  std::string metric_field;
  std::string hessian_field;
  adapt::HessianOptions hessian;  ///< the bounds and the gradation hold for other metrics too
  double curvature = 0;           ///< edges per turn on the model's faces and edges; 0: sizes are not limited so
  AdaptOptions options;
  bool in_parts = false;  ///< the output holds parts: options.parts of them, or as many as the last round had
  bool quiet = false;
};

/// Text for standard output and nothing else to do: help or the version.
struct Printout {
  std::string text;
};

/// Any command line that can be carried out.
using Command = std::variant<MeshCommand, InfoCommand, CheckCommand, PartitionCommand, AdaptCommand, Printout>;

/// A command line that cannot be carried out; what() is for a person.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads and checks the command line. Everything that can be judged without reading the input is judged here: number
/// ranges, options that exclude each other, the extension of the output. Throws UsageError.
Command parse_command_line(int argc, const char* const* argv);

/// The value of --report wherever it stands, for command lines that cannot be parsed.
std::optional<std::filesystem::path> find_report_argument(int argc, const char* const* argv);

}  // namespace tetloom::app
