#include "core/cad/detail/brep_check.hpp"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

namespace tetloom::cad {
namespace {

struct Damage {
  std::string what;
};

/// Reads words and numbers of a text; throws Damage where there is none.
class Scanner {
 public:
  explicit Scanner(const std::string& text) : at_(text.c_str()), begin_(at_), end_(at_ + text.size()) {}

  long integer(long lo, long hi) {
    char* after = nullptr;
    const long value = std::strtol(at_, &after, 10);
    if (after == at_) fail("a whole number is missing");
    if (value < lo || value > hi) fail("a number is out of range");
    if (!is_space(*after) && *after != '\0' && *after != 'C' && *after != 'G') fail("a whole number is damaged");
    at_ = after;
    return value;
  }
  double real() {
    char* after = nullptr;
    const double value = std::strtod(at_, &after);
    if (after == at_ || (!is_space(*after) && *after != '\0')) fail("a number is missing or damaged");
    if (std::isnan(value)) fail("a number is not a number");
    at_ = after;
    return value;
  }
  void reals(long count) {
    for (long i = 0; i < count; ++i) real();
  }
  std::string_view word() {
    skip_space();
    const char* first = at_;
    while (at_ < end_ && !is_space(*at_)) ++at_;
    if (first == at_) fail("the file ends too early");
    return {first, static_cast<std::size_t>(at_ - first)};
  }
  std::string_view peek() {
    const char* here = at_;
    const std::string_view result = word();
    at_ = here;
    return result;
  }
  char letter() {
    skip_space();
    if (at_ == end_) fail("the file ends too early");
    return *at_++;
  }
  void expect(std::string_view text) {
    if (word() != text) fail(std::string(text) + " is missing");
  }
  /// A table cannot have more entries than the file has bytes left.
  long table(std::string_view name) {
    expect(name);
    return integer(0, bytes_left());
  }
  long bytes_left() const { return static_cast<long>(end_ - at_); }
  [[noreturn]] void fail(const std::string& what) const {
    throw Damage{what + " (byte " + std::to_string(at_ - begin_) + ")"};
  }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\n' || c == '\r' || c == '\t'; }
  void skip_space() {
    while (at_ < end_ && is_space(*at_)) ++at_;
  }

  const char* at_;
  const char* begin_;
  const char* end_;
};

class BrepWalker {
 public:
  explicit BrepWalker(const std::string& text) : in_(text) {}

  std::size_t walk() {
    read_header();
    read_locations();
    curves2d_ = in_.table("Curve2ds");
    for (long i = 0; i < curves2d_; ++i) read_curve(2, 0);
    curves_ = in_.table("Curves");
    for (long i = 0; i < curves_; ++i) read_curve(3, 0);
    read_polygons();
    surfaces_ = in_.table("Surfaces");
    for (long i = 0; i < surfaces_; ++i) read_surface(0);
    read_triangulations();
    shapes_ = in_.table("TShapes");
    for (long i = 0; i < shapes_; ++i) read_shape(i);
    if (shapes_ > 0) read_reference(in_.letter(), shapes_);
    return static_cast<std::size_t>(shapes_);
  }

 private:
  static constexpr int kDeepest = 16;  ///< of trimmed and offset curves and surfaces in each other
  static constexpr long kHighestDegree = 25;

  void read_header() {
    for (;;) {
      if (in_.word() != "CASCADE") continue;
      in_.expect("Topology");
      break;
    }
    const std::string_view version = in_.word();
    if (version.size() < 2 || version[0] != 'V' || version[1] < '1' || version[1] > '3') in_.fail("unknown version");
    version_ = version[1] - '0';
    while (in_.peek() != "Locations") in_.word();
  }

  void read_locations() {
    locations_ = in_.table("Locations");
    for (long i = 0; i < locations_; ++i) {
      if (in_.integer(1, 2) == 1) {
        in_.reals(12);
      } else {
        while (in_.integer(0, i) != 0) in_.integer(-1000000, 1000000);
      }
    }
  }

  void read_poles(long count, int dim, bool rational) {
    for (long i = 0; i < count; ++i) {
      in_.reals(dim);
      if (rational && !(in_.real() > 0)) in_.fail("the weight of a pole is not positive");
    }
  }

  void read_knots(long knots, long poles, long degree, bool periodic) {
    double last = -HUGE_VAL;
    long sum = 0;
    for (long i = 0; i < knots; ++i) {
      const double knot = in_.real();
      if (!(knot > last)) in_.fail("the knots of a spline do not ascend");
      last = knot;
      const long multiplicity = in_.integer(1, degree + 1);
      if (!periodic || i + 1 < knots) sum += multiplicity;
    }
    if (sum != (periodic ? poles : poles + degree + 1)) in_.fail("knots and poles of a spline do not fit");
  }

  void read_curve(int dim, int depth) {
    if (depth > kDeepest) in_.fail("curves are nested too deeply");
    const int frame = dim == 2 ? 6 : 12;  // point and axes of a conic
    switch (in_.integer(1, 9)) {
      case 1: in_.reals(2 * dim); break;
      case 2:
      case 4: in_.reals(frame + 1); break;
      case 3:
      case 5: in_.reals(frame + 2); break;
      case 6: {
        const bool rational = in_.integer(0, 1) == 1;
        read_poles(in_.integer(1, kHighestDegree) + 1, dim, rational);
        break;
      }
      case 7: {
        const bool rational = in_.integer(0, 1) == 1, periodic = in_.integer(0, 1) == 1;
        const long degree = in_.integer(1, kHighestDegree), poles = in_.integer(2, in_.bytes_left());
        const long knots = in_.integer(2, in_.bytes_left());
        read_poles(poles, dim, rational);
        read_knots(knots, poles, degree, periodic);
        break;
      }
      case 8: in_.reals(2), read_curve(dim, depth + 1); break;
      default: in_.reals(dim == 2 ? 1 : 4), read_curve(dim, depth + 1);
    }
  }

  void read_surface(int depth) {
    if (depth > kDeepest) in_.fail("surfaces are nested too deeply");
    switch (in_.integer(1, 11)) {
      case 1: in_.reals(12); break;
      case 2:
      case 4: in_.reals(13); break;
      case 3:
      case 5: in_.reals(14); break;
      case 6: in_.reals(3), read_curve(3, depth + 1); break;
      case 7: in_.reals(6), read_curve(3, depth + 1); break;
      case 8: {
        const bool u_rational = in_.integer(0, 1) == 1, v_rational = in_.integer(0, 1) == 1;
        const long u_degree = in_.integer(1, kHighestDegree), v_degree = in_.integer(1, kHighestDegree);
        read_poles((u_degree + 1) * (v_degree + 1), 3, u_rational || v_rational);
        break;
      }
      case 9: read_spline_surface(); break;
      case 10: in_.reals(4), read_surface(depth + 1); break;
      default: in_.reals(1), read_surface(depth + 1);
    }
  }

  void read_spline_surface() {
    const bool u_rational = in_.integer(0, 1) == 1, v_rational = in_.integer(0, 1) == 1;
    const bool u_periodic = in_.integer(0, 1) == 1, v_periodic = in_.integer(0, 1) == 1;
    const long u_degree = in_.integer(1, kHighestDegree), v_degree = in_.integer(1, kHighestDegree);
    const long u_poles = in_.integer(2, in_.bytes_left()), v_poles = in_.integer(2, in_.bytes_left() / u_poles);
    const long u_knots = in_.integer(2, in_.bytes_left()), v_knots = in_.integer(2, in_.bytes_left());
    read_poles(u_poles * v_poles, 3, u_rational || v_rational);
    read_knots(u_knots, u_poles, u_degree, u_periodic);
    read_knots(v_knots, v_poles, v_degree, v_periodic);
  }

  void read_polygons() {
    polygons_ = in_.table("Polygon3D");
    for (long i = 0; i < polygons_; ++i) {
      const long nodes = in_.integer(0, in_.bytes_left());
      const bool parameters = in_.integer(0, 1) == 1;
      in_.reals(1 + 3 * nodes + (parameters ? nodes : 0));
    }
    facet_polygons_ = in_.table("PolygonOnTriangulations");
    for (long i = 0; i < facet_polygons_; ++i) {
      const long nodes = in_.integer(0, in_.bytes_left());
      for (long n = 0; n < nodes; ++n) in_.integer(1, in_.bytes_left());
      in_.expect("p");
      in_.real();
      if (in_.integer(0, 1) == 1) in_.reals(nodes);
    }
  }

  void read_triangulations() {
    triangulations_ = in_.table("Triangulations");
    for (long i = 0; i < triangulations_; ++i) {
      const long nodes = in_.integer(0, in_.bytes_left()), triangles = in_.integer(0, in_.bytes_left());
      const bool uv = in_.integer(0, 1) == 1, normals = version_ >= 3 && in_.integer(0, 1) == 1;
      in_.reals(1 + 3 * nodes + (uv ? 2 * nodes : 0));
      for (long n = 0; n < 3 * triangles; ++n) in_.integer(1, nodes);
      if (normals) in_.reals(3 * nodes);
    }
  }

  void read_location() { in_.integer(0, locations_); }

  void read_shape(long known) {
    const std::string_view type = in_.word();
    if (type == "Ve")
      read_vertex();
    else if (type == "Ed")
      read_edge();
    else if (type == "Fa")
      read_face();
    else if (type != "Wi" && type != "Sh" && type != "So" && type != "CS" && type != "Co")
      in_.fail("unknown shape");
    const std::string_view flags = in_.word();
    if (flags.size() != 7 || flags.find_first_not_of("01") != std::string_view::npos) in_.fail("flags are missing");
    for (char sign = in_.letter(); sign != '*'; sign = in_.letter()) read_reference(sign, known);
  }

  /// Shapes are numbered from the end of the file, so that what a shape is made of stands before it.
  void read_reference(char sign, long known) {
    if (std::strchr("+-ie", sign) == nullptr) in_.fail("the orientation of a shape is missing");
    in_.integer(shapes_ - known + 1, shapes_);
    read_location();
  }

  void read_vertex() {
    in_.reals(4);
    for (;;) {
      in_.real();
      const long kind = in_.integer(0, 3);
      if (kind == 0) return;
      if (kind == 1) in_.integer(1, curves_);
      if (kind == 2) in_.integer(1, curves2d_), in_.integer(1, surfaces_);
      if (kind == 3) in_.real(), in_.integer(1, surfaces_);
      read_location();
    }
  }

  void read_edge() {
    in_.real();
    for (int i = 0; i < 3; ++i) in_.integer(0, 1);
    for (long kind = in_.integer(0, 7); kind != 0; kind = in_.integer(0, 7)) read_edge_part(kind);
  }

  void read_edge_part(long kind) {
    const int uv_ends = version_ == 2 ? 4 : 0;
    switch (kind) {
      case 1: in_.integer(0, curves_), read_location(), in_.reals(2); break;
      case 2: in_.integer(1, curves2d_), in_.integer(1, surfaces_), read_location(), in_.reals(2 + uv_ends); break;
      case 3:
        in_.integer(1, curves2d_), in_.integer(1, curves2d_), in_.word();
        in_.integer(1, surfaces_), read_location(), in_.reals(2 + uv_ends);
        break;
      case 4:
        in_.word();
        for (int side = 0; side < 2; ++side) in_.integer(1, surfaces_), read_location();
        break;
      case 5: in_.integer(1, polygons_), read_location(); break;
      default:
        in_.integer(1, facet_polygons_);
        if (kind == 7) in_.integer(1, facet_polygons_);
        in_.integer(1, triangulations_), read_location();
    }
  }

  void read_face() {
    in_.integer(0, 1);
    in_.real();
    in_.integer(0, surfaces_), read_location();
    if (in_.peek() == "2") in_.word(), in_.integer(1, triangulations_);
  }

  Scanner in_;
  int version_ = 1;
  long locations_ = 0, curves2d_ = 0, curves_ = 0, surfaces_ = 0;
  long polygons_ = 0, facet_polygons_ = 0, triangulations_ = 0, shapes_ = 0;
};

}  // namespace

std::string find_brep_damage(const std::string& text, std::size_t& shape_count) {
  try {
    shape_count = BrepWalker(text).walk();
    return "";
  } catch (const Damage& damage) {
    return damage.what;
  }
}

}  // namespace tetloom::cad
