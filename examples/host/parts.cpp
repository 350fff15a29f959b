// A program that has tetloom mesh a model in parts, lead the mesh to a metric, deal the result to other parts, and
// write it as a list of pieces.
//
//   tetloom-host-parts part.step part.pvtu 6
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <tetloom/adapt.hpp>
#include <tetloom/check.hpp>
#include <tetloom/communicator.hpp>
#include <tetloom/mesh.hpp>
#include <tetloom/model.hpp>
#include <tetloom/partition.hpp>
#include <tetloom/tasks.hpp>

namespace {

int fail(const std::vector<tetloom::Diagnostic>& errors) {
  for (const tetloom::Diagnostic& error : errors) std::cerr << to_string(error.code) << ": " << error.message << '\n';
  return 1;
}

// `size` at x = 0, and growing from there.
tetloom::adapt::MetricField metric_of(const tetloom::Mesh& mesh, double size) {
  std::vector<double> sizes;
  for (const tetloom::Vec3& x : mesh.points) sizes.push_back(size * (1 + 0.1 * std::abs(x.x) / size));
  return tetloom::adapt::metric_from_sizes(sizes, mesh.points);
}

double diagonal_of(const tetloom::Mesh& mesh) {
  tetloom::Box3 box;
  for (const tetloom::Vec3& x : mesh.points) box.add(x);
  return box.diagonal();
}

int run(const std::string& input, const std::string& output, std::size_t parts) {
  const tetloom::ModelDocument document = tetloom::read_model(input);
  const auto ranks = tetloom::make_thread_communicator();
  const tetloom::TaskRunner runner(0);
  tetloom::MeshOptions coarse;
  coarse.sizes.relative_size = 1.0 / 20;

  // In parts from the beginning to the file.
  coarse.parts = 3;
  tetloom::MeshInPartsResult dealt = make_mesh_in_parts(*document.model, coarse, *ranks);
  if (dealt.run.status != tetloom::MeshStatus::Ok) return fail(dealt.run.errors);
  deal_cells(*dealt.mesh, {.part_count = parts, .weights = {}}, runner);
  if (!validate_parts(*dealt.mesh, runner).valid()) return 1;
  std::cout << measure_parts(*dealt.mesh).elements << " cells in " << dealt.mesh->part_count() << " parts\n";

  // In one piece, adapted by all ranks, the result in parts.
  const tetloom::MeshResult whole = make_mesh_on_ranks(*document.model, coarse, *ranks);
  if (whole.status != tetloom::MeshStatus::Ok) return fail(whole.errors);
  tetloom::AdaptOptions options;
  options.model = document.model.get();
  options.parts = static_cast<int>(parts);
  const auto metric = metric_of(whole.mesh, diagonal_of(whole.mesh) / 40);
  const tetloom::AdaptInPartsResult adapted = adapt_mesh_in_parts(whole.mesh, metric, options, *ranks);
  if (adapted.run.status != tetloom::AdaptStatus::Ok) return fail(adapted.run.errors);
  write_parts(*adapted.mesh, output, runner);
  std::cout << measure_parts(*adapted.mesh).elements << " cells adapted, in " << adapted.mesh->part_count()
            << " parts, written to " << output << '\n';
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) {
    std::cerr << "usage: tetloom-host-parts MODEL PARTS.pvtu COUNT\n";
    return 2;
  }
  try {
    return run(argv[1], argv[2], std::strtoul(argv[3], nullptr, 10));
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
