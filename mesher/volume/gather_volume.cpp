#include "mesher/volume/gather_volume.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include "core/base/page_size.hpp"
#include "mesher/volume/filling_messages.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {

namespace {

constexpr std::size_t kBlock = 1 << 16;  // items of one task

using volume::VolumePartView;

// Parts follow each other; the items of one are dealt to the threads. So points that several parts have are written one
// after the other.
class Assembly {
 public:
  Assembly(const VolumeInput& input, const TaskRunner& runner, VolumeMesh& mesh)
      : input_(input), runner_(runner), mesh_(mesh) {}

  void make_room(std::size_t new_points, std::size_t tets) {
    const std::size_t points = input_.points.size() + new_points;
    if (points >= std::numeric_limits<std::uint32_t>::max()) throw std::bad_alloc();
    reserve_touched(mesh_.new_points, points, runner_);
    mesh_.new_points.assign(input_.points.begin(), input_.points.end());
    mesh_.new_points.resize(points);
    reserve_touched(mesh_.tet_to_vert, tets, runner_);
    mesh_.tet_to_vert.resize(tets);
    reserve_touched(mesh_.tet_to_region, tets, runner_);
    mesh_.tet_to_region.resize(tets);
  }

  void add(const VolumePartView& part) {
    add_points(part);
    add_tets(part);
    add_triangles(part);
  }

  void finish() {
    std::ranges::sort(mesh_.moved_points, {}, &MovedPoint::point);
    const auto duplicates = std::ranges::unique(mesh_.moved_points, {}, &MovedPoint::point);
    mesh_.moved_points.erase(duplicates.begin(), duplicates.end());
    std::ranges::sort(mesh_.changed_triangles, {}, &ChangedTriangle::triangle);
    const auto seen_twice = std::ranges::unique(mesh_.changed_triangles, {}, &ChangedTriangle::triangle);
    mesh_.changed_triangles.erase(seen_twice.begin(), seen_twice.end());
  }

 private:
  void add_points(const VolumePartView& part) {
    const std::uint64_t given = input_.points.size();
    runner_.for_blocks(part.points.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v)
        if (part.vert_to_number[v] >= given) mesh_.new_points[part.vert_to_number[v]] = part.points[v];
    });
    for (std::size_t v = 0; v < part.points.size(); ++v) {
      const std::uint64_t number = part.vert_to_number[v];
      if (number < given && input_.points[number] != part.points[v])
        mesh_.moved_points.push_back({static_cast<std::uint32_t>(number), part.points[v]});
    }
  }

  void add_tets(const VolumePartView& part) {
    runner_.for_blocks(part.tet_to_region.size(), kBlock, [&](std::size_t begin, std::size_t end) {
      for (std::size_t tet = begin; tet < end; ++tet) {
        for (std::size_t i = 0; i < 4; ++i)
          mesh_.tet_to_vert[next_tet_ + tet][i] = number_of(part, part.tet_to_vert[4 * tet + i]);
        mesh_.tet_to_region[next_tet_ + tet] = part.tet_to_region[tet];
      }
    });
    next_tet_ += part.tet_to_region.size();
  }

  void add_triangles(const VolumePartView& part) {
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
      const auto& [a, b, c] = part.tri_to_vert[i];
      const std::array<std::uint32_t, 3> verts{number_of(part, a), number_of(part, b), number_of(part, c)};
      if (input_.tri_to_vert[part.triangles[i]] != verts) mesh_.changed_triangles.push_back({part.triangles[i], verts});
    }
  }

  static std::uint32_t number_of(const VolumePartView& part, std::uint32_t vert) {
    return static_cast<std::uint32_t>(part.vert_to_number[vert]);
  }

  const VolumeInput& input_;
  const TaskRunner& runner_;
  VolumeMesh& mesh_;
  std::size_t next_tet_ = 0;
};

// Those of this rank, which are gone then; none on the first rank.
std::vector<Message> pack(VolumeParts& parts, const Communicator& communicator, const TaskRunner& runner) {
  std::vector<Message> messages;
  if (communicator.rank() == 0) return messages;
  const std::vector<PartId> own = communicator.parts_of_rank(parts.part_count);
  messages.resize(parts.parts.size());
  runner.for_each(messages.size(), [&](std::size_t i) {
    MessageWriter writer;
    volume::put_part(writer, parts.parts[i]);
    parts.parts[i] = {};
    messages[i] = {own[i], PartId(0), 0, writer.take()};
  });
  return messages;
}

}  // namespace

VolumeMesh gather_volume(const VolumeInput& input, VolumeParts&& parts, Communicator& communicator,
                         const TaskRunner& runner) {
  VolumeMesh mesh;
  mesh.errors = std::move(parts.errors);
  mesh.warnings = std::move(parts.warnings);
  mesh.figures = std::move(parts.figures);
  std::vector<Message> messages = exchange(
      communicator, [&] { return pack(parts, communicator, runner); }, [](PartId) { return 0; });
  run_on_first(communicator, [&] {
    const TaskRunner wide = runner.with_idle_threads(communicator.ranks_on_machine());
    // Parts of the first rank come first; the others have arrived by their numbers.
    std::vector<VolumePartView> views;
    for (const VolumePart& part : parts.parts) views.push_back(volume::view_of(part));
    for (const Message& message : messages) views.push_back(volume::get_view(message.bytes));
    std::size_t tets = 0;
    for (const VolumePartView& view : views) tets += view.tet_to_region.size();
    Assembly assembly(input, wide, mesh);
    assembly.make_room(parts.new_points, tets);
    for (std::size_t i = 0; i < views.size(); ++i) {
      assembly.add(views[i]);
      if (i < parts.parts.size()) {
        parts.parts[i] = {};
      } else {
        messages[i - parts.parts.size()] = {};
      }
    }
    assembly.finish();
  });
  return mesh;
}

}  // namespace tetloom
