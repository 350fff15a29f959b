#include "mesher/volume/gather_volume.hpp"

#include <algorithm>
#include <new>

#include "core/base/grain.hpp"
#include "core/base/page_size.hpp"
#include "mesher/volume/filling_messages.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {

namespace {

using volume::PartView;

// Parts follow each other; the items of one are dealt to the threads. So points that several parts have are written one
// after the other.
class VolumeAssembly {
 public:
  /// `first_new`: see VolumeParts.
  VolumeAssembly(Mesh& mesh, std::uint64_t first_new, const TaskRunner& runner)
      : mesh_(mesh), runner_(runner), given_(mesh.points.size()), first_new_(first_new) {}

  void make_room(std::size_t new_points, std::size_t tets) {
    const std::size_t points = given_ + new_points;
    if (points >= kNone) throw std::bad_alloc();
    make_room(mesh_.points, points);
    make_room(mesh_.point_to_entity, points);
    make_room(mesh_.tet_to_vert, tets);
    make_room(mesh_.tet_to_entity, tets);
  }

  void add(const PartView& part) {
    if (part.tet_to_region.empty()) return;
    add_points(part);
    add_tets(part);
    for (std::size_t i = 0; i < part.tri_to_vert.size(); ++i)
      mesh_.tri_to_vert[part.triangles[i / 3]][i % 3] = number_of(part, part.tri_to_vert[i]);
  }

 private:
  template <class T>
  void make_room(std::vector<T>& items, std::size_t count) {
    reserve_touched(items, count, runner_);
    items.resize(count);
  }

  // New points lie inside of the region of any tet that has them.
  void add_points(const PartView& part) {
    const std::uint32_t region = part.tet_to_region.front();
    runner_.for_blocks(part.points.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) {
        const std::uint32_t number = number_of(part, v);
        mesh_.points[number] = part.points[v];
        if (number >= given_) mesh_.point_to_entity[number] = ModelRegionId(region);
      }
    });
    if (std::ranges::count(part.tet_to_region, region) == std::ssize(part.tet_to_region)) return;
    for (std::size_t i = 0; i < part.tet_to_vert.size(); ++i)
      if (const std::uint32_t v = number_of(part, part.tet_to_vert[i]); v >= given_)
        mesh_.point_to_entity[v] = ModelRegionId(part.tet_to_region[i / 4]);
  }

  void add_tets(const PartView& part) {
    runner_.for_blocks(part.tet_to_region.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t tet = begin; tet < end; ++tet) {
        for (std::size_t i = 0; i < 4; ++i)
          mesh_.tet_to_vert[next_tet_ + tet][i] = number_of(part, part.tet_to_vert[4 * tet + i]);
        mesh_.tet_to_entity[next_tet_ + tet] = part.tet_to_region[tet];
      }
    });
    next_tet_ += part.tet_to_region.size();
  }

  // In the mesh.
  std::uint32_t number_of(const PartView& part, std::size_t vert) const {
    const std::uint64_t number = part.vert_to_global[vert];
    return static_cast<std::uint32_t>(number < given_ ? number : number - first_new_ + given_);
  }

  Mesh& mesh_;
  const TaskRunner& runner_;
  const std::size_t given_;
  const std::uint64_t first_new_;
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

void gather_volume(VolumeParts&& volume, Mesh& mesh, Communicator& communicator, const TaskRunner& runner) {
  std::vector<Message> messages = exchange(
      communicator, [&] { return pack(volume, communicator, runner); }, [](PartId) { return 0; });
  run_on_first(communicator, [&] {
    const TaskRunner wide = runner.with_idle_threads(communicator.ranks_on_machine());
    // Parts of the first rank come first; the others have arrived by their numbers.
    std::vector<PartView> views;
    for (const PartMesh& part : volume.parts) views.push_back(volume::view_of(part));
    for (const Message& message : messages) {
      MessageReader reader(message.bytes);
      views.push_back(volume::get_view(reader));
    }
    std::size_t tets = 0;
    for (const PartView& view : views) tets += view.tet_to_region.size();
    VolumeAssembly assembly(mesh, volume.first_new, wide);
    assembly.make_room(volume.new_points, tets);
    for (std::size_t i = 0; i < views.size(); ++i) {
      assembly.add(views[i]);
      if (i < volume.parts.size()) {
        volume.parts[i] = {};
      } else {
        messages[i - volume.parts.size()] = {};
      }
    }
  });
}

}  // namespace tetloom
