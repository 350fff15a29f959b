#include "mesher/surface/copied_complexes.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "core/base/pairing.hpp"

namespace tetloom {
namespace {

// Of the model's diagonal: rounding of places far from the origin.
constexpr double kSamePlace = 1e-10;

// Pairs what bounds the faces of two complexes, from loop to loop.
class ComplexMatcher {
 public:
  ComplexMatcher(const GeometricModel& model, const RigidMotion& motion)
      : model_(model),
        topology_(model.topology()),
        motion_(motion),
        same_(kSamePlace * model.bounding_box().diagonal()) {}

  bool match(std::uint32_t face, std::uint32_t copy) {
    const auto &loops = topology_.face_to_loops[face], &copies = topology_.face_to_loops[copy];
    if (loops.size() != copies.size() || !match_sides(topology_.face_to_sides[face], topology_.face_to_sides[copy]))
      return false;
    for (std::size_t i = 0; i < loops.size(); ++i)
      if (!std::ranges::equal(loops[i], copies[i], [&](const EdgeUse& a, const EdgeUse& b) { return match(a, b); }))
        return false;
    return true;
  }

  std::vector<std::pair<ModelEdgeId, ModelEdgeId>> edges() const {
    std::vector<std::pair<ModelEdgeId, ModelEdgeId>> pairs;
    for (const auto& [edge, copy] : edges_.to_second()) pairs.emplace_back(edge, copy);
    return pairs;
  }

 private:
  bool match_sides(const FaceSides& a, const FaceSides& b) { return match(a.front, b.front) && match(a.back, b.back); }

  bool match(ModelRegionId a, ModelRegionId b) {
    return a.valid() == b.valid() && (!a.valid() || regions_.pair(a.value, b.value));
  }

  bool match(const EdgeUse& a, const EdgeUse& b) {
    if (a.forward != b.forward || a.second_side != b.second_side) return false;
    const ModelEdgeTopology &edge = topology_.edges[a.edge.value], &copy = topology_.edges[b.edge.value];
    return edges_.pair(a.edge.value, b.edge.value) && edge.degenerate == copy.degenerate &&
           match(edge.vertices[0], copy.vertices[0]) && match(edge.vertices[1], copy.vertices[1]);
  }

  bool match(ModelVertexId a, ModelVertexId b) {
    return vertices_.pair(a.value, b.value) &&
           distance(motion_(model_.vertex_point(a)), model_.vertex_point(b)) <= same_;
  }

  const GeometricModel& model_;
  const ModelTopology& topology_;
  const RigidMotion motion_;
  const double same_;
  Pairing regions_, edges_, vertices_;
};

class CopyFinder {
 public:
  CopyFinder(const GeometricModel& model, const std::vector<std::uint32_t>& face_to_complex)
      : model_(model), face_to_complex_(face_to_complex) {
    for (std::uint32_t f = 0; f < face_to_complex.size(); ++f) {
      if (complex_to_faces_.size() <= face_to_complex[f]) complex_to_faces_.resize(face_to_complex[f] + 1);
      complex_to_faces_[face_to_complex[f]].push_back(f);
      places_.push_back(model.place(ModelFaceId(f)));
    }
    find_shared();
  }

  std::vector<CopiedComplex> run() const {
    std::map<std::vector<std::uint32_t>, std::uint32_t> first;  // by the shapes of the faces
    std::vector<CopiedComplex> copies;
    for (std::uint32_t c = 0; c < complex_to_faces_.size(); ++c) {
      std::vector<std::uint32_t> shapes;
      for (const std::uint32_t f : complex_to_faces_[c]) shapes.push_back(places_[f].shape);
      if (is_shared_[c] || std::ranges::find(shapes, kNone) != shapes.end()) continue;
      const auto [known, is_new] = first.emplace(std::move(shapes), c);
      if (is_new) continue;
      if (auto copy = compare(known->second, c)) copies.push_back(std::move(*copy));
    }
    return copies;
  }

 private:
  // Complexes that meet others at an edge or a vertex.
  void find_shared() {
    const ModelTopology& topology = model_.topology();
    is_shared_.assign(complex_to_faces_.size(), false);
    std::vector<std::uint32_t> edge_to_complex(topology.edge_count(), kNone);
    std::vector<std::uint32_t> vertex_to_complex(topology.vertex_count, kNone);
    const auto note = [&](std::uint32_t& owner, std::uint32_t complex) {
      if (owner == kNone) owner = complex;
      if (owner != complex) is_shared_[owner] = is_shared_[complex] = true;
    };
    for (std::uint32_t f = 0; f < face_to_complex_.size(); ++f)
      for (const ModelLoop& loop : topology.face_to_loops[f])
        for (const EdgeUse& use : loop) {
          note(edge_to_complex[use.edge.value], face_to_complex_[f]);
          for (const ModelVertexId v : topology.edges[use.edge.value].vertices)
            note(vertex_to_complex[v.value], face_to_complex_[f]);
        }
  }

  std::optional<CopiedComplex> compare(std::uint32_t complex, std::uint32_t other) const {
    const auto &faces = complex_to_faces_[complex], &copies = complex_to_faces_[other];
    CopiedComplex copy{motion_between(faces[0], copies[0]), {}, {}};
    ComplexMatcher matcher(model_, copy.motion);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (!is_same(motion_between(faces[i], copies[i]), copy.motion) || !matcher.match(faces[i], copies[i]))
        return std::nullopt;
      copy.faces.emplace_back(faces[i], copies[i]);
    }
    copy.edges = matcher.edges();
    return copy;
  }

  RigidMotion motion_between(std::uint32_t face, std::uint32_t copy) const {
    return places_[copy].motion * places_[face].motion.inverse();
  }

  bool is_same(const RigidMotion& a, const RigidMotion& b) const {
    const Box3& box = model_.bounding_box();
    const double most = kSamePlace * box.diagonal();
    return distance(a(box.lo), b(box.lo)) <= most && distance(a(box.hi), b(box.hi)) <= most &&
           distance(a({box.lo.x, box.lo.y, box.hi.z}), b({box.lo.x, box.lo.y, box.hi.z})) <= most;
  }

  const GeometricModel& model_;
  const std::vector<std::uint32_t>& face_to_complex_;
  std::vector<std::vector<std::uint32_t>> complex_to_faces_;
  std::vector<FacePlace> places_;
  std::vector<bool> is_shared_;
};

}  // namespace

std::vector<CopiedComplex> find_copied_complexes(const GeometricModel& model,
                                                 const std::vector<std::uint32_t>& face_to_complex) {
  return CopyFinder(model, face_to_complex).run();
}

}  // namespace tetloom
