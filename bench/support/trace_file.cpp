#include "bench/support/trace_file.hpp"

#include <exception>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace tetloom::bench {
namespace {

TaskKind kind_named(const std::string& name) {
  for (const TaskKind kind : {TaskKind::Step, TaskKind::Serial, TaskKind::Divisible})
    if (name == to_string(kind)) return kind;
  throw std::runtime_error("no kind of task: '" + name + "'");
}

TaskRecord read_record(const nlohmann::json& event) {
  const nlohmann::json& arguments = event.at("args");
  TaskRecord record;
  record.kind = kind_named(event.at("cat"));
  record.name = event.at("name");
  record.start = 1e-6 * event.at("ts").get<double>();
  record.end = record.start + 1e-6 * event.at("dur").get<double>();
  record.worker = event.at("tid");
  record.run = arguments.at("run");
  if (record.kind == TaskKind::Step) {
    record.part = PartId(arguments.at("part").get<std::size_t>());
    record.step = arguments.at("step");
    for (const nlohmann::json& message : arguments.at("sent"))
      record.sent.push_back({PartId(message.at(0).get<std::size_t>()), message.at(1)});
  } else {
    record.threads = arguments.at("threads");
    record.pieces = arguments.at("pieces");
  }
  return record;
}

}  // namespace

std::vector<TaskRecord> read_trace(const std::filesystem::path& path) {
  std::vector<TaskRecord> records;
  try {
    std::ifstream file(path);
    const nlohmann::json trace = nlohmann::json::parse(file);
    for (const nlohmann::json& event : trace.at("traceEvents")) records.push_back(read_record(event));
  } catch (const std::exception& error) {
    throw std::runtime_error("'" + path.string() + "' is not a trace of tetloom: " + error.what());
  }
  return records;
}

}  // namespace tetloom::bench
