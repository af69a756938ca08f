#include "kernels/ops/opencl_posterior_model.h"

#include <algorithm>

#include "kernels/base/parallel_for.h"
#include "kernels/ops/kernel_options.h"
#include "kernels/runtime/buffer.h"

namespace egosieve::kernels::opencl {
namespace {

std::vector<double> CentreOfModel(const PosteriorModel& model) {
  const int64_t dimension = model.covariance.input_dimension();
  return model.inputs.rows > 0 ? CentreOf(model.inputs) : std::vector<double>(dimension, 0.0);
}

// Position in the packed factor of the group that starts at row `first`, a multiple of the group;
// see packed_offset in kernels/cl/dense_posterior.cl.
int64_t PackedOffset(int64_t first, const FactorBlocking& blocking) {
  return first * (first - blocking.group) / 2 + first * (blocking.group + blocking.panel) / 2;
}

// Rows [first, first + count) of the padded factor's left part, (1), times `sign`. Returns the end
// of the written values.
float* PackLeftPart(ConstMatrixView<double> factor, int64_t first, int64_t count,
                    const FactorBlocking& blocking, double sign, float* out) {
  for (int64_t k0 = 0; k0 < first; k0 += blocking.depth) {
    const int64_t k1 = std::min<int64_t>(k0 + blocking.depth, first);
    for (int64_t r = first; r < first + count; r += blocking.panel) {
      const int64_t rows = std::clamp<int64_t>(factor.rows - r, 0, blocking.panel);
      for (int64_t k = k0; k < k1; ++k, out += blocking.panel) {
        for (int64_t i = 0; i < rows; ++i) out[i] = static_cast<float>(sign * factor(r + i, k));
        for (int64_t i = rows; i < blocking.panel; ++i) out[i] = 0.0f;
      }
    }
  }
  return out;
}

// Row-major lower triangle of the diagonal block of `rows` rows at `first`; zero above the
// diagonal.
std::vector<double> DiagonalBlock(ConstMatrixView<double> factor, int64_t first, int64_t rows) {
  std::vector<double> block(rows * rows, 0.0);
  for (int64_t i = 0; i < rows; ++i) {
    for (int64_t j = 0; j <= i; ++j) block[i * rows + j] = factor(first + i, first + j);
  }
  return block;
}

// Forward substitution on the identity, row by row.
std::vector<double> InvertLower(const std::vector<double>& block, int64_t rows) {
  std::vector<double> inverse(rows * rows, 0.0);
  for (int64_t i = 0; i < rows; ++i) {
    double* row = &inverse[i * rows];
    row[i] = 1.0;
    for (int64_t k = 0; k < i; ++k) {
      const double factor = block[i * rows + k];
      for (int64_t j = 0; j <= k; ++j) row[j] -= factor * inverse[k * rows + j];
    }
    for (int64_t j = 0; j <= i; ++j) row[j] /= block[i * rows + i];
  }
  return inverse;
}

void PackDiagonalPart(const std::vector<double>& block, int64_t rows, int64_t count, int panel,
                      float* out) {
  for (int64_t r = 0; r < count; r += panel) {
    for (int64_t k = 0; k < r + panel; ++k) {
      for (int64_t i = r; i < r + panel; ++i) {
        *out++ = i < rows && k <= i ? static_cast<float>(block[i * rows + k]) : 0.0f;
      }
    }
  }
}

// Number of values of the packed factor of n rows.
int64_t PackedSize(int64_t n, const FactorBlocking& blocking) {
  const int64_t padded = PaddedCount(n, blocking.panel);
  const int64_t first = padded / blocking.group * blocking.group;
  const int64_t count = padded - first;
  return PackedOffset(first, blocking) + first * count + count * (count + blocking.panel) / 2;
}

// The bytes do not depend on the number of threads.
AlignedArray<float> PackFactor(FactorKind kind, ConstMatrixView<double> factor,
                               const FactorBlocking& blocking) {
  const bool substitute = kind == FactorKind::kCholesky;
  const int64_t padded = PaddedCount(factor.rows, blocking.panel);
  AlignedArray<float> packed(PackedSize(factor.rows, blocking));
  ParallelFor((padded + blocking.group - 1) / blocking.group, [&](int64_t g) {
    const int64_t first = g * blocking.group;
    const int64_t count = std::min<int64_t>(blocking.group, padded - first);
    const int64_t rows = std::min<int64_t>(count, factor.rows - first);
    float* out = PackLeftPart(factor, first, count, blocking, substitute ? -1.0 : 1.0,
                              packed.data() + PackedOffset(first, blocking));
    std::vector<double> block = DiagonalBlock(factor, first, rows);
    if (substitute) block = InvertLower(block, rows);
    PackDiagonalPart(block, rows, count, blocking.panel, out);
  });
  return packed;
}

}  // namespace

DeviceModel::DeviceModel(const Context& context, const PosteriorModel& model,
                         const FactorBlocking& blocking)
    : covariance(model.covariance),
      factor_kind(model.inputs.rows == 0 ? FactorKind::kNone : model.factor_kind),
      squash_a(static_cast<float>(model.squash_a)),
      squash_b(static_cast<float>(model.squash_b)),
      count(model.inputs.rows),
      preparation(covariance, CentreOfModel(model)) {
  const double signal_variance = covariance.signal_stddev * covariance.signal_stddev;
  host.inputs = PrepareRows<double, float>(preparation, model.inputs);
  const ConstMatrixView<float> points(host.inputs.data(), count, preparation.width());
  covariance_code = CovarianceCodeFor(covariance, points);
  for (int64_t i = 0; i < count; ++i) {
    host.alpha.push_back(static_cast<float>(signal_variance * model.alpha[i]));
  }
  // Buffers must not be empty.
  host.inputs.resize(std::max<size_t>(host.inputs.size(), 1));
  host.alpha.resize(std::max<size_t>(host.alpha.size(), 1));
  inputs = InputBuffer(context, host.inputs);
  alpha = InputBuffer(context, host.alpha);
  if (factor_kind != FactorKind::kNone) {
    host.factor = PackFactor(factor_kind, model.factor, blocking);
    factor = InputBuffer(context, host.factor);
  } else {
    factor = alpha;
  }
}

}  // namespace egosieve::kernels::opencl
