#include "tetloom/tasks.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <utility>

#include "core/io/atomic_file.hpp"

namespace tetloom {

namespace {

std::int64_t nanoseconds() {
  const auto time = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::nanoseconds>(time).count();
}

std::string escaped(const std::string& text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string result;
  for (const char c : text) {
    if (const auto code = static_cast<unsigned char>(c); code < 0x20) {
      result += "\\u00";
      result += kDigits[code >> 4];
      result += kDigits[code & 15];
    } else {
      if (c == '"' || c == '\\') result += '\\';
      result += c;
    }
  }
  return result;
}

// The format counts in microseconds; whole nanoseconds keep the text short.
double microseconds(double seconds) { return std::round(seconds * 1e9) / 1e3; }

void write_number(AtomicFile& file, const char* key, std::uint64_t value) {
  file.write(key);
  file.print(value);
}

void write_sent(AtomicFile& file, const std::vector<SentMessage>& sent) {
  file.write(",\"sent\":[");
  for (std::size_t i = 0; i < sent.size(); ++i) {
    write_number(file, i == 0 ? "[" : ",[", sent[i].to.value);
    write_number(file, ",", sent[i].bytes);
    file.write("]");
  }
  file.write("]");
}

void write_arguments(AtomicFile& file, const TaskRecord& record) {
  write_number(file, "{\"run\":", record.run);
  if (record.kind == TaskKind::Step) {
    write_number(file, ",\"part\":", record.part.value);
    write_number(file, ",\"step\":", record.step);
    write_number(file, ",\"bytes_sent\":", record.bytes_sent());
    write_sent(file, record.sent);
  } else {
    write_number(file, ",\"threads\":", static_cast<std::uint64_t>(record.threads));
    write_number(file, ",\"pieces\":", record.pieces);
  }
  file.write("}");
}

void write_record(AtomicFile& file, const TaskRecord& record, int rank) {
  file.write("{\"ph\":\"X\",\"cat\":\"");
  file.write(to_string(record.kind));
  file.write("\",\"name\":\"");
  file.write(escaped(record.name));
  file.write("\",\"pid\":");
  file.print(rank);
  file.write(",\"tid\":");
  file.print(record.worker);
  file.write(",\"ts\":");
  file.print(microseconds(record.start));
  file.write(",\"dur\":");
  file.print(microseconds(record.seconds()));
  file.write(",\"args\":");
  write_arguments(file, record);
  file.write("}");
}

// How many tasks this thread is inside of.
thread_local int traced_tasks = 0;

}  // namespace

TracedTask::TracedTask() { ++traced_tasks; }
TracedTask::~TracedTask() { --traced_tasks; }
bool TracedTask::is_inside() { return traced_tasks > 0; }

const char* to_string(TaskKind kind) {
  switch (kind) {
    case TaskKind::Serial: return "serial";
    case TaskKind::Divisible: return "divisible";
    case TaskKind::Step: break;
  }
  return "step";
}

std::uint64_t TaskRecord::bytes_sent() const {
  std::uint64_t bytes = 0;
  for (const SentMessage& message : sent) bytes += message.bytes;
  return bytes;
}

Trace::Trace() : origin_nanoseconds_(nanoseconds()) {}

double Trace::now() const { return static_cast<double>(nanoseconds() - origin_nanoseconds_) * 1e-9; }

std::uint32_t Trace::begin_run() {
  const std::lock_guard lock(mutex_);
  return run_count_++;
}

void Trace::add(TaskRecord record) {
  const std::lock_guard lock(mutex_);
  records_.push_back(std::move(record));
}

std::vector<TaskRecord> Trace::records() const {
  std::vector<TaskRecord> sorted;
  {
    const std::lock_guard lock(mutex_);
    sorted = records_;
  }
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const TaskRecord& a, const TaskRecord& b) { return a.start < b.start; });
  return sorted;
}

void Trace::write(const std::filesystem::path& file, int rank) const {
  AtomicFile out(file);
  out.write("{\"displayTimeUnit\":\"ms\",\"traceEvents\":[");
  bool first = true;
  for (const TaskRecord& record : records()) {
    out.write(first ? "\n" : ",\n");
    write_record(out, record, rank);
    first = false;
  }
  out.write("\n]}\n");
  out.commit();
}

TraceSpan::TraceSpan(Trace* trace, std::string name) : trace_(trace) {
  if (trace_ == nullptr) return;
  record_.name = std::move(name);
  record_.kind = TaskKind::Serial;
  record_.run = trace_->begin_run();
  record_.start = trace_->now();
}

TraceSpan::TraceSpan(Trace* trace, std::string name, int threads, std::uint64_t pieces)
    : TraceSpan(trace, std::move(name)) {
  record_.kind = TaskKind::Divisible;
  record_.threads = threads;
  record_.pieces = pieces;
}

TraceSpan::~TraceSpan() {
  if (trace_ == nullptr) return;
  record_.end = trace_->now();
  try {
    trace_->add(std::move(record_));
  } catch (const std::bad_alloc&) {  // the work itself is done
  }
}

}  // namespace tetloom
