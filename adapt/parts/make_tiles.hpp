#pragma once
// From shares of the mesh that adaptation starts from to its tiles.
#include <memory>
#include <span>

#include "adapt/metric/background_tiles.hpp"
#include "adapt/parts/share.hpp"
#include "adapt/parts/share_verts.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// The tets of all shares along a Hilbert curve, in tiles that each rank has an equal number of. Sets the hints of the
/// share's vertices to names of the tets of `to_start`. `faces`: as take_share gives them. A rank needs about 60 bytes
/// for each tet of its share while it makes them. Pre: shares before the first round. In SharedWork::together. Errors:
/// bad_alloc where there are too many tets for names of 30 bits.
std::unique_ptr<BackgroundTiles> make_tiles(WholeMesh& share, const ShareLinks& links,
                                            std::span<const FaceOutside> faces, const ShareVerts& verts,
                                            const ShareCells& cells, const SharedWork& work);

}  // namespace tetloom::adapt
