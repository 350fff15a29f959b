// tetloom-demo-model: writes the CAD models that the quick start, the tests and the benches mesh.
#include <array>
#include <charconv>
#include <cstdio>
#include <exception>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <optional>
#include <span>
#include <Standard_Failure.hxx>
#include <string>
#include <string_view>
#include <vector>

#include "examples/make_demo_model/demo_models.hpp"

namespace tetloom::demo {
namespace {

/// One model that can be asked for.
struct Recipe {
  std::string_view name, short_name, what;
  std::string_view number_names;
  std::vector<int> numbers;  ///< what may follow the file's name, with the values used otherwise
  std::vector<DemoPart> (*make)(std::span<const int> numbers);
};

const std::array<Recipe, 7>& recipes() {
  static const std::array<Recipe, 7> all = {{
      {"machined-part",
       "part",
       "a bracket with fillets, holes, a pocket and a B-spline top face",
       "",
       {},
       [](std::span<const int>) { return make_machined_part(); }},
      {"assembly",
       "assembly",
       "a steel body in a rubber seal; they share faces after --imprint",
       "",
       {},
       [](std::span<const int>) { return make_assembly(); }},
      {"filleted-plate",
       "plate",
       "a plate with HOLES holes whose rims are rounded (30: 100 faces)",
       "HOLES",
       {30},
       [](std::span<const int> n) { return make_holed_plate(n[0]); }},
      {"spline-block",
       "spline",
       "SIDES x LEVELS wavy B-spline patches and two ends (5 4: 22 faces)",
       "SIDES LEVELS",
       {5, 4},
       [](std::span<const int> n) { return make_spline_body(n[0], n[1]); }},
      {"sphere",
       "ball",
       "a ball of radius RADIUS (50: 1 face)",
       "RADIUS",
       {50},
       [](std::span<const int> n) { return make_ball(n[0]); }},
      {"hollow-sphere",
       "shell",
       "an eighth of a hollow ball, with names (10 20: 5 faces)",
       "INNER OUTER",
       {10, 20},
       [](std::span<const int> n) { return make_hollow_sphere(n[0], n[1]); }},
      {"manifold",
       "pipe",
       "the inside of a pipe with BRANCHES branches, ends named (3; 0: a pipe)",
       "BRANCHES",
       {3},
       [](std::span<const int> n) { return make_manifold(n[0]); }},
  }};
  return all;
}

void print_usage(std::FILE* where) {
  std::fputs("usage: tetloom-demo-model MODEL FILE.step [NUMBERS]\n       tetloom-demo-model list\n\n", where);
  for (const Recipe& recipe : recipes()) {
    std::string name(recipe.name);
    if (!recipe.number_names.empty()) name += " [" + std::string(recipe.number_names) + "]";
    std::fprintf(where, "  %-29s %.*s\n", name.c_str(), static_cast<int>(recipe.what.size()), recipe.what.data());
  }
}

const Recipe* find_recipe(std::string_view name) {
  for (const Recipe& recipe : recipes()) {
    if (name == recipe.name || name == recipe.short_name) return &recipe;
  }
  return nullptr;
}

/// The recipe's own numbers, replaced by those given; nothing when one is not a number or there are too many.
std::optional<std::vector<int>> read_numbers(const Recipe& recipe, std::span<char* const> given) {
  std::vector<int> numbers = recipe.numbers;
  if (given.size() > numbers.size()) return std::nullopt;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const std::string_view text = given[i];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), numbers[i]);
    if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  }
  return numbers;
}

int refuse_usage(const std::string& why) {
  std::fprintf(stderr, "tetloom-demo-model: %s\n\n", why.c_str());
  print_usage(stderr);
  return 2;
}

int run(std::span<char* const> arguments) {
  if (arguments.size() == 1 && arguments[0] == std::string_view("list")) {
    for (const Recipe& recipe : recipes()) std::puts(std::string(recipe.name).c_str());
    return 0;
  }
  if (!arguments.empty() && (arguments[0] == std::string_view("--help") || arguments[0] == std::string_view("-h"))) {
    print_usage(stdout);
    return 0;
  }
  if (arguments.size() < 2) return refuse_usage("a model and a file are needed");
  const Recipe* recipe = find_recipe(arguments[0]);
  if (recipe == nullptr) return refuse_usage("there is no model '" + std::string(arguments[0]) + "'");
  const std::optional<std::vector<int>> numbers = read_numbers(*recipe, arguments.subspan(2));
  if (!numbers) return refuse_usage("what follows the file does not fit '" + std::string(recipe->name) + "'");
  const std::vector<DemoPart> parts = recipe->make(*numbers);
  check_parts(parts);
  write_step(parts, arguments[1]);
  return 0;
}

}  // namespace
}  // namespace tetloom::demo

int main(int argc, char** argv) {
  ::Message::DefaultMessenger()->ChangePrinters().Clear();
  try {
    return tetloom::demo::run(std::span<char* const>(argv + 1, static_cast<std::size_t>(argc > 0 ? argc - 1 : 0)));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tetloom-demo-model: %s\n", error.what());
  } catch (const Standard_Failure& failure) {
    std::fprintf(stderr, "tetloom-demo-model: OpenCASCADE: %s %s\n", failure.DynamicType()->Name(),
                 failure.GetMessageString());
  }
  return 1;
}
