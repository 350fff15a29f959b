#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>

#include "core/base/codec.hpp"
#include "core/base/temporary_file.hpp"
#include "tetloom/partition.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLeastHeld = std::uint64_t{1} << 18;
constexpr double kShare = 1.5;  // of what each rank would hold if no two held the same

/// Reads on the first rank, and stores what was read, where that can be done. Reads on the others where not.
class RankReading {
 public:
  RankReading(const std::function<ModelDocument()>& read, Communicator& ranks, const BlockLoop& loop)
      : read_(read), ranks_(ranks), loop_(loop) {}

  ModelDocument run() {
    run_on_first(ranks_, [&] { read_and_store(); });
    share_place();
    if (path_.empty()) {
      run_on_all(ranks_, [&] {
        if (ranks_.rank() != 0) document_ = read_();
      });
      return std::move(*document_);
    }
    document_.reset();
    while (lacks_file()) hand_on();
    return std::move(*document_);
  }

 private:
  void read_and_store() {
    document_ = read_();
    try {
      file_.emplace("shapes");
      if (store_model(*document_, file_->path(), loop_))
        path_ = file_->path(), bytes_ = fs::file_size(path_);
      else
        file_.reset();
    } catch (const Error& error) {  // no room for it: then each rank has the model for itself
      if (error.code() != ErrorCode::OutputFailed) throw;
      file_.reset();
    }
  }

  void share_place() {
    share_from_first(
        ranks_,
        [&](MessageWriter& writer) {
          put_text(writer, path_.string());
          writer.put(bytes_);
        },
        [&](MessageReader& reader) {
          path_ = get_text(reader);
          bytes_ = reader.get<std::uint64_t>();
        });
  }

  /// Opens the file where this rank sees it; whether there is a rank that does not. The lowest such rank becomes next_.
  bool lacks_file() {
    run_on_all(ranks_, [&] {
      std::error_code none;
      if (document_ || fs::file_size(path_, none) != bytes_ || none) return;
      const double share = kShare * static_cast<double>(bytes_) / ranks_.rank_count();
      document_ = open_stored_model(path_, std::max(kLeastHeld, static_cast<std::uint64_t>(share)));
    });
    const std::uint8_t lacks = document_ ? 0 : 1;
    const std::vector<std::uint8_t> all = gather_lists<std::uint8_t>(ranks_, std::span(&lacks, 1));
    next_ = static_cast<std::size_t>(std::ranges::find(all, std::uint8_t{1}) - all.begin());
    return next_ < all.size();
  }

  /// The first rank sends the file to the next one that does not see it, which is on another machine and has a copy for
  /// all ranks there.
  void hand_on() {
    const std::vector<Bytes> sent = exchange(ranks_, [&](std::span<MessageWriter> writers) {
      if (ranks_.rank() != 0) return;
      std::ifstream stream(file_->path(), std::ios::binary);
      const std::span<char> room = writers[next_].put_room<char>(bytes_);
      if (!stream.read(room.data(), static_cast<std::streamsize>(room.size())))
        throw Error(ErrorCode::InputUnreadable, "'" + file_->path().string() + "' cannot be read again");
    });
    std::string place;
    run_on_all(ranks_, [&] {
      if (static_cast<std::size_t>(ranks_.rank()) != next_) return;
      file_.emplace("shapes");
      const std::span<const char> bytes = MessageReader(sent[0]).get_view<char>();
      std::ofstream stream(file_->path(), std::ios::binary);
      if (!stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush())
        throw Error(ErrorCode::OutputFailed, "'" + file_->path().string() + "' cannot be written");
      place = file_->path().string();
    });
    gather(
        ranks_, [&](MessageWriter& writer) { put_text(writer, place); },
        [&](MessageReader& reader) {
          if (const std::string text = get_text(reader); !text.empty()) path_ = text;
        });
  }

  const std::function<ModelDocument()>& read_;
  Communicator& ranks_;
  const BlockLoop& loop_;
  std::optional<ModelDocument> document_;
  std::optional<TemporaryFile> file_;  // of the first rank, and of the first on each other machine
  fs::path path_;                      // where this rank looks; empty: nothing is stored
  std::uint64_t bytes_ = 0;
  std::size_t next_ = 0;
};

}  // namespace

ModelDocument read_model_on_ranks(const std::function<ModelDocument()>& read, Communicator& communicator,
                                  const BlockLoop& loop) {
  if (communicator.rank_count() == 1) return read();
  return RankReading(read, communicator, loop).run();
}

}  // namespace tetloom
