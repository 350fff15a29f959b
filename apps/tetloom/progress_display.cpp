#include "apps/tetloom/progress_display.hpp"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>

#include "apps/tetloom/quantities.hpp"

namespace tetloom::app {
namespace {

constexpr auto kRedrawInterval = std::chrono::milliseconds(100);
constexpr auto kLineInterval = std::chrono::seconds(2);
/// Before this much of a stage its rate says nothing about the rest.
constexpr double kLeastSecondsForRate = 0.3;
constexpr int kLeastBarWidth = 10, kMostBarWidth = 40, kStageWidth = 13;

std::string rate_and_rest(const StageProgress& progress) {
  if (progress.done == 0 || progress.seconds < kLeastSecondsForRate) return {};
  const double rate = static_cast<double>(progress.done) / progress.seconds;
  std::string text = format_short(rate) + "/s";
  if (progress.total > progress.done) {
    text += ", " + format_seconds(std::ceil(static_cast<double>(progress.total - progress.done) / rate)) + " left";
  }
  return text;
}

std::string whole_seconds(double seconds) {
  return seconds < 60 ? std::to_string(static_cast<int>(seconds)) + " s" : format_seconds(seconds);
}

std::string amounts(const StageProgress& progress, const char* separator) {
  if (progress.total == 0) return progress.done == 0 ? "" : format_short(static_cast<double>(progress.done));
  return format_short(static_cast<double>(progress.done)) + separator +
         format_short(static_cast<double>(progress.total));
}

int terminal_width(std::FILE* stream) {
  winsize size{};
  if (::ioctl(::fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0) return size.ws_col;
  return 80;
}

}  // namespace

std::string render_bar(const StageProgress& progress, int width) {
  std::string line(to_string(progress.stage));
  line.resize(std::max<std::size_t>(line.size(), kStageWidth), ' ');
  std::string tail = amounts(progress, "/");
  const std::string rate = rate_and_rest(progress);
  if (!rate.empty()) tail += "  " + rate;
  // Without a time left to show, the time gone shows that something happens.
  const bool waiting = progress.done == 0 && progress.seconds >= 1;
  if (progress.total == 0 || waiting) tail += (tail.empty() ? "" : "  ") + whole_seconds(progress.seconds);
  const int room = width - 1 - static_cast<int>(line.size() + tail.size()) - 2 - 2;
  if (progress.total > 0 && room >= kLeastBarWidth) {
    const int bar = std::min(room, kMostBarWidth);
    const double share = std::min(1.0, static_cast<double>(progress.done) / static_cast<double>(progress.total));
    const auto filled = static_cast<std::size_t>(share * bar);
    line += "[" + std::string(filled, '#') + std::string(static_cast<std::size_t>(bar) - filled, '.') + "]  ";
  }
  line += tail;
  // The last column stays free: some terminals wrap as soon as it is written.
  if (static_cast<int>(line.size()) > width - 1) line.resize(static_cast<std::size_t>(std::max(0, width - 1)));
  return line;
}

std::string render_line(const StageProgress& progress) {
  std::string line(to_string(progress.stage));
  const std::string amount = amounts(progress, " of ");
  const std::string rate = rate_and_rest(progress);
  if (progress.seconds > 0 && !amount.empty()) line += ": " + amount;
  if (!rate.empty()) line += ", " + rate;
  if (progress.seconds > 0 && progress.done == 0)
    line += (amount.empty() ? ": " : ", ") + whole_seconds(progress.seconds);
  return line;
}

ProgressDisplay::Style ProgressDisplay::style_for(std::FILE* stream, bool quiet) {
  if (quiet) return Style::Silent;
  const char* term = std::getenv("TERM");
  const bool dumb = term == nullptr || std::string_view(term) == "dumb";
  return ::isatty(::fileno(stream)) != 0 && !dumb ? Style::Bar : Style::Lines;
}

ProgressDisplay::ProgressDisplay(std::FILE* stream, Style style) : stream_(stream), style_(style) {
  if (style_ != Style::Silent) thread_ = std::thread(&ProgressDisplay::run, this);
}

ProgressDisplay::~ProgressDisplay() { finish(); }

void ProgressDisplay::update(const ProgressEvent& event) {
  if (style_ == Style::Silent) return;
  bool new_stage = false;
  {
    const std::lock_guard lock(mutex_);
    new_stage = stages_begun_ == 0 || event.stage != progress_.stage;
    if (new_stage) ++stages_begun_;
    // A stage that starts over, in a further round, has its own rate.
    if (new_stage || event.done < progress_.done) stage_start_ = Clock::now();
    progress_.stage = event.stage;
    progress_.done = event.done;
    progress_.total = event.total;
  }
  if (new_stage) changed_.notify_one();
}

void ProgressDisplay::finish() {
  std::thread drawing;
  {
    const std::lock_guard lock(mutex_);
    finished_ = true;
    drawing.swap(thread_);
  }
  changed_.notify_one();
  if (drawing.joinable()) drawing.join();
}

void ProgressDisplay::run() {
  std::unique_lock lock(mutex_);
  while (!finished_) {
    changed_.wait_for(lock, kRedrawInterval);
    if (stages_begun_ > 0 && !finished_) {
      lock.unlock();
      try {
        draw();
      } catch (const std::bad_alloc&) {
        // One picture less. The run says itself what it lacks memory for.
      }
      lock.lock();
    }
  }
  if (bar_visible_) {
    std::fputs("\r\033[K", stream_);
    std::fflush(stream_);
  }
}

void ProgressDisplay::draw() {
  StageProgress progress;
  unsigned begun = 0;
  {
    const std::lock_guard lock(mutex_);
    progress = progress_;
    progress.seconds = std::chrono::duration<double>(Clock::now() - stage_start_).count();
    begun = stages_begun_;
  }
  // A stage that comes again in a further round is nothing new to a log.
  const unsigned bit = 1u << static_cast<unsigned>(progress.stage);
  const bool new_stage = begun != stages_drawn_ && (stages_announced_ & bit) == 0;
  stages_drawn_ = begun;
  stages_announced_ |= bit;
  if (style_ == Style::Bar) {
    draw_bar(progress);
  } else {
    draw_line(progress, new_stage);
  }
}

void ProgressDisplay::draw_bar(const StageProgress& progress) {
  std::fprintf(stream_, "\r%s\033[K", render_bar(progress, terminal_width(stream_)).c_str());
  std::fflush(stream_);
  bar_visible_ = true;
}

void ProgressDisplay::draw_line(const StageProgress& progress, bool new_stage) {
  const auto now = Clock::now();
  if (!new_stage && now - last_line_ < kLineInterval) return;
  last_line_ = now;
  StageProgress shown = progress;
  if (new_stage) shown.seconds = 0;
  std::fprintf(stream_, "%s\n", render_line(shown).c_str());
  std::fflush(stream_);
}

}  // namespace tetloom::app
