#include "mesher/surface/mesh_faces.hpp"

#include <memory>
#include <optional>

#include "mesher/surface/face_in_pieces.hpp"
#include "mesher/surface/face_messages.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

void rethrow_unless_of_face(const Error& error) {
  if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw error;
}

class FacesMesher {
 public:
  FacesMesher(const GeometricModel& model, std::span<const std::size_t> pending, const FaceSurroundings& surroundings,
              const SharedWork& work, std::vector<FaceMesh>& faces)
      : model_(model),
        pending_(pending),
        surroundings_(surroundings),
        work_(work),
        runner_(work.runner()),
        faces_(faces) {}

  void run() {
    runner_.begin_stage(Stage::Faces, pending_.size());
    cut_large_faces();
    mesh_tasks();
    for (CutFace& face : cut_) join_pieces(face);
    mesh_failed_whole();
  }

 private:
  struct CutFace {
    ModelFaceId id;
    std::unique_ptr<FaceInPieces> pieces;  ///< none: it is meshed whole
  };

  struct FaceTask {
    CutFace* face;
    std::size_t piece;
  };

  void cut_large_faces() {
    std::vector<std::optional<FaceCut>> cuts(pending_.size());
    std::vector<double> amounts;
    for (const std::size_t f : pending_) amounts.push_back(estimate_work(f));
    const auto cut = [&](std::size_t i) {
      try {
        cuts[i] = cut_large_face(model_, ModelFaceId(pending_[i]), surroundings_, runner_);
      } catch (const Error& error) {
        rethrow_unless_of_face(error);  // meshed whole, the face tells
      }
    };
    work_.for_each(amounts, {cut, [&](std::size_t i, MessageWriter& writer) { put_face_cut(writer, cuts[i]); },
                             [&](std::size_t i, MessageReader& reader) { cuts[i] = get_face_cut(reader); }});
    for (std::size_t i = 0; i < cuts.size(); ++i) {
      CutFace& face = cut_.emplace_back(ModelFaceId(pending_[i]), nullptr);
      if (cuts[i])
        face.pieces = std::make_unique<FaceInPieces>(model_, face.id, surroundings_, std::move(*cuts[i]), keep_going_);
    }
  }

  void mesh_tasks() {
    std::vector<FaceTask> tasks;
    std::vector<double> amounts;
    for (CutFace& face : cut_) {
      const std::size_t count = face.pieces ? face.pieces->piece_count() : 1;
      for (std::size_t piece = 0; piece < count; ++piece) {
        tasks.push_back({&face, piece});
        amounts.push_back(face.pieces ? FaceInPieces::piece_work() : estimate_work(face.id.value));
      }
    }
    const auto make = [&](std::size_t i) {
      const auto& [face, piece] = tasks[i];
      face->pieces ? mesh_piece(*face, piece) : mesh_whole(face->id);
    };
    const auto put = [&](std::size_t i, MessageWriter& writer) {
      const auto& [face, piece] = tasks[i];
      face->pieces ? face->pieces->put_part(piece, writer) : put_face_mesh(writer, faces_[face->id.value]);
    };
    const auto take = [&](std::size_t i, MessageReader& reader) {
      const auto& [face, piece] = tasks[i];
      face->pieces ? face->pieces->take_part(piece, reader) : take_whole(face->id, reader);
    };
    work_.for_each(amounts, {make, put, take});
  }

  void mesh_piece(CutFace& face, std::size_t piece) {
    try {
      face.pieces->mesh_piece(piece);
    } catch (const Error& error) {
      rethrow_unless_of_face(error);
      face.pieces->fail_piece(piece);
    }
    runner_.check_cancelled();
  }

  void join_pieces(CutFace& face) {
    if (!face.pieces) return;
    std::optional<FaceMesh> mesh;
    try {
      work_.together([&] { mesh = face.pieces->join(work_); });
    } catch (const Error& error) {
      rethrow_unless_of_face(error);
    }
    if (!mesh) return;
    face.pieces.reset();
    faces_[face.id.value] = std::move(*mesh);
    runner_.advance(1, face.id);
  }

  void mesh_failed_whole() {
    std::vector<ModelFaceId> failed;
    std::vector<double> amounts;
    for (const CutFace& face : cut_) {
      if (!face.pieces) continue;
      failed.push_back(face.id);
      amounts.push_back(estimate_work(face.id.value));
    }
    work_.for_each(amounts,
                   {[&](std::size_t i) { mesh_whole(failed[i]); },
                    [&](std::size_t i, MessageWriter& writer) { put_face_mesh(writer, faces_[failed[i].value]); },
                    [&](std::size_t i, MessageReader& reader) { take_whole(failed[i], reader); }});
  }

  void mesh_whole(ModelFaceId face) {
    faces_[face.value] = mesh_guarded(face);
    runner_.check_cancelled();
    runner_.advance(1, face);
  }

  void take_whole(ModelFaceId face, MessageReader& reader) {
    faces_[face.value] = get_face_mesh(reader);
    runner_.advance(1, face);
  }

  // A face that throws is a face that fails; the others go on.
  FaceMesh mesh_guarded(ModelFaceId face) {
    try {
      return mesh_face(model_, face, surroundings_, keep_going_);
    } catch (const Error& error) {
      rethrow_unless_of_face(error);
      FaceMesh failed;
      failed.verdict = FaceVerdict::NotTriangulated;
      failed.message = error.what();
      if (error.diagnostic().point) failed.point = *error.diagnostic().point;
      return failed;
    }
  }

  // In triangles: the area grows with the square of the rim.
  double estimate_work(std::size_t face) const {
    constexpr double kTrianglesPerSquaredRim = 1 / 7.0;  // of a square
    double pieces = 0;
    for (const ModelLoop& loop : model_.topology().face_to_loops[face])
      for (const EdgeUse& use : loop) pieces += static_cast<double>(surroundings_.rim.mesh(use.edge).t.size());
    return kTrianglesPerSquaredRim * pieces * pieces;
  }

  const GeometricModel& model_;
  std::span<const std::size_t> pending_;
  const FaceSurroundings& surroundings_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  std::vector<FaceMesh>& faces_;
  const std::function<bool()> keep_going_ = [this] { return !runner_.cancelled(); };
  std::vector<CutFace> cut_;
};

}  // namespace

void mesh_faces(const GeometricModel& model, std::span<const std::size_t> pending, const FaceSurroundings& surroundings,
                const SharedWork& work, std::vector<FaceMesh>& faces) {
  FacesMesher(model, pending, surroundings, work, faces).run();
}

}  // namespace tetloom
