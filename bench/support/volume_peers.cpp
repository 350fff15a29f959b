#include "bench/support/volume_peers.hpp"

#include <fstream>
#include <stdexcept>
#include <vector>

#include "bench/support/child_process.hpp"
#include "bench/support/peer.hpp"
#include "tetloom/io.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;

/// TetGen's own format; what it writes as MEDIT counts triangles that it leaves out.
Mesh read_node_and_ele(const fs::path& node_path) {
  std::ifstream nodes(node_path), tets(fs::path(node_path).replace_extension(".ele"));
  Mesh mesh;
  std::size_t count = 0, number = 0;
  std::string rest;
  nodes >> count&& std::getline(nodes, rest);
  mesh.points.resize(count);
  for (Vec3& x : mesh.points) nodes >> number >> x.x >> x.y >> x.z&& std::getline(nodes, rest);
  tets >> count&& std::getline(tets, rest);
  mesh.tet_to_vert.resize(count);
  for (auto& [a, b, c, d] : mesh.tet_to_vert) tets >> number >> a >> b >> c >> d;
  if (!nodes || !tets) throw std::runtime_error("cannot read '" + node_path.string() + "'");
  mesh.point_to_entity.resize(mesh.points.size());
  mesh.tet_to_entity.resize(count);
  return mesh;
}

/// Netgen names its files as of version 2.000000, which is no version.
void mend_version(const fs::path& path) {
  std::fstream file(path, std::ios::in | std::ios::out);
  std::string line;
  std::getline(file, line);
  const auto place = file.tellg();
  std::getline(file, line);
  if (!line.starts_with("2.000000 ")) return;
  file.seekp(place);
  file << "2.2     ";
}

Mesh read_peer_mesh(const fs::path& path) {
  if (path.extension() == ".node") return read_node_and_ele(path);
  mend_version(path);
  return read_mesh(path);
}

/// Runs a peer that writes `mesh_path` and judges what it wrote.
std::string run_peer(const std::vector<std::string>& command, const fs::path& mesh_path, const PeerTask& peer,
                     VolumeSample& sample) {
  fs::remove(mesh_path);
  const ChildResult child = run_child(command);
  const std::size_t tail = child.output.size() > 1000 ? child.output.size() - 1000 : 0;
  if (child.exit_status != 0 || !fs::exists(mesh_path))
    throw std::runtime_error("a peer failed: " + command[0] + ": ..." + child.output.substr(tail));
  sample.peak_bytes = child.peak_bytes;
  Mesh mesh = read_peer_mesh(mesh_path);
  fs::remove(mesh_path);
  judge_volume(mesh, peer.sizes, sample);
  return child.output;
}

/// The model with a varying size, as a script for gmsh.
fs::path write_script(const PeerTask& peer) {
  const fs::path path = peer.folder / "wave.geo";
  std::ofstream file(path);
  file << "Merge \"" << peer.task.model.string() << "\";\nField[1] = MathEval;\nField[1].F = \""
       << peer.task.wave().expression() << "\";\nBackground Field = 1;\n"
       << "Mesh.CharacteristicLengthExtendFromBoundary = 0;\nMesh.CharacteristicLengthFromPoints = 0;\n"
       << "Mesh.CharacteristicLengthFromCurvature = 0;\n";
  return path;
}

/// Where netgen's libraries are: some packages leave the link out by which it loads one of them.
fs::path netgen_library() {
  for (const char* parent : {"/usr/lib", "/usr/local/lib"}) {
    if (!fs::is_directory(parent)) continue;
    for (const auto& entry : fs::directory_iterator(parent, fs::directory_options::skip_permission_denied)) {
      const fs::path library = entry.path() / "netgen/libgui.so.6.2";
      if (fs::exists(library)) return library;
    }
  }
  return {};
}

}  // namespace

VolumeSample measure_hxt(const PeerTask& peer) {
  const std::string low = exact_text(peer.task.wave().smallest), high = exact_text(peer.task.wave().largest());
  const fs::path input = peer.task.wave().is_uniform() ? peer.task.model : write_script(peer);
  const fs::path output = peer.folder / "hxt.msh";
  VolumeSample sample;
  const std::string said = run_peer({"gmsh", input, "-3", "-algo", "hxt", "-nt", std::to_string(peer.task.threads),
                                     "-bin", "-clmin", low, "-clmax", high, "-o", output},
                                    output, peer, sample);
  sample.seconds = number_behind(said, "Done meshing 3D (Wall ");
  sample.surface_seconds = number_behind(said, "Done meshing 2D (Wall ");
  return sample;
}

VolumeSample measure_tetgen(const PeerTask& peer, const fs::path& surface) {
  const fs::path output = fs::path(surface).replace_extension(".1.node");
  VolumeSample sample;
  const std::string said = run_peer({"tetgen", "-pYq1.4mF", surface}, output, peer, sample);
  sample.seconds = number_behind(said, "Total running seconds:") - number_behind(said, "Output seconds:");
  return sample;
}

VolumeSample measure_netgen(const PeerTask& peer) {
  const fs::path folder = peer.folder / "netgen", output = folder / "netgen.msh", library = netgen_library();
  fs::create_directories(folder);
  // A smallest size below h would let curvature decide, which this release cannot be told to leave alone.
  const std::string size = exact_text(peer.task.size);
  std::ofstream(folder / "ng.opt") << "options.meshsize " << size << "\noptions.minmeshsize " << size << '\n';
  std::vector<std::string> command{"env", "-C", folder};
  if (!library.empty()) {
    if (!fs::is_symlink(folder / "libgui.so")) fs::create_symlink(library, folder / "libgui.so");
    command.push_back("LD_LIBRARY_PATH=" + folder.string() + ":" + library.parent_path().string());
  }
  for (const char* word : {"netgen", "-batchmode", "-meshfiletype=Gmsh2 Format"}) command.emplace_back(word);
  command.push_back("-geofile=" + peer.task.model.string());
  command.push_back("-meshfile=" + output.string());
  VolumeSample sample;
  sample.seconds = number_behind(run_peer(command, output, peer, sample), "Meshing done, time =");
  return sample;
}

bool is_netgen_usable() { return is_installed("netgen"); }

}  // namespace tetloom::bench
