#include "bench/support/pipeline_run.hpp"

#include <algorithm>
#include <fstream>
#include <stdexcept>

#include "bench/support/child_process.hpp"
#include "bench/support/peer.hpp"
#include "bench/support/volume_run.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

/// The folder in which the pieces of a list lie.
fs::path pieces_of(const fs::path& output) { return output.parent_path() / output.stem(); }

std::uint64_t bytes_of(const fs::path& output) {
  std::uint64_t bytes = fs::file_size(output);
  if (fs::is_directory(pieces_of(output)))
    for (const auto& entry : fs::recursive_directory_iterator(pieces_of(output)))
      if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

void remove_output(const fs::path& output) {
  fs::remove(output);
  fs::remove_all(pieces_of(output));
}

/// Runs what writes `output`, and fills in what can be seen from outside.
std::string run_writer(const std::vector<std::string>& command, const fs::path& output, PipelineSample& sample) {
  remove_output(output);
  const ChildResult child = run_child(command);
  const std::size_t tail = child.output.size() > 1000 ? child.output.size() - 1000 : 0;
  if (child.exit_status != 0 || !fs::exists(output))
    throw std::runtime_error(fs::path(command[0]).filename().string() + " ended with " +
                             std::to_string(child.exit_status) + ": " + child.output.substr(tail));
  sample.seconds = child.seconds;
  sample.peak_bytes = child.peak_bytes;
  sample.swap_bytes = child.swap_bytes;
  sample.file_bytes = bytes_of(output);
  return child.output;
}

/// A number of the report that may be null.
double number_of(const nlohmann::json& json, const char* key) {
  return json.contains(key) && json.at(key).is_number() ? json.at(key).get<double>() : 0.0;
}

void read_report(const fs::path& path, PipelineSample& sample) {
  std::ifstream file(path);
  const nlohmann::json report = nlohmann::json::parse(file);
  const nlohmann::json& seconds = report.at("seconds");
  sample.read = number_of(seconds, "read");
  sample.size_field = number_of(seconds, "size_field");
  sample.surface = number_of(seconds, "surface");
  sample.volume = number_of(seconds, "volume");
  sample.write = number_of(seconds, "write");
  sample.tets = report.at("counts").at("tets");
  sample.ratio_mean = number_of(report.at("quality"), "mean_ratio_mean");
  sample.ratio_p1 = number_of(report.at("quality"), "mean_ratio_p1");
  if (report.at("digest").is_string()) sample.digest = report.at("digest");
  if (sample.tets == 0) throw std::runtime_error("the command has made a mesh without tets");
}

}  // namespace

PipelineSample run_command(const PipelineTask& task) {
  const fs::path report = fs::path(task.output).replace_extension(".report.json");
  std::vector<std::string> command{TETLOOM_COMMAND, "mesh",   task.model,           "-o",
                                   task.output,     "--size", exact_text(task.size)};
  for (const std::string& word : {std::string("--threads"), std::to_string(task.threads), std::string("--report"),
                                  report.string(), std::string("--quiet")})
    command.push_back(word);
  if (!task.max_memory.empty()) command.insert(command.end(), {"--max-memory", task.max_memory});
  PipelineSample sample;
  run_writer(command, task.output, sample);
  remove_output(task.output);
  read_report(report, sample);
  return sample;
}

bool command_writes(const std::string& extension) {
  // A model that is not there is another error than a format that is not known.
  constexpr int kWrongUsage = 2;
  return run_child({TETLOOM_COMMAND, "mesh", "/no/such/model.step", "-o", "mesh." + extension}).exit_status !=
         kWrongUsage;
}

PipelineSample run_hxt(const PipelineTask& task, const std::string& program) {
  const std::string size = exact_text(task.size);
  PipelineSample sample;
  const std::string said = run_writer({"gmsh", task.model, "-3", "-algo", "hxt", "-nt", std::to_string(task.threads),
                                       "-bin", "-clmin", size, "-clmax", size, "-o", task.output},
                                      task.output, sample);
  sample.volume = number_behind(said, "Done meshing 3D (Wall ");
  sample.surface = number_behind(said, "Done meshing 2D (Wall ");
  const ChildResult judge = run_child({program, "--measure", nlohmann::json{{"file", task.output.string()}}.dump()});
  remove_output(task.output);
  if (judge.exit_status != 0) throw std::runtime_error("cannot judge the mesh of gmsh: " + judge.output);
  const nlohmann::json judged = nlohmann::json::parse(judge.output);
  judged.at("tets").get_to(sample.tets);
  judged.at("ratio_mean").get_to(sample.ratio_mean), judged.at("ratio_p1").get_to(sample.ratio_p1);
  return sample;
}

nlohmann::json judge_file(const fs::path& path) {
  Mesh mesh = read_mesh(path);
  VolumeSample sample;
  judge_volume(mesh, SizeField::uniform(1), sample);
  return {{"tets", sample.tets}, {"ratio_mean", sample.ratio_mean}, {"ratio_p1", sample.ratio_p1}};
}

const PipelineSample& PipelineSeries::median() const {
  std::vector<const PipelineSample*> order;
  for (const PipelineSample& sample : samples) order.push_back(&sample);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
  std::nth_element(order.begin(), middle, order.end(),
                   [](const PipelineSample* a, const PipelineSample* b) { return a->seconds < b->seconds; });
  return **middle;
}

double PipelineSeries::volume_seconds() const {
  std::vector<double> seconds;
  for (const PipelineSample& sample : samples) seconds.push_back(sample.volume);
  std::sort(seconds.begin(), seconds.end());
  return seconds[(seconds.size() - 1) / 2];
}

}  // namespace tetloom::bench
