#include "tetloom/io.hpp"

#include <algorithm>
#include <cctype>
#include <functional>
#include <new>

#include "core/io/medit_detail.hpp"

namespace tetloom {
namespace detail {
namespace {

/// Items of a mesh whose values are wanted, in ascending order: some by number, or a range.
class WantedItems {
 public:
  explicit WantedItems(std::span<const std::uint64_t> numbers) : left_(numbers), count_(numbers.size()) {}
  WantedItems(std::uint64_t first, std::uint64_t count) : first_(first), count_(count) {}

  std::size_t count() const { return count_; }
  /// Whether `item` is one of them; to be asked for all items in turn.
  bool take(std::uint64_t item) {
    if (left_.empty()) return item >= first_ && item - first_ < count_;
    if (left_.front() != item) return false;
    left_ = left_.subspan(1);
    if (left_.empty()) count_ = 0;
    return true;
  }

 private:
  std::span<const std::uint64_t> left_;
  std::uint64_t first_ = 0, count_;
};

/// What is there for one carrier: its fields, how many items the mesh has, and which of them are wanted.
struct Carrier {
  const char* items;
  std::size_t expected;
  std::vector<MeshField>& fields;
  WantedItems wanted;
};

/// MEDIT's kinds of values: 1 scalar, 2 vector, 3 symmetric tensor, 4 matrix.
int components_of(const InputFile& file, std::int64_t kind, int dimension) {
  switch (kind) {
    case 1: return 1;
    case 2: return dimension;
    case 3: return dimension * (dimension + 1) / 2;
    case 4: return dimension * dimension;
    default:
      file.fail(ErrorCode::InputUnsuitable, "values of the kind " + std::to_string(kind) +
                                                " are unknown; 1 is a scalar, 2 a vector, 3 a symmetric tensor and 4 "
                                                "a matrix");
  }
}

class SolutionContent {
 public:
  /// `share`: what is wanted; null: all.
  SolutionContent(const InputFile& file, const SolutionSize& size, const SolutionShare* share)
      : file_(file), size_(size), share_(share) {}

  Carrier points() {
    return {"vertices", size_.points, solution_.point_fields,
            share_ ? WantedItems(share_->points) : WantedItems(0, size_.points)};
  }
  Carrier tets() {
    return {"tetrahedra", size_.tets, solution_.tet_fields,
            share_ ? WantedItems(share_->first_tet, share_->tets) : WantedItems(0, size_.tets)};
  }

  /// Adds fields of those components for `count` items, whose values are next(), item by item.
  template <class Next>
  void add(Carrier carrier, std::uint64_t count, const std::vector<int>& components, const Next& next) {
    if (count != carrier.expected)
      file_.fail(ErrorCode::InputUnsuitable, "the file has values at " + std::to_string(count) + " " + carrier.items +
                                                 ", but the mesh has " + std::to_string(carrier.expected));
    const std::size_t first = carrier.fields.size();
    for (const int each : components) {
      MeshField field{"solution_" + std::to_string(carrier.fields.size() + 1), each, {}};
      field.values.reserve(carrier.wanted.count() * static_cast<std::size_t>(each));
      carrier.fields.push_back(std::move(field));
    }
    for (std::uint64_t i = 0; i < count; ++i) {
      if (i % kRecordsBetweenLooks == 0) file_.check_cancelled(), file_.let_go();
      const bool is_wanted = carrier.wanted.take(i);
      for (std::size_t f = 0; f < components.size(); ++f) {
        for (int c = 0; c < components[f]; ++c) {
          const double value = next();
          if (is_wanted) carrier.fields[first + f].values.push_back(value);
        }
      }
    }
  }

  Solution finish() {
    if (solution_.point_fields.empty() && solution_.tet_fields.empty())
      file_.fail(ErrorCode::InputUnsuitable, "the file has no values at vertices or tetrahedra");
    return std::move(solution_);
  }

 private:
  const InputFile& file_;
  SolutionSize size_;
  const SolutionShare* share_;
  Solution solution_;
};

class SolutionText {
 public:
  SolutionText(const InputFile& file, const SolutionSize& size, const SolutionShare* share)
      : file_(file), words_(file), content_(file, size, share) {}

  Solution read() {
    for (;;) {
      const std::string_view keyword = words_.next_keyword();
      if (keyword == "End") return content_.finish();
      if (keyword == "MeshVersionFormatted") static_cast<void>(words_.parse<int>());
      if (keyword == "Dimension") dimension_ = words_.read_dimension();
      if (keyword == "SolAtVertices") read_values(content_.points());
      if (keyword == "SolAtTetrahedra") read_values(content_.tets());
    }
  }

 private:
  void read_values(const Carrier& carrier) {
    const std::uint64_t count = words_.read_count(2);
    const std::uint64_t kinds = words_.read_count(2);
    std::vector<int> components;
    for (std::uint64_t k = 0; k < kinds; ++k)
      components.push_back(components_of(file_, words_.parse<std::int64_t>(), dimension_));
    std::size_t reals = 0;
    for (const int each : components) reals += static_cast<std::size_t>(each);
    // The last number may end at the end of the file, without a separator.
    if (reals == 0 || count > words_.left() / (2 * reals) + 1)
      file_.fail_at_line("a count of " + std::to_string(count) + " exceeds the file", words_.at());
    content_.add(carrier, count, components, [&] { return words_.parse<double>(); });
  }

  const InputFile& file_;
  MeditWords words_;
  SolutionContent content_;
  int dimension_ = 3;
};

class SolutionBinary {
 public:
  SolutionBinary(const InputFile& file, const SolutionSize& size, const SolutionShare* share)
      : file_(file), sections_(file), content_(file, size, share) {}

  Solution read() {
    for (;;) {
      const std::int32_t code = sections_.next_section();
      if (code == kMeditEnd) return content_.finish();
      if (code == kMeditDimension) dimension_ = sections_.read_dimension();
      if (code == kSolAtVertices) read_values(content_.points());
      if (code == kSolAtTetrahedra) read_values(content_.tets());
    }
  }

 private:
  void read_values(const Carrier& carrier) {
    const std::uint64_t count = sections_.read_count();
    const auto kinds = static_cast<std::uint32_t>(sections_.read_word());
    sections_.cursor().expect(kinds, sizeof(std::int32_t));
    std::vector<int> components;
    for (std::uint32_t k = 0; k < kinds; ++k)
      components.push_back(components_of(file_, sections_.read_word(), dimension_));
    std::size_t reals = 0;
    for (const int each : components) reals += static_cast<std::size_t>(each);
    if (reals == 0) file_.fail("there are no kinds of values", sections_.cursor().at());
    sections_.expect(count, 0, reals);
    content_.add(carrier, count, components, [&] { return sections_.read_real(); });
  }

  const InputFile& file_;
  MeditSections sections_;
  SolutionContent content_;
  int dimension_ = 3;
};

}  // namespace

bool is_binary_solution(const std::filesystem::path& path) {
  if (!is_solution_extension(path))
    throw Error(ErrorCode::InvalidArgument,
                "'" + path.string() + "' is no file of solutions by its extension; known are .sol and .solb");
  return path.extension().string().size() == 5;
}

}  // namespace detail

bool is_solution_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".sol" || extension == ".solb";
}

namespace {

Solution read(const std::filesystem::path& path, const SolutionSize& size, const SolutionShare* share,
              const CancelToken* cancel) try {
  const bool binary = detail::is_binary_solution(path);
  const detail::InputFile file(path, cancel,
                               share == nullptr ? detail::FileAccess::InMemory : detail::FileAccess::Mapped);
  return binary ? detail::SolutionBinary(file, size, share).read() : detail::SolutionText(file, size, share).read();
} catch (const std::bad_alloc&) {
  throw Error(ErrorCode::OutOfMemory, "not enough memory to read '" + path.string() + "'");
}

}  // namespace

Solution read_solution(const std::filesystem::path& path, const SolutionSize& size, const CancelToken* cancel) {
  return read(path, size, nullptr, cancel);
}

Solution read_solution_at(const SolutionShare& share, const std::filesystem::path& path, const SolutionSize& size,
                          const CancelToken* cancel) {
  const auto& points = share.points;
  if (std::ranges::adjacent_find(points, std::greater_equal()) != points.end() ||
      (!points.empty() && points.back() >= size.points))
    throw Error(ErrorCode::InvalidArgument, "the numbers of points must ascend, and be below the number of points");
  if (share.first_tet > size.tets || share.tets > size.tets - share.first_tet)
    throw Error(ErrorCode::InvalidArgument, "the mesh does not have so many tets");
  return read(path, size, &share, cancel);
}

}  // namespace tetloom
