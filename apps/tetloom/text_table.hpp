#pragma once
// Columns of text.
#include <string>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::app {

/// Rows of cells under headings, indented, columns as wide as their widest cell and left out when all their cells are
/// empty. At most `most_rows` rows are shown, and how many more there are.
std::string render_table(const std::vector<std::string>& headings, const std::vector<std::vector<std::string>>& rows,
                         std::size_t most_rows);

/// "#rrggbb", or nothing. The colour is linear; the text is sRGB, as everywhere on screens.
std::string format_color(const std::optional<Color>& color);

/// "(0, 0, 0) to (1, 2, 3), diagonal 3.74166".
std::string format_box(const Box3& box);

}  // namespace tetloom::app
