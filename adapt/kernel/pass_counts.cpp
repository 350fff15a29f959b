#include "tetloom/adapt.hpp"

namespace tetloom::adapt {

std::string_view to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::Done: return "done";
    case Verdict::Frozen: return "frozen";
    case Verdict::Classification: return "classification";
    case Verdict::TooLarge: return "too_large";
    case Verdict::Inverted: return "inverted";
    case Verdict::Quality: return "quality";
    case Verdict::Length: return "length";
    case Verdict::Surface: return "surface";
    case Verdict::NoGain: return "no_gain";
    case Verdict::Count: break;
  }
  return "";
}

}  // namespace tetloom::adapt
