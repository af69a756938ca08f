// Covariance functions. Each function is a description that a file of this folder registers by
// name; kernels and models use this description alone. The two oldest, arcsine and squared
// exponential, also have codes in the model file and in the C interface; others are identified
// there by name.
//
//   k(x, x') = sigma_f^2 f(x, x'; s),   s > 0: scales, optimised as logarithms    (1)
//
// A point is prepared once, in float64, and rounded once to the device's type. This gives P values
// p(x), so that
//
//   f(x, x') = v(p(x), p(x'))                                                                (2)
//
// is cheap and accurate. v is written twice: in C++ for the reference, and in OpenCL, where a
// work-item takes a vector of points a and one point b. If the inputs of a set lie far from zero
// relative to their spread, functions of differences first subtract a centre c, so that rounding is
// relative to |x - c|.
//
// The name of a function is a text:
//
//   sum      product { "+" product }       f_1 + a_2^2 f_2 + ...;  scales: s_1, a_2, s_2, ...
//   product  factor { "*" factor }         f_1 f_2 ...;            scales: s_1, s_2, ...
//   factor   whole [ "[" range { "," range } "]" ]
//   whole    name | "(" sum ")" | "isotropic" "(" sum ")"
//   range    column | first ":" end           columns first, ..., end - 1
//
// A function has one scale per input (automatic relevance determination), except within
// isotropic(...), where all inputs share one: "matern52 + linear * isotropic(periodic)".
//
// A function with columns sees these inputs alone, and has scales for them alone: "matern52[0:3] *
// periodic[3]". Columns count from 0 and increase. isotropic(...) and a function with columns
// contain no further columns.
//
// The OpenCL text of a function defines three functions, static inline. @ represents the function's
// suffix and $D the dimension D; UNROLL precedes loops over the values of a point.
//
//   v(a, b):
//     REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b)
//   sums[t] += weight dv / d log s_t, where k = v(a, b):
//     void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k,
//                        const REALV weight, REALV* sums)
//   f(x, x), where value c of p(x) is point[c stride]:
//     float unit_variance@(__global const float* point, const long stride)
//
// The text of its preparation, in a separate program, defines one:
//
//   p(x), with scales, x and centre in private memory, in float64:
//     void prepare_point@(const double* scales, const double* x, const double* centre,
//                         double* point)
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/statusor.h"
#include "kernels/base/matrix_view.h"

namespace egosieve::kernels {

// Limits prepared points to the size of registers or a thread's stack.
inline constexpr int kMaxInputDimension = 256;

// A group of scales: one for every input, or one for all.
struct ScaleGroup {
  enum class Unit { kNone, kInput, kInverseInput };

  bool per_input = true;
  Unit unit = Unit::kInput;
  // Initial value, and bounds of the logarithm, for inputs in [-1, 1].
  double initial = 0.5;
  double lower_log = 0.0;
  double upper_log = 0.0;
  std::vector<int64_t> columns = {};  // the inputs that the function sees; empty: all

  int64_t InputCount(int64_t dimension) const {
    return columns.empty() ? dimension : static_cast<int64_t>(columns.size());
  }
  int64_t ScaleCount(int64_t dimension) const { return per_input ? InputCount(dimension) : 1; }
};

// The group of a length-scale: 0.5, in [0.02, 20].
ScaleGroup LengthScales();

struct DeviceCodeRequest {
  int64_t dimension = 0;  // D
  std::string suffix;
  // The prepared training inputs: their bounds may simplify the code. Empty: unknown.
  ConstMatrixView<float> points;
};

class CovarianceDescription {
 public:
  virtual ~CovarianceDescription() = default;

  const std::vector<ScaleGroup>& scale_groups() const { return groups_; }
  int64_t ScaleCount(int64_t dimension) const { return per_input_ * dimension + fixed_; }
  // D for a number of scales; 0 if it does not follow from it.
  int64_t DimensionOf(int64_t scale_count) const;
  // D at least: the last column of the text and one.
  virtual int64_t LeastDimension() const { return 1; }

  // P.
  virtual int64_t PointWidth(int64_t dimension) const = 0;
  // p(x); centre: D values.
  virtual void Prepare(const double* scales, int64_t dimension, const double* x,
                       const double* centre, double* point) const = 0;
  // v(a, b).
  virtual double Value(int64_t dimension, const double* a, const double* b) const = 0;
  // gradient[t] += weight dv / d log s_t.
  virtual void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                           double* gradient) const = 0;
  // gradient[d] += weight df(x, x') / dx_d, where a = p(x), b = p(x'); 0 where f has a cusp or a
  // step. Since f is symmetric, f(x, x) has twice that gradient at x' = x.
  virtual void AddInputGradient(const double* scales, int64_t dimension, const double* a,
                                const double* b, double weight, double* gradient) const = 0;
  // f(x, x).
  virtual double Variance(const double* scales, int64_t dimension, const double* x) const = 0;
  // Stationary functions are f(x, x') = m E cos(w.(x - x')) for random frequencies w (Bochner). m; 0
  // for functions that are not stationary or whose frequencies cannot be drawn.
  virtual double SpectralMass(const double* /*scales*/, int64_t /*dimension*/) const { return 0.0; }
  // frequency[d] += w_d. normal: gives independent standard normal values.
  virtual void AddFrequency(const double* /*scales*/, int64_t /*dimension*/,
                            absl::FunctionRef<double()> /*normal*/, double* /*frequency*/) const {}
  virtual std::string DeviceCode(const DeviceCodeRequest& request) const = 0;
  virtual std::string PreparationCode(const DeviceCodeRequest& request) const = 0;

 protected:
  explicit CovarianceDescription(std::vector<ScaleGroup> groups);

 private:
  std::vector<ScaleGroup> groups_;
  int64_t per_input_ = 0;
  int64_t fixed_ = 0;
};

// `text` with the function's suffix and D inserted.
std::string WithSuffix(std::string_view text, const DeviceCodeRequest& request);

// The name of a description; a literal, cheap to copy and compare.
class CovarianceFunction {
 public:
  // Two of the functions; the others come from Parse.
  static const CovarianceFunction kArcsine;
  static const CovarianceFunction kSquaredExponential;

  // InvalidArgument, with the place and the known names, for a text that names no function.
  static absl::StatusOr<CovarianceFunction> Parse(std::string_view text);
  // Names of the elementary functions, in alphabetical order.
  static std::vector<std::string> Names();

  // The canonical text, which Parse accepts.
  std::string_view text() const { return text_; }
  const CovarianceDescription& description() const;

  friend bool operator==(const CovarianceFunction& a, const CovarianceFunction& b) {
    return a.text() == b.text();
  }

 private:
  explicit constexpr CovarianceFunction(const char* text) : text_(text) {}

  const char* text_;  // valid until the process ends
};

inline constexpr CovarianceFunction CovarianceFunction::kArcsine{"arcsine"};
inline constexpr CovarianceFunction CovarianceFunction::kSquaredExponential{"squared_exponential"};

// Registers a function; an object at namespace scope in the function's file.
class CovarianceRegistration {
 public:
  CovarianceRegistration(const char* name, std::unique_ptr<const CovarianceDescription> function);
};

}  // namespace egosieve::kernels
