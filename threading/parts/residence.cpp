#include <algorithm>
#include <tuple>

#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/residence_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kBucketsPerRank = 64;

struct Candidate {
  std::uint64_t global;
  std::uint32_t vert;
  std::uint32_t padding = 0;
};

struct Claim {
  std::uint64_t global;
  PartId part;
  std::uint32_t padding = 0;
  friend auto operator<=>(const Claim& a, const Claim& b) {
    return std::tie(a.global, a.part) <=> std::tie(b.global, b.part);
  }
};

// Part `to` shares the vertex `global` with part `with`.
struct Answer {
  std::uint64_t global;
  PartId to, with;
  friend auto operator<=>(const Answer& a, const Answer& b) {
    return std::tie(a.to, a.global, a.with) <=> std::tie(b.to, b.global, b.with);
  }
};

std::vector<Candidate> find_candidates(const PartMesh& part) {
  std::vector<Candidate> candidates;
  std::vector<bool> seen(part.vertex_count(), false);
  for_each_open_face(part, [&](CellPlace face) {
    for (const std::uint32_t v : vertices_of_face(part, face)) {
      if (v == kNone || seen[v]) continue;
      seen[v] = true;
      candidates.push_back({part.vert_to_global[v], v});
    }
  });
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.global < b.global; });
  return candidates;
}

// The range of ids is cut into equal buckets, and these are dealt to ranks in blocks.
class Homes {
 public:
  Homes(Communicator& communicator, const PartitionedMesh& mesh, const PerPart<std::vector<Candidate>>& candidates)
      : count_(kBucketsPerRank * static_cast<std::size_t>(communicator.rank_count())) {
    std::uint64_t highest = 0;
    for (const PartId part : mesh.local())
      if (!candidates.at(part).empty()) highest = std::max(highest, candidates.at(part).back().global);
    gather(
        communicator, [&](MessageWriter& writer) { writer.put(highest); },
        [&](MessageReader& reader) { highest = std::max(highest, reader.get<std::uint64_t>()); });
    width_ = highest / count_ + 1;
  }
  std::size_t count() const { return count_; }
  int rank_of_bucket(std::size_t bucket) const { return static_cast<int>(bucket / kBucketsPerRank); }
  std::uint64_t begin_of(std::size_t bucket) const { return bucket * width_; }

 private:
  std::size_t count_;
  std::uint64_t width_ = 1;
};

using Claims = std::vector<std::vector<Claim>>;  // by bucket

Claims collect_claims(const PartitionedMesh& mesh, const PerPart<std::vector<Candidate>>& candidates,
                      const Homes& homes, const TaskRunner& runner) {
  Claims claims(homes.count());
  runner.for_each(claims.size(), [&](std::size_t bucket) {
    const auto before = [](const Candidate& a, std::uint64_t global) { return a.global < global; };
    for (const PartId part : mesh.local()) {
      const std::vector<Candidate>& own = candidates.at(part);
      auto it = std::lower_bound(own.begin(), own.end(), homes.begin_of(bucket), before);
      const auto end = std::lower_bound(it, own.end(), homes.begin_of(bucket + 1), before);
      for (; it != end; ++it) claims[bucket].push_back({it->global, part});
    }
  });
  return claims;
}

// Sends each bucket to its home rank; afterwards this rank holds all claims of its own buckets, and no others.
void send_claims_home(Communicator& communicator, const Homes& homes, Claims& claims) {
  const auto self = PartId(static_cast<std::size_t>(communicator.rank()));
  const auto rank_of = [](PartId rank) { return static_cast<int>(rank.value); };
  const auto pack = [&] {
    std::vector<Message> outgoing;
    for (std::size_t bucket = 0; bucket < claims.size(); ++bucket) {
      const auto home = PartId(static_cast<std::size_t>(homes.rank_of_bucket(bucket)));
      if (home == self || claims[bucket].empty()) continue;
      MessageWriter writer;
      writer.put_array(std::span<const Claim>(claims[bucket]));
      outgoing.push_back({self, home, static_cast<std::uint32_t>(bucket), writer.take()});
      claims[bucket] = std::vector<Claim>();
    }
    return outgoing;
  };
  for (const Message& message : exchange(communicator, pack, rank_of)) {
    const auto view = MessageReader(message.bytes).get_view<Claim>();
    claims[message.step].insert(claims[message.step].end(), view.begin(), view.end());
  }
}

std::vector<Answer> answer_claims(std::vector<Claim> claims) {
  std::sort(claims.begin(), claims.end());
  std::vector<Answer> answers;
  for (std::size_t begin = 0; begin < claims.size();) {
    std::size_t end = begin + 1;
    while (end < claims.size() && claims[end].global == claims[begin].global) ++end;
    for (std::size_t i = begin; i < end && end > begin + 1; ++i)
      for (std::size_t j = begin; j < end; ++j)
        if (i != j) answers.push_back({claims[i].global, claims[i].part, claims[j].part});
    begin = end;
  }
  std::sort(answers.begin(), answers.end());
  return answers;
}

using Answers = std::vector<std::vector<Answer>>;  // by bucket, each sorted by part and global id

// Brings the answers for parts of other ranks there, and those for this rank's parts here.
void send_answers_back(const PartitionedMesh& mesh, Answers& answers) {
  Communicator& communicator = *mesh.communicator;
  const auto self = PartId(static_cast<std::size_t>(communicator.rank()));
  const auto rank_of = [](PartId rank) { return static_cast<int>(rank.value); };
  const auto pack = [&] {
    std::vector<Message> outgoing;
    for (std::size_t bucket = 0; bucket < answers.size(); ++bucket) {
      std::vector<std::vector<Answer>> by_rank(static_cast<std::size_t>(communicator.rank_count()));
      for (const Answer& answer : answers[bucket])
        by_rank[static_cast<std::size_t>(communicator.rank_of(answer.to, mesh.part_count()))].push_back(answer);
      for (std::size_t rank = 0; rank < by_rank.size(); ++rank) {
        if (rank == self.value || by_rank[rank].empty()) continue;
        MessageWriter writer;
        writer.put_array(std::span<const Answer>(by_rank[rank]));
        outgoing.push_back({self, PartId(rank), static_cast<std::uint32_t>(bucket), writer.take()});
      }
      answers[bucket] = std::move(by_rank[self.value]);
    }
    return outgoing;
  };
  for (const Message& message : exchange(communicator, pack, rank_of)) {
    const auto view = MessageReader(message.bytes).get_view<Answer>();
    answers[message.step].insert(answers[message.step].end(), view.begin(), view.end());
  }
}

// Buckets ascend with global ids, so the residence comes out in order.
Residence read_residence(PartId part, std::span<const Candidate> candidates, const Answers& answers) {
  Residence residence;
  auto candidate = candidates.begin();
  const auto before = [](const Answer& a, PartId id) { return a.to < id; };
  for (const std::vector<Answer>& bucket : answers) {
    auto it = std::lower_bound(bucket.begin(), bucket.end(), part, before);
    for (; it != bucket.end() && it->to == part; ++it) {
      if (candidate == candidates.end() || residence.verts.empty() || candidate->global != it->global) {
        while (candidate->global != it->global) ++candidate;
        residence.verts.push_back(candidate->vert);
        residence.first.push_back(static_cast<std::uint32_t>(residence.parts.size()));
      }
      residence.parts.push_back(it->with);
    }
  }
  residence.first.push_back(static_cast<std::uint32_t>(residence.parts.size()));
  return residence;
}

}  // namespace

PerPart<Residence> find_residence(const PartitionedMesh& mesh, const TaskRunner& runner) {
  Communicator& communicator = *mesh.communicator;
  const std::span<const PartId> local = mesh.local();
  PerPart<std::vector<Candidate>> candidates(mesh.part_count(), local);
  runner.for_each(local.size(),
                  [&](std::size_t i) { candidates.at(local[i]) = find_candidates(mesh.parts.at(local[i]).mesh); });
  const Homes homes(communicator, mesh, candidates);
  Claims claims = collect_claims(mesh, candidates, homes, runner);
  if (communicator.rank_count() > 1) send_claims_home(communicator, homes, claims);
  Answers answers(claims.size());
  runner.for_each(claims.size(), [&](std::size_t b) { answers[b] = answer_claims(std::exchange(claims[b], {})); });
  if (communicator.rank_count() > 1) send_answers_back(mesh, answers);
  PerPart<Residence> residence(mesh.part_count(), local);
  runner.for_each(local.size(), [&](std::size_t i) {
    residence.at(local[i]) = read_residence(local[i], candidates.at(local[i]), answers);
  });
  return residence;
}

}  // namespace tetloom::detail
