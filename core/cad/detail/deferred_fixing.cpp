#include "core/cad/detail/deferred_fixing.hpp"

#include <utility>
#include <XSAlgo.hxx>
#include <XSAlgo_AlgoContainer.hxx>

namespace tetloom::cad {
namespace {

/// Notes the bodies instead of repairing them.
class NotingContainer : public XSAlgo_AlgoContainer {
  DEFINE_STANDARD_RTTI_INLINE(NotingContainer, XSAlgo_AlgoContainer)
 public:
  explicit NotingContainer(std::vector<RawBody>& bodies) : bodies_(bodies) {}

  TopoDS_Shape ProcessShape(const TopoDS_Shape& shape, const double precision, const double largest_tolerance,
                            const Standard_CString resources, const Standard_CString sequence,
                            Handle(Standard_Transient) & info, const Message_ProgressRange& progress,
                            const Standard_Boolean shells_share_faces) const override {
    if (shells_share_faces)
      return XSAlgo_AlgoContainer::ProcessShape(shape, precision, largest_tolerance, resources, sequence, info,
                                                progress, shells_share_faces);
    if (!shape.IsNull()) bodies_.push_back({shape, {precision, largest_tolerance}});
    return shape;
  }

 private:
  std::vector<RawBody>& bodies_;
};

}  // namespace

struct DeferredFixing::State {
  std::vector<RawBody> bodies;
  Handle(XSAlgo_AlgoContainer) before;
};

DeferredFixing::DeferredFixing() : state_(std::make_unique<State>()) {
  state_->before = XSAlgo::AlgoContainer();
  XSAlgo::SetAlgoContainer(new NotingContainer(state_->bodies));
}

DeferredFixing::~DeferredFixing() { XSAlgo::SetAlgoContainer(state_->before); }

std::vector<RawBody> DeferredFixing::take() { return std::exchange(state_->bodies, {}); }

}  // namespace tetloom::cad
