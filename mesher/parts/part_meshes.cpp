#include "mesher/parts/part_meshes.hpp"

#include <algorithm>

#include "mesher/tets/triangle_verts.hpp"
#include "threading/agreement.hpp"
#include "threading/exchange.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

constexpr std::uint64_t kUnused = ~std::uint64_t{0};

// The vertices of a part that tets use, and their numbers in the complex.
struct Numbering {
  std::vector<std::uint64_t> to_number;  // of vertices; kUnused: no tet has it
  std::vector<std::uint64_t> made;       // of points made here, by index; kUnused: no tet of any part has it
};

class Numberer {
 public:
  Numberer(const SharedInput& input, const PerPart<PartState>& states, Communicator& communicator,
           const TaskRunner& runner)
      : states_(states),
        communicator_(communicator),
        runner_(runner),
        given_(input.filling.complex.points.size()),
        numberings_(states.part_count(), states.local()) {}

  // A part says which vertices it uses; whoever made them hears it, and answers with their numbers.
  std::uint64_t run() {
    std::vector<Message> used;
    run_on_all(communicator_, [&] { used = find_used(); });
    std::vector<Message> arrived = exchange_all(std::move(used));
    for (const Message& message : arrived)
      for (const VertKey key : MessageReader(message.bytes).get_view<VertKey>())
        numberings_.at(message.to).made[static_cast<std::uint32_t>(key)] = 0;
    const std::uint64_t count = number_made();
    for (Message& message : arrived) answer(message);
    std::vector<Message> answers = exchange_all(std::move(arrived));
    std::vector<std::span<const Message>> part_to_answers;
    auto begin = answers.begin();
    for (const PartId part : states_.local()) {
      const auto end = std::find_if(begin, answers.end(), [&](const Message& message) { return message.to != part; });
      part_to_answers.emplace_back(begin, end);
      begin = end;
    }
    run_on_all(communicator_, [&] {
      runner_.for_each(part_to_answers.size(),
                       [&](std::size_t i) { take_numbers(states_.local()[i], part_to_answers[i]); });
    });
    return count;
  }

  Numbering& of(PartId part) { return numberings_.at(part); }

 private:
  std::vector<Message> exchange_all(std::vector<Message> messages) {
    return exchange(communicator_, std::move(messages),
                    [&](PartId part) { return communicator_.rank_of(part, states_.part_count()); });
  }

  std::vector<Message> find_used() {
    const auto local = states_.local();
    std::vector<std::vector<Message>> part_to_messages(local.size());
    runner_.for_each(local.size(), [&](std::size_t i) { part_to_messages[i] = find_used_by(local[i]); });
    std::vector<Message> messages;
    for (auto& list : part_to_messages) std::move(list.begin(), list.end(), std::back_inserter(messages));
    return messages;
  }

  std::vector<Message> find_used_by(PartId part) {
    const PartState& state = states_.at(part);
    Numbering& numbering = numberings_.at(part);
    numbering.to_number.assign(state.keys.size(), kUnused);
    for (const std::uint32_t v : state.mesh.to_vert) numbering.to_number[v] = 0;
    numbering.made.assign(state.next_index, kUnused);
    std::vector<VertKey> foreign;
    for (std::size_t v = 0; v < state.keys.size(); ++v) {
      const VertKey key = state.keys[v];
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
  std::uint64_t number_made() {
    MessageWriter writer;
    for (const PartId part : states_.local()) {
      const auto& made = numberings_.at(part).made;
      writer.put(static_cast<std::uint64_t>(made.size()) -
                 static_cast<std::uint64_t>(std::count(made.begin(), made.end(), kUnused)));
    }
    std::vector<std::uint64_t> first{given_};
    for (const Bytes& bytes : communicator_.all_gather(writer.take()))
      for (MessageReader reader(bytes); !reader.at_end();) first.push_back(first.back() + reader.get<std::uint64_t>());
    for (const PartId part : states_.local()) {
      std::uint64_t next = first[part.value];
      for (std::uint64_t& number : numberings_.at(part).made)
        if (number != kUnused) number = next++;
    }
    return first.back() - given_;
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
    const PartState& state = states_.at(part);
    Numbering& numbering = numberings_.at(part);
    std::vector<std::pair<VertKey, std::uint32_t>> foreign;
    for (std::uint32_t v = 0; v < state.keys.size(); ++v) {
      std::uint64_t& number = numbering.to_number[v];
      if (number == kUnused) continue;
      const VertKey key = state.keys[v];
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

  const PerPart<PartState>& states_;
  Communicator& communicator_;
  const TaskRunner& runner_;
  const std::uint64_t given_;
  PerPart<Numbering> numberings_;
};

// The triangles of the surface among the faces of a part.
class TriangleFinder {
 public:
  TriangleFinder(const SharedInput& input, const PartState& state) : input_(input), state_(state) {
    for (const ChangedTriangle& changed : state.changed_triangles)
      changed_.emplace_back(tets::sorted(changed.verts).verts, &changed);
    std::sort(changed_.begin(), changed_.end());
  }

  // With vertices of the state.
  void find(VolumePart& part) const {
    std::vector<std::pair<std::uint32_t, TriangleVerts>> found;
    for (FaceCode face = 0; face < state_.mesh.to_neighbor.size(); ++face) {
      const FaceCode behind = state_.mesh.to_neighbor[face];
      if (state_.mesh.is_fixed(face) && (behind == kNone || face < behind)) found.push_back(triangle_at(face));
    }
    std::sort(found.begin(), found.end());
    for (const auto& [triangle, verts] : found) {
      if (!part.triangles.empty() && part.triangles.back() == triangle) continue;  // seen from both sides
      part.triangles.push_back(triangle);
      part.tri_to_vert.push_back(verts);
    }
  }

 private:
  // The face's triangle, its vertices in the order that the surface has them in.
  std::pair<std::uint32_t, TriangleVerts> triangle_at(FaceCode face) const {
    const TriangleVerts verts = verts_of(state_.mesh, face);
    TriangleVerts points;
    for (std::size_t i = 0; i < 3; ++i) points[i] = static_cast<std::uint32_t>(state_.keys[verts[i]]);
    const tets::SortedTriangle key = tets::sorted(points);
    std::pair<std::uint32_t, TriangleVerts> found{};
    TriangleVerts order{};
    const auto changed = std::lower_bound(changed_.begin(), changed_.end(), key.verts,
                                          [](const auto& entry, const auto& wanted) { return entry.first < wanted; });
    if (changed != changed_.end() && changed->first == key.verts) {
      found.first = changed->second->triangle;
      order = changed->second->verts;
    } else {
      const auto* entry = input_.triangles.find(key);
      TETLOOM_ASSERT(entry != nullptr);
      found.first = entry->triangle;
      order = input_.filling.complex.tri_to_vert[entry->triangle];
    }
    for (std::size_t i = 0; i < 3; ++i)
      found.second[i] =
          verts[static_cast<std::size_t>(std::find(points.begin(), points.end(), order[i]) - points.begin())];
    return found;
  }

  const SharedInput& input_;
  const PartState& state_;
  std::vector<std::pair<TriangleVerts, const ChangedTriangle*>> changed_;
};

// What a strip brings is joined to the part where the part is open. Two regions may so have vertices of their own at
// points of the surface between them; the first then stands for the others.
std::vector<std::uint32_t> find_twins(const PartState& state, const Numbering& numbering) {
  std::vector<std::pair<VertKey, std::uint32_t>> surface;
  std::vector<std::uint32_t> to_twin(state.keys.size());
  for (std::uint32_t v = 0; v < to_twin.size(); ++v) {
    to_twin[v] = v;
    if (is_of_surface(state.keys[v]) && numbering.to_number[v] != kUnused) surface.emplace_back(state.keys[v], v);
  }
  std::sort(surface.begin(), surface.end());
  for (std::size_t i = 1; i < surface.size(); ++i)
    if (surface[i].first == surface[i - 1].first) to_twin[surface[i].second] = to_twin[surface[i - 1].second];
  return to_twin;
}

VolumePart hand_on(const SharedInput& input, PartState& state, Numbering& numbering) {
  VolumePart part;
  TriangleFinder(input, state).find(part);
  TetMesh& mesh = state.mesh;
  std::vector<std::uint32_t> to_new = find_twins(state, numbering);
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (numbering.to_number[v] == kUnused) continue;
    if (to_new[v] != v) {
      to_new[v] = to_new[to_new[v]];
      continue;
    }
    to_new[v] = static_cast<std::uint32_t>(part.points.size());
    part.points.push_back(mesh.points[v]);
    part.vert_to_number.push_back(numbering.to_number[v]);
  }
  part.tet_to_vert = std::move(mesh.to_vert);
  part.tet_to_region = std::move(mesh.to_region);
  for (std::uint32_t& v : part.tet_to_vert) v = to_new[v];
  for (TriangleVerts& verts : part.tri_to_vert)
    for (std::uint32_t& v : verts) v = to_new[v];
  numbering = Numbering();
  state = PartState();
  return part;
}

}  // namespace

HandedOn hand_on_parts(const SharedInput& input, PerPart<PartState>& states, Communicator& communicator,
                       const TaskRunner& runner) {
  Numberer numberer(input, states, communicator, runner);
  HandedOn result;
  result.new_points = numberer.run();
  const auto local = states.local();
  result.parts.resize(local.size());
  run_on_all(communicator, [&] {
    runner.for_each(local.size(), [&](std::size_t i) {
      result.parts[i] = hand_on(input, states.at(local[i]), numberer.of(local[i]));
    });
  });
  return result;
}

}  // namespace tetloom::parts
