#include "threading/trace.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

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

void write_record(AtomicFile& file, const TaskRecord& record, int rank) {
  file.write("{\"ph\":\"X\",\"cat\":\"step\",\"name\":\"");
  file.write(escaped(record.name));
  file.write("\",\"pid\":");
  file.print(rank);
  file.write(",\"tid\":");
  file.print(record.worker);
  file.write(",\"ts\":");
  file.print(microseconds(record.start));
  file.write(",\"dur\":");
  file.print(microseconds(record.end - record.start));
  file.write(",\"args\":{\"part\":");
  file.print(record.part.value);
  file.write(",\"step\":");
  file.print(record.step);
  file.write(",\"bytes_sent\":");
  file.print(record.bytes_sent);
  file.write("}}");
}

}  // namespace

Trace::Trace() : origin_nanoseconds_(nanoseconds()) {}

double Trace::now() const { return static_cast<double>(nanoseconds() - origin_nanoseconds_) * 1e-9; }

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

}  // namespace tetloom
