#include "adapt/parts/share_verts.hpp"

#include <algorithm>

#include "adapt/transfer/field_transfer.hpp"

namespace tetloom::adapt {

namespace {

// The places in a slice of a share's vertices, as they were before umbrellas had vertices of their own.
std::vector<std::uint32_t> places_of(std::span<const Number> given, const WholeMesh& share, const ShareLinks& links,
                                     const TouchingVerts& touching) {
  std::vector<std::uint32_t> places;
  places.reserve(share.points.size());
  for (std::uint32_t v = 0; v < share.points.size(); ++v) {
    const ModelEntity entity = share.to_entity[v].unpack();
    const bool touches = !touching.verts.empty() && entity.valid() && entity.dim == 0 && entity.index >= touching.first;
    const Number number = touches ? touching.verts[entity.index - touching.first] : links.number_of(v);
    places.push_back(static_cast<std::uint32_t>(std::ranges::lower_bound(given, number) - given.begin()));
  }
  return places;
}

}  // namespace

std::vector<std::uint32_t> first_tets_of(std::span<const std::uint32_t> to_vert, std::size_t vert_count) {
  std::vector<std::uint32_t> firsts(vert_count, kNone);
  for (std::size_t i = 0; i < to_vert.size(); ++i)
    firsts[to_vert[i]] = std::min(firsts[to_vert[i]], static_cast<std::uint32_t>(i / 4));
  return firsts;
}

ShareVerts verts_of_share(const MeshSlice& slice, const SliceVerts& verts, const WholeMesh& share,
                          const ShareLinks& links, const TouchingVerts& touching,
                          const std::vector<std::string>& fields) {
  const auto given = std::span(slice.to_vert_number).first(verts.implied.size());
  const std::vector<std::uint32_t> places = places_of(given, share, links, touching);
  ShareVerts own;
  own.has_metric = slice.metric.size() > 0;
  for (const std::uint32_t v : places) {
    own.to_given.push_back(given[v]);
    if (own.has_metric) own.logs.push_back(slice.metric.logs[v]);
    own.implied.push_back(verts.implied[v]);
    own.to_start.push_back(slice.to_tet_number[verts.starts[v]]);
  }
  const std::vector<const MeshField*> carried = fields_named(slice.mesh.point_fields, fields);
  for (const MeshField* field : carried) own.components += static_cast<std::size_t>(field->components);
  own.fields.reserve(places.size() * own.components);
  for (const std::uint32_t v : places) {
    for (const MeshField* field : carried) {
      const auto n = static_cast<std::ptrdiff_t>(field->components), at = static_cast<std::ptrdiff_t>(v) * n;
      own.fields.insert(own.fields.end(), field->values.begin() + at, field->values.begin() + at + n);
    }
  }
  return own;
}

}  // namespace tetloom::adapt
