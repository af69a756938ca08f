// A factor that is updated for a drive's length must stay the factor, in constant memory.
#include <malloc.h>

#include <random>
#include <vector>

#include "gp/linalg/incremental_cholesky.h"
#include "gtest/gtest.h"
#include "tests/gp/linalg/random_matrices.h"

// There only in programs under the undefined behaviour sanitizer.
extern "C" void __ubsan_handle_pointer_overflow() __attribute__((weak));

namespace egosieve::gp {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kCompiledForSanitizer = true;
#else
constexpr bool kCompiledForSanitizer = false;
#endif

// Sanitizers look for other faults, twenty times slower.
int64_t Updates() {
  const bool sanitized = kCompiledForSanitizer || &__ubsan_handle_pointer_overflow != nullptr;
  return sanitized ? 3000 : 100000;
}

constexpr int64_t kSize = 500;
constexpr int64_t kLargestBlock = 3;

// K over a fixed set of points: the model holds some of them, in the order in which they came.
class Endurance {
 public:
  Endurance(int64_t universe, std::mt19937_64& generator)
      : gram_(RandomGram(universe, 0.1, generator)) {}

  void AddRandom(int64_t count, std::mt19937_64& generator) {
    std::vector<int64_t> fresh;
    while (static_cast<int64_t>(fresh.size()) < count) {
      const int64_t point = static_cast<int64_t>(generator() % gram_.rows());
      if (!held_[point]) {
        held_[point] = true;
        fresh.push_back(point);
      }
    }
    RowMatrix below(count, points_.size()), corner(count, count);
    for (int64_t i = 0; i < count; ++i) {
      for (size_t j = 0; j < points_.size(); ++j) below(i, j) = gram_(fresh[i], points_[j]);
      for (int64_t j = 0; j < count; ++j) corner(i, j) = gram_(fresh[i], fresh[j]);
    }
    ASSERT_EQ(cholesky_.Append(ViewOf(below), ViewOf(corner)), absl::OkStatus());
    points_.insert(points_.end(), fresh.begin(), fresh.end());
  }

  void RemoveRandom(int64_t count, std::mt19937_64& generator) {
    const std::vector<int64_t> rows = RandomRows(cholesky_.size(), count, generator);
    ASSERT_TRUE(cholesky_.Remove(rows).ok());
    for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
      held_[points_[*row]] = false;
      points_.erase(points_.begin() + *row);
    }
  }

  int64_t size() const { return cholesky_.size(); }

  // |L L^T - K|_F / |K|_F.
  double RelativeError() const {
    const RowMatrix l = CopyOf(cholesky_.Factor());
    const RowMatrix k = Select(gram_, points_);
    return (l * l.transpose() - k).norm() / k.norm();
  }

 private:
  RowMatrix gram_;
  std::vector<char> held_ = std::vector<char>(gram_.rows(), 0);
  std::vector<int64_t> points_;
  IncrementalCholesky cholesky_;
};

TEST(IncrementalCholeskyEndurance, AHundredThousandMixedUpdates) {
  auto generator = TestGenerator();
  Endurance model(900, generator);
  model.AddRandom(kSize, generator);
  const int64_t updates = Updates();
  size_t memory_early = 0;
  for (int64_t update = 0; update < updates; ++update) {
    const int64_t count = 1 + static_cast<int64_t>(generator() % kLargestBlock);
    if (model.size() > kSize) {
      model.RemoveRandom(count, generator);
    } else {
      model.AddRandom(count, generator);
    }
    if (update == updates / 10) memory_early = mallinfo2().uordblks;
  }
  EXPECT_LE(mallinfo2().uordblks, memory_early + (1u << 16));
  EXPECT_LE(model.RelativeError(), 1e-13);
}

}  // namespace
}  // namespace egosieve::gp
