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

// Null where there is no such folder.
std::unique_ptr<TemporaryFile> make_file() {
  try {
    return std::make_unique<TemporaryFile>("arrays");
  } catch (const Error&) {
    return nullptr;
  }
}

// Puts bytes at a place of the file; false where there is no room.
bool write_at(const std::string& path, std::size_t place, std::span<const std::byte> bytes) {
  std::ofstream stream(path, std::ios::binary | std::ios::in);  // which leaves what is there
  stream.seekp(static_cast<std::streamoff>(place));
  stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  stream.close();  // where some file systems say that they are full
  return static_cast<bool>(stream);
}

class CopyOfMachine {
 public:
  explicit CopyOfMachine(Communicator& ranks) : ranks_(ranks) {
    if (ranks.rank_count() == 1) return;
    const std::vector<std::string> machines = gather_texts(ranks, machine_name());
    for (std::size_t rank = 0; rank < machines.size(); ++rank)
      if (machines[rank] == machines[static_cast<std::size_t>(ranks.rank())]) on_machine_.push_back(rank);
  }

  std::shared_ptr<const std::byte> keep(std::span<const std::byte> bytes) const {
    if (ranks_.rank_count() == 1 || bytes.size() < kLeastKept) return nullptr;
    const auto rank = static_cast<std::size_t>(ranks_.rank());
    std::unique_ptr<TemporaryFile> file;
    run_on_all(ranks_, [&] {
      if (on_machine_.size() > 1 && rank == on_machine_.front()) file = make_file();
    });
    const std::string path = gather_texts(ranks_, file ? file->path().string() : "")[on_machine_.front()];
    const std::vector<Bytes> are_written = all_gather(ranks_, [&](MessageWriter& writer) {
      const auto place = static_cast<std::size_t>(std::ranges::find(on_machine_, rank) - on_machine_.begin());
      const std::size_t begin = bytes.size() * place / on_machine_.size(),
                        end = bytes.size() * (place + 1) / on_machine_.size();
      writer.put(static_cast<std::uint8_t>(!path.empty() && write_at(path, begin, bytes.subspan(begin, end - begin))));
    });
    const bool is_whole = std::ranges::all_of(
        on_machine_, [&](std::size_t one) { return MessageReader(are_written[one]).get<std::uint8_t>() != 0; });
    std::shared_ptr<const std::byte> mapped;
    run_on_all(ranks_, [&] {
      if (is_whole) mapped = map_file(path, bytes.size());
    });
    return mapped;
  }

 private:
  Communicator& ranks_;
  std::vector<std::size_t> on_machine_;  // the ranks of this rank's machine, ascending
};

}  // namespace

KeepBytes copy_of_machine(Communicator& ranks) {
  return [copy = CopyOfMachine(ranks)](std::span<const std::byte> bytes) { return copy.keep(bytes); };
}

}  // namespace tetloom
