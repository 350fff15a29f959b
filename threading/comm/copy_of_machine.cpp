#include "threading/comm/copy_of_machine.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/codec.hpp"
#include "core/base/temporary_file.hpp"
#include "tetloom/error.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

// The same for all processes of a machine that is running, and for no other one.
std::string machine_name() {
  std::string name;
  std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), name);
  if (!name.empty()) return name;
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  return host.data();
}

std::vector<std::string> gather_texts(Communicator& ranks, const std::string& own) {
  std::vector<std::string> all;
  gather(
      ranks, [&](MessageWriter& writer) { put_text(writer, own); },
      [&](MessageReader& reader) { all.push_back(get_text(reader)); });
  return all;
}

// Null where there is no room.
std::unique_ptr<TemporaryFile> write_copy(std::span<const std::byte> bytes) {
  try {
    auto file = std::make_unique<TemporaryFile>("arrays");
    std::ofstream stream(file->path(), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();  // where some file systems say that they are full
    return stream ? std::move(file) : nullptr;
  } catch (const Error&) {
    return nullptr;
  }
}

class CopyOfMachine {
 public:
  explicit CopyOfMachine(Communicator& ranks) : ranks_(ranks) {
    if (ranks.rank_count() == 1) return;
    const std::vector<std::string> machines = gather_texts(ranks, machine_name());
    const std::string& own = machines[static_cast<std::size_t>(ranks.rank())];
    writer_ = static_cast<std::size_t>(std::ranges::find(machines, own) - machines.begin());
    is_alone_ = std::ranges::count(machines, own) == 1;
  }

  std::shared_ptr<const std::byte> keep(std::span<const std::byte> bytes) const {
    if (ranks_.rank_count() == 1 || bytes.size() < kLeastKept) return nullptr;
    std::unique_ptr<TemporaryFile> file;
    run_on_all(ranks_, [&] {
      if (!is_alone_ && static_cast<std::size_t>(ranks_.rank()) == writer_) file = write_copy(bytes);
    });
    const std::string path = gather_texts(ranks_, file ? file->path().string() : "")[writer_];
    std::shared_ptr<const std::byte> mapped;
    run_on_all(ranks_, [&] {
      if (!path.empty()) mapped = map_file(path, bytes.size());
    });
    return mapped;
  }

 private:
  Communicator& ranks_;
  std::size_t writer_ = 0;  // the first rank on this machine
  bool is_alone_ = true;    // on it
};

}  // namespace

KeepBytes copy_of_machine(Communicator& ranks) {
  return [copy = CopyOfMachine(ranks)](std::span<const std::byte> bytes) { return copy.keep(bytes); };
}

}  // namespace tetloom
