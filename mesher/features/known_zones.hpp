#pragma once
// What zones became before: one that is given again as it was becomes the same.
#include <map>
#include <memory>
#include <span>

#include "mesher/features/eliminate_in_zone.hpp"
#include "mesher/features/zones.hpp"

namespace tetloom::features {

/// A zone, and what was changed in it.
struct KnownZone {
  Zone zone;
  ZoneChange change;
};

/// Looked up by all that a zone's change depends on, so the result is that of doing it anew. Thread safety: as values.
class KnownZones {
 public:
  KnownZones() = default;
  explicit KnownZones(std::span<const std::shared_ptr<const KnownZone>> zones) {
    for (const auto& zone : zones) zones_.emplace(hash(zone->zone), zone);
  }
  /// Null where there is none. O(log n) and a comparison.
  std::shared_ptr<const KnownZone> find(const Zone& zone) const {
    const auto [begin, end] = zones_.equal_range(hash(zone));
    for (auto known = begin; known != end; ++known)
      if (known->second->zone == zone) return known->second;
    return nullptr;
  }

 private:
  std::multimap<std::uint64_t, std::shared_ptr<const KnownZone>> zones_;
};

}  // namespace tetloom::features
