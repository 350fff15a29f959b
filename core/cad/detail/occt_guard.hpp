#pragma once
// How tetloom lives with OpenCASCADE: its failures become tetloom::Error, its messages go nowhere, its long calls can
// be cancelled, and its readers (which share global state) run one at a time.
//
// Private to core/cad.
#include <exception>
#include <Message_ProgressIndicator.hxx>
#include <Message_SequenceOfPrinters.hxx>
#include <mutex>
#include <string>

#include "tetloom/error.hpp"
#include "tetloom/host.hpp"

namespace tetloom::cad {

/// To be called inside a catch block: rethrows the exception in flight as an Error. A tetloom::Error passes unchanged
/// (it gets `who` when it names no entity), a failed allocation becomes OutOfMemory, anything else `code`.
[[noreturn]] void rethrow_as_error(const NamedEntity& who, ErrorCode code, const char* doing);

/// Runs `body`; whatever OpenCASCADE throws leaves as a tetloom::Error about `who`.
template <class Body>
auto translate_failures(const NamedEntity& who, ErrorCode code, const char* doing, Body&& body) -> decltype(body()) {
  try {
    return body();
  } catch (...) {
    rethrow_as_error(who, code, doing);
  }
}

/// Tells OpenCASCADE's algorithms to stop once the token is raised. A null token never stops.
class CancelIndicator : public Message_ProgressIndicator {
  DEFINE_STANDARD_RTTI_INLINE(CancelIndicator, Message_ProgressIndicator)
 public:
  explicit CancelIndicator(const CancelToken* token) : token_(token) {}
  Standard_Boolean UserBreak() override { return token_ && token_->cancelled(); }
  void Show(const Message_ProgressScope&, const Standard_Boolean) override {}

 private:
  const CancelToken* token_;
};

/// While it lives, this thread is the only reader and OpenCASCADE's default messenger is mute; afterwards the host's
/// printers are back.
class ReadingSession {
 public:
  ReadingSession();
  ~ReadingSession();
  ReadingSession(const ReadingSession&) = delete;
  ReadingSession& operator=(const ReadingSession&) = delete;

 private:
  std::unique_lock<std::mutex> lock_;
  Message_SequenceOfPrinters printers_;
};

}  // namespace tetloom::cad
