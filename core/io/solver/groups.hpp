#pragma once
// The elements of each model entity, under the names that solvers' files give them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "tetloom/io.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::detail {

class ElementNodes;

/// Elements of one dimension that lie on one model entity, or on several that `EntityAttributes::group` makes one.
struct Group {
  std::string name;                     ///< see `solver_name`; no other group has it, whatever the case of its letters
  std::vector<std::uint32_t> tags;      ///< of the entities, ascending; 0 for elements without one
  std::vector<std::uint32_t> elements;  ///< ascending; numbers among all elements of the dimension
};

/// By dimension: points on model vertices; edges; triangles, then quadrilaterals; tets, pyramids, prisms, hexahedra.
/// Entities that have elements, ascending by their lowest tag.
using Groups = std::array<std::vector<Group>, 4>;

/// Names are those that `EntityAttributes::group` gives, then those of the entities, or "vertex_1", "edge_7",
/// "face_12", "region_3" by their tags. Where several have the same, the later ones get a number behind.
Groups make_groups(const Mesh& mesh);

/// The tags of the entities that have elements, by dimension, ascending; 0 where some elements have none.
using TagsByDim = std::array<std::vector<std::uint32_t>, 4>;
TagsByDim tags_with_elements(const Mesh& mesh);

/// The groups of entities with these tags, without their elements: for a mesh of which others hold the rest.
Groups name_groups(const EntityTable& entities, const TagsByDim& tags);

/// `named`, which has groups without elements, with those of `mesh`. Pre: its tags are among those of `named`.
Groups make_groups(const Mesh& mesh, Groups named);

/// As solver_names lists them.
std::vector<NamedGroup> list_names(const Groups& groups, const EntityTable& entities);

/// A name that Abaqus, CalculiX, OpenFOAM, SU2, Gmsh and Nastran take: letters, digits and underscores, the first one a
/// letter, at most 64 of them. Every run of other bytes becomes one underscore.
std::string solver_name(const std::string& name);

std::string lower_case(std::string text);

/// `name`, or `name` with the lowest number behind that makes it one of its own, whatever the case of letters; then it
/// is in `taken`, which holds names in lower case.
std::string own_name(const std::string& name, std::set<std::string>& taken);

/// The points of a group of edges, triangles and quadrilaterals, or cells, mid nodes as well, ascending.
std::vector<std::uint32_t> points_of(const Mesh& mesh, const ElementNodes& nodes, int dim, const Group& group);

/// Whether the triangles and quadrilaterals of a face have to be turned over to point out of the one region at it.
inline bool points_inwards(const Mesh& mesh, std::uint32_t face) {
  if (face >= mesh.face_to_sides.size()) return false;
  const FaceSides& sides = mesh.face_to_sides[face];
  return sides.front.valid() && !sides.back.valid();
}

/// The vertices of an element; of one of dimension 2 such that it points out of the one region at its face.
template <class Element>
Element turned_outwards(const Mesh& mesh, int dim, Element verts, std::uint32_t entity) {
  if (dim == 2 && points_inwards(mesh, entity)) std::reverse(verts.begin() + 1, verts.end());
  return verts;
}

}  // namespace tetloom::detail
