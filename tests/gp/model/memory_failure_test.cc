// Models whose memory runs out in the middle of a change: they stay as they were.
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <new>
#include <vector>

#include "gp/model/exact_model.h"
#include "gp/model/sparse_model.h"
#include "gtest/gtest.h"
#include "kernels/ops/dense_posterior.h"
#include "tests/gp/learning_problems.h"

namespace {

// The allocations until one is refused; then 0, and all are granted, as where one is large.
thread_local int64_t allocations_left = 0;
thread_local bool was_refused = false;

bool Refused() {
  if (allocations_left == 0 || --allocations_left > 0) return false;
  was_refused = true;
  return true;
}

}  // namespace

void* operator new(size_t size) {
  void* memory = Refused() ? nullptr : std::malloc(std::max<size_t>(size, 1));
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }

// What gp/linalg/aligned_matrix.h takes its memory from.
extern "C" void* aligned_alloc(size_t alignment, size_t size) {
  void* memory = nullptr;
  return Refused() || posix_memalign(&memory, alignment, size) != 0 ? nullptr : memory;
}

namespace egosieve::gp {
namespace {

constexpr int64_t kDimension = 2;

// The reference: drivers allocate on threads of their own.
std::shared_ptr<kernels::Context> HostContext() {
  return *kernels::OpenContext({.device = "reference"});
}

// Fails the first allocation of `change`, then the second, and so on until it succeeds. After each
// failure `expect_unchanged` looks at the model. Returns the failures.
template <typename Change, typename Expect>
int FailEveryAllocation(const Change& change, const Expect& expect_unchanged) {
  for (int failures = 0;; ++failures) {
    bool done = false;
    was_refused = false;
    allocations_left = failures + 1;
    try {
      done = change().ok();
    } catch (const std::bad_alloc&) {
    }
    allocations_left = 0;
    EXPECT_EQ(done, !was_refused);
    if (done) return failures;
    expect_unchanged();
    if (testing::Test::HasFailure()) return failures;
  }
}

TEST(MemoryFailure, AnExactModelStaysWhole) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(90, kDimension, generator);
  const auto x = ViewOf(points.inputs);
  const std::vector<double> y = points.targets();
  const auto add = [&](ExactModel& model, int64_t begin, int64_t end) {
    return model.AddObservations(
        {x.rows_between(begin, end), absl::MakeConstSpan(y).subspan(begin, end - begin)}, begin);
  };
  ExactModel model = *ExactModel::Create(
      HostContext(), DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension));
  ASSERT_TRUE(add(model, 0, 60).ok());
  const std::vector<double> mean = model.PredictOwnMean();
  const RowMatrix factor = CopyOf(model.factor().Factor());
  const auto expect_unchanged = [&] {
    ASSERT_EQ(model.size(), 60);
    ASSERT_EQ(model.factor().size(), 60);
    ASSERT_EQ(model.alpha().size(), 60u);
    ASSERT_EQ(model.points().identities.size(), 60u);
    ASSERT_EQ(model.insertion_times().size(), 60u);
    ASSERT_EQ(model.State().points.inputs.size(), 60u * kDimension);
    EXPECT_EQ(model.PredictOwnMean(), mean);
    EXPECT_EQ(CopyOf(model.factor().Factor()), factor);
  };
  Hyperparameters other = model.hyperparameters();
  other.noise_stddev = 0.7;
  ExactModel rebuilt = *ExactModel::Restore(HostContext(), model.State());
  EXPECT_GT(FailEveryAllocation([&] { return rebuilt.SetHyperparameters(other); },
                                [&] { EXPECT_EQ(rebuilt.PredictOwnMean(), mean); }),
            3);
  EXPECT_GT(FailEveryAllocation([&] { return add(model, 60, 90); }, expect_unchanged), 5);
  EXPECT_EQ(model.size(), 90);
  EXPECT_EQ(model.factor().size(), 90);
}

// Enough rows for several blocks of the removal, which moves them in place.
TEST(MemoryFailure, AnExactModelKeepsTheRowsThatItCannotRemove) {
  constexpr int64_t kPoints = 200;
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(kPoints, kDimension, generator);
  for (const MeanFunction mean_function : {MeanFunction::kZero, MeanFunction::kLinear}) {
    Hyperparameters hyperparameters =
        DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension);
    hyperparameters.mean = mean_function;
    ExactModel model = *ExactModel::Create(HostContext(), hyperparameters);
    ASSERT_TRUE(model.AddObservations({ViewOf(points.inputs), points.targets()}, 0).ok());
    ASSERT_FALSE(model.factor().RefactoringIsCheaper({3, 17, 18, 199}));
    const std::vector<double> mean = model.PredictOwnMean();
    const RowMatrix factor = CopyOf(model.factor().Factor());
    const auto expect_unchanged = [&] {
      ASSERT_EQ(model.size(), kPoints);
      ASSERT_EQ(model.factor().size(), kPoints);
      EXPECT_EQ(model.PredictOwnMean(), mean);
      EXPECT_EQ(CopyOf(model.factor().Factor()), factor);
    };
    EXPECT_GT(FailEveryAllocation(
                  [&] {
                    return model.Remove({3, 17, 18, 199});
                  },
                  expect_unchanged),
              8);
    const ExactModel rest = *ExactModel::Restore(HostContext(), model.State());
    ASSERT_EQ(model.size(), kPoints - 4);
    ASSERT_EQ(rest.size(), kPoints - 4);
    for (int64_t i = 0; i < rest.size(); ++i) {
      EXPECT_NEAR(model.PredictOwnMean()[i], rest.PredictOwnMean()[i], 1e-8);
    }
  }
}

TEST(MemoryFailure, ASparseModelStaysWhole) {
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(90, kDimension, generator);
  const auto x = ViewOf(points.inputs);
  const auto labels = absl::MakeConstSpan(points.labels);
  SparseModelOptions options{.inducing_points = 20};
  for (const double refresh_share : {0.25, 1e9}) {
    options.refresh_share = refresh_share;
    SparseModel model = *SparseModel::Create(
        HostContext(), DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension),
        options);
    ASSERT_TRUE(model.Add(x.rows_between(0, 60), labels.first(60), 0).ok());
    std::vector<double> mean = Value(model.PredictOwnMean());
    const auto expect_unchanged = [&] {
      ASSERT_EQ(model.size(), static_cast<int64_t>(mean.size()));
      EXPECT_EQ(Value(model.PredictOwnMean()), mean);
    };
    EXPECT_GT(FailEveryAllocation(
                  [&] { return model.Add(x.rows_between(60, 90), labels.subspan(60, 30), 1); },
                  expect_unchanged),
              5);
    EXPECT_EQ(model.size(), 90);
    mean = Value(model.PredictOwnMean());
    EXPECT_GT(FailEveryAllocation(
                  [&] {
                    return model.Remove({3, 17, 18, 89});
                  },
                  expect_unchanged),
              5);
    EXPECT_EQ(model.size(), 86);
    mean = Value(model.PredictOwnMean());
    Hyperparameters other = model.hyperparameters();
    other.noise_stddev = 0.7;
    EXPECT_GT(
        FailEveryAllocation([&] { return model.SetHyperparameters(other); }, expect_unchanged), 5);
  }
}

// A thread that is refused is no failure: the caller's computes its share.
TEST(MemoryFailure, APosteriorOnSeveralDevicesWritesNothing) {
  constexpr int64_t kQueries = 3000;
  constexpr float kUntouched = -7.0f;
  auto generator = TestGenerator();
  const LabelledPoints points = NoisyBlobs(30, kDimension, generator);
  ExactModel model = *ExactModel::Create(
      HostContext(), DefaultHyperparameters(kernels::CovarianceFunction::kArcsine, kDimension));
  ASSERT_TRUE(model.AddObservations({ViewOf(points.inputs), points.targets()}, 0).ok());
  const auto posterior = *model.MakePosterior({}, {}, {HostContext(), HostContext()});
  const RowMatrix queries = RandomPoints(kQueries, kDimension, generator);
  std::vector<float> expected(kQueries);
  kernels::PosteriorOutputs outputs{.mean = expected.data()};
  ASSERT_TRUE(posterior->Evaluate(ViewOf(queries), outputs).ok());
  int failures = 0;
  for (int nth = 1;; ++nth) {
    std::vector<float> mean(kQueries, kUntouched);
    outputs.mean = mean.data();
    bool done = false;
    was_refused = false;
    allocations_left = nth;
    try {
      done = posterior->Evaluate(ViewOf(queries), outputs).ok();
    } catch (const std::bad_alloc&) {
    }
    allocations_left = 0;
    EXPECT_EQ(mean, done ? expected : std::vector<float>(kQueries, kUntouched)) << nth;
    if (!was_refused) break;
    failures += done ? 0 : 1;
  }
  EXPECT_GE(failures, 3);
}

}  // namespace
}  // namespace egosieve::gp
