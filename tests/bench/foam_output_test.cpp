// What OpenFOAM's programs print, read back.
#include "bench/support/foam_output.hpp"

#include <catch2/catch.hpp>
#include <stdexcept>

using namespace tetloom::bench;

TEST_CASE("checkMesh may complain of aspect ratios, and of nothing else") {
  const std::string head =
      "Mesh stats\n    points:           900\n    faces:            4000\n    cells:            1500\n";
  const FoamCheck fine = read_check_mesh(head +
                                         " ***High aspect ratio cells found, Max aspect ratio: 2000, number 12\n"
                                         "    Mesh non-orthogonality Max: 82.1 average: 20\n"
                                         "   *Number of severely non-orthogonal (> 70 degrees) faces: 8.\n"
                                         "    Max skewness = 2.75 OK.\n\nFailed 1 mesh checks.\n");
  CHECK(fine.is_fine);
  CHECK(fine.complaint.empty());
  CHECK(fine.non_orthogonal == Approx(0.002));
  CHECK(fine.skewness == 2.75);
  const FoamCheck skewed = read_check_mesh(head +
                                           " ***Max skewness = 7.5, 3 highly skew faces detected\n"
                                           " ***Zero or negative cell volume detected.\n");
  CHECK_FALSE(skewed.is_fine);
  CHECK(skewed.complaint.starts_with("Max skewness"));
  CHECK(skewed.skewness == 7.5);
}

TEST_CASE("snappyHexMesh tells its layers in the last of its tables") {
  SnappySample sample;
  read_snappy(
      "Snapped mesh : cells:100  faces:350  points:150\n"
      "patch faces    layers avg thickness[m]\n                  near-wall overall\n"
      "wall  90       8      0.05      0.6\n\n"
      "patch faces    layers   overall thickness\n                       [m]       [%]\n"
      "wall  90       5.5     0.31      42.5\n\nLayer mesh : cells:595  faces:1800  points:700\n",
      sample);
  CHECK(sample.cells == 595);
  CHECK(sample.layer_cells == 495);
  CHECK(sample.layers == 5.5);
  CHECK(sample.thickness == Approx(0.425));
  CHECK_THROWS_AS(read_snappy("FOAM FATAL ERROR", sample), std::runtime_error);
}
