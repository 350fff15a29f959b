#include "core/cad/detail/occt_guard.hpp"

#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <new>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>

namespace tetloom::cad {
namespace {

std::mutex& reader_mutex() {
  static std::mutex mutex;
  return mutex;
}

Error make_error(ErrorCode code, const std::string& message, const NamedEntity& who) {
  Diagnostic diagnostic;
  diagnostic.code = code;
  diagnostic.message = message;
  if (who.entity.valid()) diagnostic.entities.push_back(who);
  return Error(std::move(diagnostic));
}

std::string explain(const NamedEntity& who, const char* doing, const char* reason) {
  std::string text = std::string(doing) + " failed";
  if (who.entity.valid()) text += " on " + describe(who);
  if (reason && *reason) text += std::string(": ") + reason;
  return text;
}

}  // namespace

void rethrow_as_error(const NamedEntity& who, ErrorCode code, const char* doing) {
  try {
    throw;
  } catch (const Error& error) {
    if (!error.diagnostic().entities.empty() || !who.entity.valid()) throw;
    Diagnostic diagnostic = error.diagnostic();
    diagnostic.entities.push_back(who);
    throw Error(std::move(diagnostic));
  } catch (const Standard_OutOfMemory&) {
    throw make_error(ErrorCode::OutOfMemory, explain(who, doing, "out of memory"), who);
  } catch (const std::bad_alloc&) {
    throw make_error(ErrorCode::OutOfMemory, explain(who, doing, "out of memory"), who);
  } catch (const Standard_Failure& failure) {
    const char* text = failure.GetMessageString();
    throw make_error(code, explain(who, doing, text && *text ? text : failure.DynamicType()->Name()), who);
  } catch (const std::exception& failure) {
    throw make_error(code, explain(who, doing, failure.what()), who);
  }
}

ReadingSession::ReadingSession() : lock_(reader_mutex()) {
  printers_ = Message::DefaultMessenger()->Printers();
  Message::DefaultMessenger()->ChangePrinters().Clear();
}

ReadingSession::~ReadingSession() { Message::DefaultMessenger()->ChangePrinters() = printers_; }

}  // namespace tetloom::cad
