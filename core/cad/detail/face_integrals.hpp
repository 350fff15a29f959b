#pragma once
// Areas of faces and volumes of solids by quadrature on the CAD surfaces themselves.
//
// Green's theorem turns an integral over the trimmed domain into one along the parameter curves, whose integrand is an
// integral along the other parameter (Gonzalez-Ochoa, McCammon & Peters 1998). Both are Gauss-Legendre sums over pieces
// on which curve and surface are smooth, so nothing is refined: about 1e-8 of the area of most faces of real parts,
// 1e-5 where parameter curves run unevenly. Cost: Gauss points along the boundary times those across the face.
//
// Private to core/cad. Thread safety: any number of threads, also on faces that share surfaces and curves.
#include <NCollection_DataMap.hxx>
#include <optional>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <TopTools_ShapeMapHasher.hxx>
#include <vector>

#include "tetloom/host.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::cad {

/// Of a face taken forward, whose loops have it on their left; loops the other way round count negative.
struct FaceIntegrals {
  double area = 0;    ///< model length²
  Vec3 area_vector;   ///< of the normals du x dv; model length²
  Vec3 origin;        ///< a point of the surface, to which `moment` refers
  double moment = 0;  ///< of (x - origin) · normal; model length³
};

/// Edges without a parameter curve count nothing. Faces without any wire cover the whole surface.
FaceIntegrals integrate_face(const TopoDS_Face& face);

/// Adds faces up to the volume that they enclose: positive where their normals point outwards.
class VolumeSum {
 public:
  void add(const FaceIntegrals& face, bool reversed);
  /// Independent of the origins of the faces where these are closed.
  double volume() const;

 private:
  struct Term {
    Vec3 origin, area_vector;
    double moment;
  };
  std::vector<Term> terms_;
};

/// Integrals by face as it lies without its location: instances of one part share them.
using KnownIntegrals = NCollection_DataMap<TopoDS_Shape, FaceIntegrals, TopTools_ShapeMapHasher>;

/// Those of the face as it lies in space; null where they are not known.
std::optional<FaceIntegrals> find_integrals(const KnownIntegrals& known, const TopoDS_Face& face);

/// The volume that the faces of a shape enclose, by their orientation in it; faces inside a solid count nothing. What
/// is not known is integrated on the threads of `loop`, and known afterwards.
double enclosed_volume(const TopoDS_Shape& shape, KnownIntegrals& known, const BlockLoop& loop);

}  // namespace tetloom::cad
