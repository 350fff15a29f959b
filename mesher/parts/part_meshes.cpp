#include "mesher/parts/part_meshes.hpp"

#include <algorithm>
#include <iterator>

#include "core/tets/triangle_verts.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

constexpr std::uint64_t kUnused = ~std::uint64_t{0};

// What is kept of a part's state: all of them are numbered before any of them is handed on.
struct FinishedPart {
  PartMesh part;  // by vertices of its tets
  GrowingArray<VertKey> keys;
  std::uint32_t next_index = 0;
};

// The vertices of a part that tets use, and their numbers in the complex.
struct Numbering {
  std::vector<std::uint64_t> to_number;  // of vertices; kUnused: no tet has it
  std::vector<std::uint64_t> made;       // of points made here, by index; kUnused: no tet of any part has it
};

class Numberer {
 public:
  Numberer(const AllParts& all, const PerPart<FinishedPart>& parts)
      : all_(all),
        parts_(parts),
        given_(all.input.filling.complex.points.size()),
        numberings_(parts.part_count(), parts.local()) {}

  // A part says which vertices it uses; whoever made them hears it, and answers with their numbers.
  void run() {
    std::vector<Message> arrived = all_.exchange([&] { return find_used(); });
    for (const Message& message : arrived)
      for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>())
        numberings_.at(message.to).made[static_cast<std::uint32_t>(key)] = 0;
    number_made();
    const std::vector<Message> answers = all_.exchange([&] {
      for (Message& message : arrived) answer(message);
      return std::move(arrived);
    });
    std::vector<std::span<const Message>> part_to_answers;
    auto begin = answers.begin();
    for (const PartId part : parts_.local()) {
      const auto end = std::find_if(begin, answers.end(), [&](const Message& message) { return message.to != part; });
      part_to_answers.emplace_back(begin, end);
      begin = end;
    }
    run_on_all(all_.communicator, [&] {
      all_.for_each_local("take numbers", [&](std::size_t i) { take_numbers(parts_.local()[i], part_to_answers[i]); });
    });
  }

  Numbering& of(PartId part) { return numberings_.at(part); }
  std::uint64_t new_points() const { return first_.back() - given_; }

 private:
  std::vector<Message> find_used() {
    const auto local = parts_.local();
    std::vector<std::vector<Message>> part_to_messages(local.size());
    all_.for_each_local("find used", [&](std::size_t i) { part_to_messages[i] = find_used_by(local[i]); });
    std::vector<Message> messages;
    for (auto& list : part_to_messages) std::move(list.begin(), list.end(), std::back_inserter(messages));
    return messages;
  }

  std::vector<Message> find_used_by(PartId part) {
    const FinishedPart& finished = parts_.at(part);
    Numbering& numbering = numberings_.at(part);
    numbering.to_number.assign(finished.keys.size(), kUnused);
    for (const std::uint32_t v : finished.part.block(CellKind::Tet).to_vert) numbering.to_number[v] = 0;
    numbering.made.assign(finished.next_index, kUnused);
    std::vector<VertKey> foreign;
    for (std::size_t v = 0; v < finished.keys.size(); ++v) {
      const VertKey key = finished.keys[v];
      if (numbering.to_number[v] == kUnused || is_of_surface(key)) continue;
      if (maker_of(key) == part) {
        numbering.made[static_cast<std::uint32_t>(key)] = 0;
      } else {
        foreign.push_back(key);
      }
    }
    std::sort(foreign.begin(), foreign.end());
    std::vector<Message> messages;
    for (auto begin = foreign.begin(); begin != foreign.end();) {
      const PartId maker = maker_of(*begin);
      const auto end = std::find_if(begin, foreign.end(), [&](VertKey key) { return maker_of(key) != maker; });
      MessageWriter writer;
      writer.put_array<VertKey>(std::span(begin, end));
      messages.push_back({part, maker, 0, writer.take()});
      begin = end;
    }
    return messages;
  }

  // By maker, then in the order in which they were made; behind the points of the complex.
  void number_made() {
    const auto local = parts_.local();
    std::vector<std::uint64_t> counts(local.size());
    run_on_all(all_.communicator, [&] {
      all_.for_each_local("count points", [&](std::size_t i) {
        counts[i] = static_cast<std::uint64_t>(
            std::ranges::count_if(numberings_.at(local[i]).made, [](auto number) { return number != kUnused; }));
      });
    });
    first_.assign(1, given_);
    for (const std::uint64_t count : gather_lists<std::uint64_t>(all_.communicator, counts))
      first_.push_back(first_.back() + count);
    run_on_all(all_.communicator, [&] {
      all_.for_each_local("number points", [&](std::size_t i) {
        std::uint64_t next = first_[local[i].value];
        for (std::uint64_t& number : numberings_.at(local[i]).made)
          if (number != kUnused) number = next++;
      });
    });
  }

  // The question becomes its answer.
  void answer(Message& message) {
    const std::vector<std::uint64_t>& made = numberings_.at(message.to).made;
    std::vector<std::uint64_t> numbers;
    for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>())
      numbers.push_back(made[static_cast<std::uint32_t>(key)]);
    MessageWriter writer;
    writer.put_array<std::uint64_t>(numbers);
    message = {message.to, message.from, 0, writer.take()};
  }

  // Answers come by maker, and so in the order of the keys that were asked.
  void take_numbers(PartId part, std::span<const Message> answers) {
    const FinishedPart& finished = parts_.at(part);
    Numbering& numbering = numberings_.at(part);
    std::vector<std::pair<VertKey, std::uint32_t>> foreign;
    for (std::uint32_t v = 0; v < finished.keys.size(); ++v) {
      std::uint64_t& number = numbering.to_number[v];
      if (number == kUnused) continue;
      const VertKey key = finished.keys[v];
      if (is_of_surface(key)) {
        number = key;
      } else if (maker_of(key) == part) {
        number = numbering.made[static_cast<std::uint32_t>(key)];
      } else {
        foreign.emplace_back(key, v);
      }
    }
    std::sort(foreign.begin(), foreign.end());
    std::size_t next = 0;
    for (const Message& message : answers)
      for (const std::uint64_t number : MessageReader(message.bytes).get_view<std::uint64_t>())
        numbering.to_number[foreign[next++].second] = number;
    TETLOOM_ASSERT(next == foreign.size());
  }

  const AllParts& all_;
  const PerPart<FinishedPart>& parts_;
  const std::uint64_t given_;
  PerPart<Numbering> numberings_;
  std::vector<std::uint64_t> first_;  // per part, and one past the last
};

// The triangles of the surface among the faces of a part.
class TriangleFinder {
 public:
  TriangleFinder(const SharedInput& input, const KeyedTets& part, std::span<const ChangedTriangle> all_changed)
      : input_(input), part_(part) {
    for (const ChangedTriangle& changed : all_changed)
      changed_.emplace_back(tets::sorted(changed.verts).verts, &changed);
    std::sort(changed_.begin(), changed_.end());
  }

  // With vertices of the part.
  void find(BoundaryBlock& triangles) const {
    std::vector<std::pair<std::uint32_t, TriangleVerts>> found;
    for (const FaceCode face : part_.mesh.faces()) {
      const FaceCode behind = part_.mesh.behind(face);
      if (part_.mesh.is_fixed(face) && (!behind.valid() || face < behind)) found.push_back(triangle_at(face));
    }
    std::sort(found.begin(), found.end());
    for (const auto& [triangle, verts] : found) {
      if (!triangles.to_entity.empty() && triangles.to_entity.back() == triangle) continue;  // seen from both sides
      triangles.to_entity.push_back(triangle);
      triangles.to_vert.append(verts);
    }
  }

 private:
  // The face's triangle, its vertices in the order that the surface has them in.
  std::pair<std::uint32_t, TriangleVerts> triangle_at(FaceCode face) const {
    const TriangleVerts verts = verts_of(part_.mesh, face);
    TriangleVerts points;
    for (std::size_t i = 0; i < 3; ++i) points[i] = static_cast<std::uint32_t>(part_.keys[verts[i]]);
    const tets::SortedTriangle key = tets::sorted(points);
    std::pair<std::uint32_t, TriangleVerts> found{};
    TriangleVerts order{};
    const auto changed = std::lower_bound(changed_.begin(), changed_.end(), key.verts,
                                          [](const auto& entry, const auto& wanted) { return entry.first < wanted; });
    if (changed != changed_.end() && changed->first == key.verts) {
      found.first = changed->second->triangle;
      order = changed->second->verts;
    } else {
      const auto triangle = input_.triangles.find(key);
      TETLOOM_ASSERT(triangle.has_value());
      found.first = *triangle;
      order = input_.filling.complex.tri_to_vert[*triangle];
    }
    for (std::size_t i = 0; i < 3; ++i)
      found.second[i] =
          verts[static_cast<std::size_t>(std::find(points.begin(), points.end(), order[i]) - points.begin())];
    return found;
  }

  const SharedInput& input_;
  const KeyedTets& part_;
  std::vector<std::pair<TriangleVerts, const ChangedTriangle*>> changed_;
};

// The state with all that is not needed any more is gone.
FinishedPart take_finished(const SharedInput& input, PartState& state) {
  FinishedPart finished;
  TriangleFinder(input, state.tets, state.changed_triangles).find(finished.part.block(BoundaryKind::Triangle));
  CellBlock& tets = finished.part.block(CellKind::Tet);
  finished.part.points = std::move(state.tets.mesh.points), finished.keys = std::move(state.tets.keys);
  tets.to_vert = std::move(state.tets.mesh.to_vert), tets.to_region = std::move(state.tets.mesh.to_region);
  finished.next_index = state.tets.next_index;
  state = PartState();
  return finished;
}

// What a strip brings is joined to the part where the part is open. Two regions may so have vertices of their own at
// points of the surface between them; the first then stands for the others.
std::vector<std::uint32_t> find_duplicates(const FinishedPart& finished, const Numbering& numbering) {
  std::vector<std::pair<VertKey, std::uint32_t>> surface;
  std::vector<std::uint32_t> to_first(finished.keys.size());
  for (std::uint32_t v = 0; v < to_first.size(); ++v) {
    to_first[v] = v;
    if (is_of_surface(finished.keys[v]) && numbering.to_number[v] != kUnused) surface.emplace_back(finished.keys[v], v);
  }
  std::sort(surface.begin(), surface.end());
  for (std::size_t i = 1; i < surface.size(); ++i)
    if (surface[i].first == surface[i - 1].first) to_first[surface[i].second] = to_first[surface[i - 1].second];
  return to_first;
}

PartMesh hand_on(FinishedPart& finished, Numbering& numbering) {
  PartMesh part = std::move(finished.part);
  std::vector<std::uint32_t> to_new = find_duplicates(finished, numbering);
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (numbering.to_number[v] == kUnused) continue;
    if (to_new[v] != v) {
      to_new[v] = to_new[to_new[v]];
      continue;
    }
    to_new[v] = static_cast<std::uint32_t>(part.vert_to_global.size());
    part.points[to_new[v]] = part.points[v];
    part.vert_to_global.push_back(numbering.to_number[v]);
  }
  part.points.resize_for_overwrite(part.vert_to_global.size());
  part.points.shrink_to_fit();
  for (GrowingArray<std::uint32_t>* verts :
       {&part.block(CellKind::Tet).to_vert, &part.block(BoundaryKind::Triangle).to_vert})
    for (std::uint32_t& v : *verts) v = to_new[v];
  numbering = Numbering();
  finished = FinishedPart();
  return part;
}

PerPart<FinishedPart> finish_all(const AllParts& all) {
  const auto local = all.states.local();
  PerPart<FinishedPart> finished(all.states.part_count(), local);
  run_on_all(all.communicator, [&] {
    all.for_each_local(
        "finish", [&](std::size_t i) { finished.at(local[i]) = take_finished(all.input, all.states.at(local[i])); });
  });
  return finished;
}

}  // namespace

void hand_on_parts(const AllParts& all, VolumeParts& volume) {
  const auto local = all.states.local();
  PerPart<FinishedPart> finished = finish_all(all);
  Numberer numberer(all, finished);
  numberer.run();
  volume.new_points = numberer.new_points();
  volume.part_count = all.states.part_count();
  volume.parts.resize(local.size());
  run_on_all(all.communicator, [&] {
    all.for_each_local("hand on",
                       [&](std::size_t i) { volume.parts[i] = hand_on(finished.at(local[i]), numberer.of(local[i])); });
  });
}

}  // namespace tetloom::parts
