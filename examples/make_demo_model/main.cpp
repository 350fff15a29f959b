// tetloom-demo-model: writes the CAD models that the quick start, the tests and the benches mesh.
#include <cstdio>
#include <cstdlib>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Standard_Failure.hxx>
#include <string>

#include "examples/make_demo_model/demo_models.hpp"

namespace {

constexpr const char* kUsage =
    "usage: tetloom-demo-model part FILE.step               a machined bracket\n"
    "       tetloom-demo-model assembly FILE.step           two materials that touch\n"
    "       tetloom-demo-model plate FILE.step [HOLES]      a plate with rounded holes; default 30\n"
    "       tetloom-demo-model spline FILE.step [SIDES LEVELS]\n"
    "                                                       B-spline faces only; default 5 and 4: 22 faces\n";

int number_argument(int argc, char** argv, int place, int otherwise) {
  return argc > place ? std::atoi(argv[place]) : otherwise;
}

std::vector<tetloom::demo::DemoPart> make_parts(int argc, char** argv) {
  using namespace tetloom::demo;
  const std::string kind = argv[1];
  if (kind == "part") return make_machined_part();
  if (kind == "assembly") return make_assembly();
  if (kind == "plate") return make_holed_plate(number_argument(argc, argv, 3, 30));
  if (kind == "spline") return make_spline_body(number_argument(argc, argv, 3, 5), number_argument(argc, argv, 4, 4));
  return {};
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fputs(kUsage, stderr);
    return 2;
  }
  Message::DefaultMessenger()->ChangePrinters().Clear();
  try {
    const std::vector<tetloom::demo::DemoPart> parts = make_parts(argc, argv);
    if (parts.empty()) {
      std::fputs(kUsage, stderr);
      return 2;
    }
    tetloom::demo::check_parts(parts);
    tetloom::demo::write_step(parts, argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tetloom-demo-model: %s\n", error.what());
    return 1;
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "tetloom-demo-model: OpenCASCADE: %s %s\n", failure.DynamicType()->Name(),
                 failure.GetMessageString());
    return 1;
  }
  return 0;
}
