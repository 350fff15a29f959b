#pragma once
// Reading STEP without the repairs that OpenCASCADE's reader makes body by body; they are made afterwards, on all
// threads. Private to core/cad.
#include <memory>
#include <TopoDS_Shape.hxx>
#include <vector>

#include "core/cad/detail/isolated_face.hpp"

namespace tetloom::cad {

/// A body as the reader hands it over: its faces may lack parameter curves, seams and degenerate edges.
struct RawBody {
  TopoDS_Shape shape;
  FixPrecision precision;
};

/// While it lives, the readers leave bodies as they are and list them. Bodies whose faces belong to several shells are
/// repaired at once, as ever. For the thread that holds the ReadingSession.
class DeferredFixing {
 public:
  DeferredFixing();
  ~DeferredFixing();
  DeferredFixing(const DeferredFixing&) = delete;
  DeferredFixing& operator=(const DeferredFixing&) = delete;

  std::vector<RawBody> take();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tetloom::cad
