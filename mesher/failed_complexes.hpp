#pragma once
// What is set aside so that the rest of a model is meshed: the complexes in which something failed.
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

/// Complexes as of find_complexes: solids that share faces fail together.
class FailedComplexes {
 public:
  explicit FailedComplexes(const GeometricModel& model);

  /// Takes the complexes that the errors name, unless an error names none or there would be no other left. What is said
  /// of a complex that failed before is not kept again. Returns whether they were taken.
  bool take(const std::vector<Diagnostic>& errors);

  bool empty() const { return errors_.empty(); }
  const std::vector<Diagnostic>& errors() const { return errors_; }
  /// By model face: is it of a complex that failed?
  std::vector<bool> faces() const;

 private:
  std::vector<std::uint32_t> complexes_of(const Diagnostic& error) const;

  const GeometricModel& model_;
  std::vector<std::uint32_t> face_to_complex_;
  std::vector<std::vector<std::uint32_t>> edge_to_complexes_;
  std::vector<bool> failed_;  // by complex
  std::vector<Diagnostic> errors_;
};

}  // namespace tetloom
