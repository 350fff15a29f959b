#pragma once
// Private to core/io/solver: what reader and writer of Abaqus files share.
#include <array>

#include "core/io/element_nodes_detail.hpp"

namespace tetloom::detail {

/// Numbers of element faces, by kind of cell and by face in kCellShapes.
inline constexpr std::array<std::array<int, 6>, kCellKinds> kInpFaceNumbers{
    {{3, 4, 2, 1, 0, 0}, {1, 2, 3, 4, 5, 0}, {1, 2, 3, 4, 5, 0}, {1, 2, 3, 4, 5, 6}}};

}  // namespace tetloom::detail
