#pragma once
// Private to this folder: the functions behind all_families().
#include "tests/support/families/family.hpp"

namespace tetloom::test {

using FamilyMaker = FamilyModel(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder);

// CAD models.
FamilyMaker make_fillets;      ///< of blocks, of radii down to nearly nothing
FamilyMaker make_steps;        ///< and chamfers of blocks, of any height
FamilyMaker make_slivers;      ///< faces and edges that Boolean operations leave where things almost touch
FamilyMaker make_gaps;         ///< faces that coincide, or do but for a gap
FamilyMaker make_overlaps;     ///< solids that interpenetrate a little
FamilyMaker make_sewn;         ///< faces that do not meet, sewn or left so
FamilyMaker make_transformed;  ///< parts that are scaled, mirrored or stretched
FamilyMaker make_threads;      ///< helical sweeps
FamilyMaker make_gears;
FamilyMaker make_tubes;       ///< thin ones, straight and bent
FamilyMaker make_profiles;    ///< long bars with round grooves
FamilyMaker make_assemblies;  ///< of parts that touch or nearly do

// Triangle surfaces.
FamilyMaker make_blobs;        ///< by marching over a grid
FamilyMaker make_noisy_blobs;  ///< the same with noise
FamilyMaker make_t_junctions;  ///< sides that are cut apart differently on both sides of an edge
FamilyMaker make_holes;        ///< blobs with facets missing
FamilyMaker make_dirt;         ///< blobs with duplicate, degenerate and turned facets
FamilyMaker make_exports;      ///< CAD models as facets

}  // namespace tetloom::test
