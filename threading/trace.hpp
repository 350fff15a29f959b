#pragma once
// What ran when: one record per task, written in the trace event format that browsers' trace viewers open.
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "threading/message.hpp"

namespace tetloom {

struct TaskRecord {
  PartId part;
  std::uint32_t step = 0;
  std::string name;
  double start = 0, end = 0;  ///< seconds since the trace was made
  int worker = 0;             ///< index of the thread among those of the run
  std::uint64_t bytes_sent = 0;
};

/// Collects records of any number of schedules. Thread-safe.
class Trace {
 public:
  Trace();
  double now() const;
  void add(TaskRecord record);
  /// Sorted by start.
  std::vector<TaskRecord> records() const;
  /// JSON in the trace event format (complete events; one row per thread). Errors: OutputFailed.
  void write(const std::filesystem::path& file, int rank = 0) const;

 private:
  std::int64_t origin_nanoseconds_ = 0;
  mutable std::mutex mutex_;  // around the list below, once per task
  std::vector<TaskRecord> records_;
};

}  // namespace tetloom
