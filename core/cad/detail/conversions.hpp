#pragma once
// Between OpenCASCADE's points and ours. Private to core/cad.
#include <gp_Pnt.hxx>
#include <gp_Pnt2d.hxx>
#include <gp_Vec.hxx>

#include "tetloom/vec.hpp"

namespace tetloom::cad {

inline Vec3 to_vec3(const gp_XYZ& p) { return {p.X(), p.Y(), p.Z()}; }
inline Vec3 to_vec3(const gp_Pnt& p) { return to_vec3(p.XYZ()); }
inline Vec3 to_vec3(const gp_Vec& v) { return to_vec3(v.XYZ()); }
inline Vec3 to_vec3(const gp_Dir& v) { return to_vec3(v.XYZ()); }
inline Vec2 to_vec2(const gp_XY& p) { return {p.X(), p.Y()}; }
inline Vec2 to_vec2(const gp_Pnt2d& p) { return to_vec2(p.XY()); }
inline gp_Pnt to_pnt(const Vec3& p) { return {p.x, p.y, p.z}; }

}  // namespace tetloom::cad
