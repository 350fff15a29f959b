#include "mesher/tets/small_polyhedron.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "core/base/mix_bits.hpp"
#include "mesher/tets/segment_triangle.hpp"
#include "mesher/tets/simplex_numbers_detail.hpp"

namespace tetloom::tets {

namespace {

using Face = std::array<std::uint8_t, 3>;
using Edge = std::array<std::uint8_t, 2>;
using Quad = std::array<std::uint8_t, 4>;

enum Known : std::uint8_t { Unknown, No, Yes };

// What lies behind a front face when a tet is put on it.
struct Candidate {
  std::uint8_t apex;
  double rank;
};

class TetSearch {
 public:
  TetSearch(const SmallPolyhedron& polyhedron, std::uint64_t max_steps)
      : in_(polyhedron),
        count_(static_cast<std::uint32_t>(polyhedron.points.size())),
        max_steps_(max_steps),
        signs_(quads(count_), 2),
        fits_(quads(count_), Unknown),
        edge_free_(pairs(count_), Unknown),
        face_free_(triples(count_), Unknown),
        edge_uses_(pairs(count_), 0),
        face_uses_(triples(count_), 0),
        front_(triples(count_) * 2, 0) {
    result_.face_to_dead_ends.assign(in_.faces.size(), 0);
    origin_.assign(triples(count_) * 2, 0xffffffffu);
  }

  SmallFilling run() {
    for (std::uint32_t i = 0; i < in_.faces.size(); ++i) {
      const Face& f = in_.faces[i];
      origin_[side_of(f)] = i;
      if (!add_front(f)) return result_;  // the same side twice
      if (face_uses_[number(f)]++ == 0) faces_.push_back(f);
      for (int k = 0; k < 3; ++k) use_edge(f[k], f[(k + 1) % 3]);
    }
    for (const Edge& e : in_.edges) use_edge(e[0], e[1]);
    given_edges_ = edges_.size();
    given_faces_ = faces_.size();
    find_free_points();
    const bool found = extend();
    result_.outcome = found ? SmallFilling::Found : gave_up_ ? SmallFilling::GivenUp : SmallFilling::Impossible;
    if (!found) result_.tets.clear();
    return result_;
  }

 private:
  // -- numbers of simplices -------------------------------------------------------------------------------------
  std::uint32_t number(const Face& f) const { return triple_number(f[0], f[1], f[2]); }
  std::uint32_t side_of(const Face& f) const { return number(f) * 2 + (is_even(f[0], f[1], f[2]) ? 0 : 1); }

  int sign(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    std::array<std::uint32_t, 4> v{a, b, c, d};
    const int parity = sort_with_parity(v);
    std::int8_t& known = signs_[quad_number(v)];
    if (known == 2)
      known =
          static_cast<std::int8_t>(orient3d(in_.points[v[0]], in_.points[v[1]], in_.points[v[2]], in_.points[v[3]]));
    return parity * known;
  }

  bool meets(const Edge& e, const Face& f) {
    ++result_.steps;
    return segment_meets_triangle(
        [this](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) { return sign(a, b, c, d); },
        [this](std::uint32_t v) -> const Vec3& { return in_.points[v]; }, e[0], e[1], {f[0], f[1], f[2]});
  }

  // -- what is there --------------------------------------------------------------------------------------------
  bool add_front(const Face& f) {
    if (front_[side_of(f)] != 0) return false;
    front_list_.push_back(f);
    front_[side_of(f)] = static_cast<std::uint32_t>(front_list_.size());
    hash_ ^= mix_bits(side_of(f) + 1);
    return true;
  }
  void remove_front(const Face& f) {
    const std::uint32_t at = front_[side_of(f)] - 1;
    front_list_[at] = front_list_.back();
    front_[side_of(front_list_[at])] = at + 1;
    front_list_.pop_back();
    front_[side_of(f)] = 0;
    hash_ ^= mix_bits(side_of(f) + 1);
  }
  void use_edge(std::uint8_t a, std::uint8_t b) {
    if (edge_uses_[pair_number(a, b)]++ == 0) edges_.push_back({a, b});
  }

  void find_free_points() {
    std::vector<std::uint8_t> on_front(count_, 0);
    for (const Face& f : in_.faces) on_front[f[0]] = on_front[f[1]] = on_front[f[2]] = 1;
    for (std::uint8_t v = 0; v < count_; ++v) {
      if (on_front[v] == 0) free_points_.push_back(v);
    }
  }

  // -- what fits with the given faces and edges, whatever else there is ------------------------------------------
  bool edge_fits(std::uint8_t a, std::uint8_t b) {
    std::uint8_t& known = edge_free_[pair_number(a, b)];
    if (known == Unknown) {
      known = Yes;
      for (std::size_t i = 0; i < given_faces_ && known == Yes; ++i) {
        if (meets({a, b}, faces_[i])) known = No;
      }
    }
    return known == Yes;
  }
  bool face_fits(const Face& f) {
    std::uint8_t& known = face_free_[number(f)];
    if (known == Unknown) {
      known = Yes;
      for (std::size_t i = 0; i < given_edges_ && known == Yes; ++i) {
        if (meets(edges_[i], f)) known = No;
      }
    }
    return known == Yes;
  }
  bool holds_free_point(const Quad& t) {
    for (const std::uint8_t v : free_points_) {
      if (std::find(t.begin(), t.end(), v) != t.end()) continue;
      if (sign(t[0], t[1], t[2], v) >= 0 && sign(t[0], t[2], t[3], v) >= 0 && sign(t[0], t[3], t[1], v) >= 0 &&
          sign(t[1], t[3], t[2], v) >= 0)
        return true;
    }
    return false;
  }
  // Pre: positive volume.
  bool fits_given(const Quad& t) {
    std::array<std::uint32_t, 4> v{t[0], t[1], t[2], t[3]};
    sort_with_parity(v);
    std::uint8_t& known = fits_[quad_number(v)];
    if (known != Unknown) return known == Yes;
    bool fits = true;
    for (int i = 0; i < 4 && fits; ++i) {
      for (int j = i + 1; j < 4 && fits; ++j) fits = edge_fits(t[i], t[j]);
    }
    for (int i = 0; i < 4 && fits; ++i) fits = face_fits(inner_face(t, i));
    fits = fits && !holds_free_point(t);
    known = fits ? Yes : No;
    return fits;
  }

  // -- what fits now --------------------------------------------------------------------------------------------
  bool fits_now(const Quad& t) {
    for (int i = 1; i < 4; ++i) {  // face 0 is the one it stands on
      const Face f = inner_face(t, i);
      if (face_uses_[number(f)] != 0) {
        if (front_[side_of(f)] == 0) return false;
        continue;
      }
      for (std::size_t k = given_edges_; k < edges_.size(); ++k) {
        if (meets(edges_[k], f)) return false;
      }
    }
    for (int i = 0; i < 3; ++i) {
      if (edge_uses_[pair_number(t[i], t[3])] != 0) continue;
      for (std::size_t k = given_faces_; k < faces_.size(); ++k) {
        if (meets({t[i], t[3]}, faces_[k])) return false;
      }
    }
    return true;
  }

  std::size_t find_candidates(const Face& f, std::size_t fewer_than, std::vector<Candidate>& found) {
    found.clear();
    for (std::uint8_t v = 0; v < count_; ++v) {
      if (v == f[0] || v == f[1] || v == f[2] || sign(f[0], f[1], f[2], v) <= 0) continue;
      const Quad t{f[0], f[1], f[2], v};
      if (!fits_given(t) || !fits_now(t)) continue;
      found.push_back({v, 0});
      if (found.size() >= fewer_than) break;
    }
    return found.size();
  }

  // The height of the circumcentre over the face: the lowest has the empty sphere.
  double rank_of(const Face& f, std::uint8_t apex) const {
    const Vec3 a = in_.points[f[0]], b = in_.points[f[1]] - a, c = in_.points[f[2]] - a, d = in_.points[apex] - a;
    const Vec3 normal = cross(b, c);
    const double area2 = norm2(normal), height = dot(normal, d);
    const Vec3 center = (norm2(b) * cross(c, normal) + norm2(c) * cross(normal, b)) / (2 * area2);
    return (norm2(d) - 2 * dot(center, d)) / height;
  }

  // -- the search -----------------------------------------------------------------------------------------------
  bool extend() {
    if (front_list_.empty()) return free_points_used();
    if (failed_.contains(hash_)) return false;
    Face best{};
    std::vector<Candidate> candidates, trial;
    std::size_t fewest = count_;
    for (std::size_t i = front_list_.size(); i-- > 0 && fewest > 1;) {
      if (find_candidates(front_list_[i], fewest, trial) >= fewest) continue;
      best = front_list_[i];
      fewest = trial.size();
      candidates.swap(trial);
      if (fewest == 0) break;
    }
    if (fewest == 0) note_dead_end(best);
    for (Candidate& c : candidates) c.rank = rank_of(best, c.apex);
    std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
      return a.rank != b.rank ? a.rank < b.rank : a.apex < b.apex;
    });
    for (const Candidate& c : candidates) {
      if (result_.steps > max_steps_) gave_up_ = true;
      if (gave_up_) return false;
      if (place_and_extend({best[0], best[1], best[2], c.apex})) return true;
    }
    if (!gave_up_) failed_.insert(hash_);
    return false;
  }

  bool place_and_extend(const Quad& t) {
    const std::size_t edges_before = edges_.size(), faces_before = faces_.size();
    const std::vector<Face> front_before = front_list_;
    for (int i = 0; i < 4; ++i) {
      const Face f = inner_face(t, i);
      if (front_[side_of(f)] != 0) {
        remove_front(f);
      } else {
        add_front({f[0], f[2], f[1]});
      }
      if (face_uses_[number(f)]++ == 0) faces_.push_back(f);
    }
    for (int i = 0; i < 3; ++i) use_edge(t[i], t[3]);
    result_.tets.push_back(t);
    if (extend()) return true;
    result_.tets.pop_back();
    for (int i = 0; i < 3; ++i) --edge_uses_[pair_number(t[i], t[3])];
    for (int i = 0; i < 4; ++i) --face_uses_[number(inner_face(t, i))];
    edges_.resize(edges_before);
    faces_.resize(faces_before);
    restore_front(front_before);
    return false;
  }

  void restore_front(const std::vector<Face>& before) {
    while (!front_list_.empty()) remove_front(Face(front_list_.back()));
    for (const Face& f : before) add_front(f);
  }

  bool free_points_used() const {
    return std::all_of(free_points_.begin(), free_points_.end(), [this](std::uint8_t v) {
      return std::any_of(result_.tets.begin(), result_.tets.end(),
                         [v](const Quad& t) { return std::find(t.begin(), t.end(), v) != t.end(); });
    });
  }

  void note_dead_end(const Face& f) {
    if (origin_[side_of(f)] != 0xffffffffu) ++result_.face_to_dead_ends[origin_[side_of(f)]];
  }

  const SmallPolyhedron& in_;
  std::uint32_t count_;
  std::uint64_t max_steps_;
  std::vector<std::int8_t> signs_;
  std::vector<std::uint8_t> fits_, edge_free_, face_free_;
  std::vector<std::uint16_t> edge_uses_, face_uses_;
  std::vector<std::uint32_t> front_, origin_;  // by side; place in front_list_ plus one, given face
  std::vector<Face> front_list_, faces_;       // faces_: all that are there, the given ones first
  std::vector<Edge> edges_;                    // likewise
  std::size_t given_edges_ = 0, given_faces_ = 0;
  std::vector<std::uint8_t> free_points_;
  std::unordered_set<std::uint64_t> failed_;
  std::uint64_t hash_ = 0;
  bool gave_up_ = false;
  SmallFilling result_;
};

}  // namespace

SmallFilling fill_small_polyhedron(const SmallPolyhedron& polyhedron, std::uint64_t max_steps) {
  return TetSearch(polyhedron, max_steps).run();
}

}  // namespace tetloom::tets
