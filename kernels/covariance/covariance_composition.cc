#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/fixed_array.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/substitute.h"
#include "kernels/covariance/covariance_expression.h"
#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {
namespace {

using Part = CovariancePart;

// The amplitude of a term of a sum, relative to the first term.
ScaleGroup Amplitude() {
  return {false, ScaleGroup::Unit::kNone, 1.0, std::log(0.05), std::log(20.0)};
}

std::vector<ScaleGroup> GroupsOf(const std::vector<Part>& parts, bool with_amplitudes) {
  std::vector<ScaleGroup> groups;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (with_amplitudes && i > 0) groups.push_back(Amplitude());
    const std::vector<ScaleGroup>& more = parts[i]->scale_groups();
    groups.insert(groups.end(), more.begin(), more.end());
  }
  return groups;
}

// Sums and products. In a sum each term except the first has an amplitude, which precedes it among
// the scales and among a point's values.
class Composition : public CovarianceDescription {
 public:
  Composition(std::vector<Part> parts, bool is_sum)
      : CovarianceDescription(GroupsOf(parts, is_sum)), parts_(std::move(parts)), is_sum_(is_sum) {}

  int64_t LeastDimension() const override {
    int64_t least = 1;
    for (const Part& part : parts_) least = std::max(least, part->LeastDimension());
    return least;
  }

  int64_t PointWidth(int64_t dimension) const override {
    int64_t width = is_sum_ ? static_cast<int64_t>(parts_.size()) - 1 : 0;
    for (const Part& part : parts_) width += part->PointWidth(dimension);
    return width;
  }

  void Prepare(const double* scales, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    for (size_t i = 0; i < parts_.size(); ++i) {
      if (HasAmplitude(i)) *point++ = *scales++;
      parts_[i]->Prepare(scales, dimension, x, centre, point);
      scales += parts_[i]->ScaleCount(dimension);
      point += parts_[i]->PointWidth(dimension);
    }
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    double value = is_sum_ ? 0.0 : 1.0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      const double weight = HasAmplitude(i) ? *a++ * *b++ : 1.0;
      const double part = parts_[i]->Value(dimension, a, b);
      value = is_sum_ ? value + weight * part : value * part;
      a += parts_[i]->PointWidth(dimension);
      b += parts_[i]->PointWidth(dimension);
    }
    return value;
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    ForEachPart(dimension, a, b, weight,
                [&](size_t i, const double* p, const double* q, double factor) {
                  if (HasAmplitude(i)) {
                    *gradient++ += 2.0 * factor * parts_[i]->Value(dimension, p, q);
                  }
                  parts_[i]->AddGradient(dimension, p, q, factor, gradient);
                  gradient += parts_[i]->ScaleCount(dimension);
                });
  }

  void AddInputGradient(const double* scales, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    ForEachPart(dimension, a, b, weight,
                [&](size_t i, const double* p, const double* q, double factor) {
                  if (HasAmplitude(i)) ++scales;
                  parts_[i]->AddInputGradient(scales, dimension, p, q, factor, gradient);
                  scales += parts_[i]->ScaleCount(dimension);
                });
  }

  double Variance(const double* scales, int64_t dimension, const double* x) const override {
    double value = is_sum_ ? 0.0 : 1.0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      const double amplitude = HasAmplitude(i) ? *scales++ : 1.0;
      const double part = parts_[i]->Variance(scales, dimension, x);
      value = is_sum_ ? value + amplitude * amplitude * part : value * part;
      scales += parts_[i]->ScaleCount(dimension);
    }
    return value;
  }

  double SpectralMass(const double* scales, int64_t dimension) const override {
    double mass = is_sum_ ? 0.0 : 1.0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      const double part = TakeMass(i, dimension, scales);
      if (part == 0.0) return 0.0;
      mass = is_sum_ ? mass + part : mass * part;
    }
    return mass;
  }

  // Of a sum: that of one term, drawn by the terms' masses. Of a product: the sum over factors.
  void AddFrequency(const double* scales, int64_t dimension, absl::FunctionRef<double()> normal,
                    double* frequency) const override {
    const double uniform = is_sum_ ? 0.5 * std::erfc(-normal() * M_SQRT1_2) : 0.0;
    double left = uniform * SpectralMass(scales, dimension);
    for (size_t i = 0; i < parts_.size(); ++i) {
      const double* own = scales + (HasAmplitude(i) ? 1 : 0);
      left -= TakeMass(i, dimension, scales);
      const bool is_last = i + 1 == parts_.size();
      if (is_sum_ && left > 0.0 && !is_last) continue;
      parts_[i]->AddFrequency(own, dimension, normal, frequency);
      if (is_sum_) return;
    }
  }

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    std::string code;
    std::vector<std::string> values, variances, gradients;
    int64_t place = 0, scale = 0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      std::string weight, variance_weight;
      const int64_t width = parts_[i]->PointWidth(request.dimension);
      if (HasAmplitude(i)) {
        weight = absl::StrCat("a[", place, "] * (REALV)b[", place, "] * ");
        variance_weight =
            absl::StrCat("point[", place, " * stride] * point[", place, " * stride] * ");
        gradients.push_back(absl::StrCat("sums[", scale, "] = fma(weight * (REALV)2, ", weight,
                                         "k_", i, ", sums[", scale, "]);"));
        ++place;
        ++scale;
      }
      DeviceCodeRequest part = request;
      part.suffix = absl::StrCat(request.suffix, "_", i);
      part.points = ColumnsOf(request.points, place, width);
      absl::StrAppend(&code, parts_[i]->DeviceCode(part));
      values.push_back(absl::StrCat(weight, "unit_covariance", part.suffix, "(a + ", place,
                                    ", b + ", place, ")"));
      variances.push_back(absl::StrCat(variance_weight, "unit_variance", part.suffix, "(point + ",
                                       place, " * stride, stride)"));
      std::string factor = absl::StrCat(weight, "weight");
      for (size_t j = 0; !is_sum_ && j < parts_.size(); ++j) {
        if (j != i) absl::StrAppend(&factor, " * k_", j);
      }
      gradients.push_back(absl::StrCat("add_gradient", part.suffix, "(a + ", place, ", b + ", place,
                                       ", k_", i, ", ", factor, ", sums + ", scale, ");"));
      gradients.insert(gradients.begin(),
                       absl::StrCat("const REALV k_", i, " = unit_covariance", part.suffix, "(a + ",
                                    place, ", b + ", place, ");"));
      place += width;
      scale += parts_[i]->ScaleCount(request.dimension);
    }
    const char* sign = is_sum_ ? " + " : " * ";
    return absl::StrCat(
        code,
        WithSuffix(
            "static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) {\n",
            request),
        "  return ", absl::StrJoin(values, sign), ";\n}\n",
        WithSuffix("static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, "
                   "const REALV k,\n"
                   "                                 const REALV weight, REALV* sums) {\n",
                   request),
        "  ", absl::StrJoin(gradients, "\n  "), "\n}\n",
        WithSuffix("static inline float unit_variance@(__global const float* point, const long "
                   "stride) {\n",
                   request),
        "  return ", absl::StrJoin(variances, sign), ";\n}\n");
  }

  std::string PreparationCode(const DeviceCodeRequest& request) const override {
    std::string code, calls;
    int64_t place = 0, scale = 0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      if (HasAmplitude(i)) {
        absl::StrAppend(&calls, "  point[", place++, "] = scales[", scale++, "];\n");
      }
      DeviceCodeRequest part = request;
      part.suffix = absl::StrCat(request.suffix, "_", i);
      absl::StrAppend(&code, parts_[i]->PreparationCode(part));
      absl::StrAppend(&calls, "  prepare_point", part.suffix, "(scales + ", scale,
                      ", x, centre, point + ", place, ");\n");
      place += parts_[i]->PointWidth(request.dimension);
      scale += parts_[i]->ScaleCount(request.dimension);
    }
    return absl::StrCat(code, WithSuffix(kPreparationHead, request), calls, "}\n");
  }

 private:
  bool HasAmplitude(size_t i) const { return is_sum_ && i > 0; }

  // The mass of part i with its amplitude; moves `scales` behind the part's.
  double TakeMass(size_t i, int64_t dimension, const double*& scales) const {
    const double amplitude = HasAmplitude(i) ? *scales++ : 1.0;
    const double mass = amplitude * amplitude * parts_[i]->SpectralMass(scales, dimension);
    scales += parts_[i]->ScaleCount(dimension);
    return mass;
  }

  static ConstMatrixView<float> ColumnsOf(const ConstMatrixView<float>& points, int64_t first,
                                          int64_t count) {
    if (points.rows == 0) return {};
    return {points.data + first, points.rows, count, points.stride};
  }

  // Calls visit(i, a, b, factor) for every part, with its values of both points and `weight` times
  // what the part's value is multiplied by.
  template <typename Visit>
  void ForEachPart(int64_t dimension, const double* a, const double* b, double weight,
                   const Visit& visit) const {
    absl::FixedArray<double, 16> values(is_sum_ ? 0 : parts_.size());
    const double *p = a, *q = b;
    for (size_t i = 0; i < values.size(); ++i) {
      values[i] = parts_[i]->Value(dimension, p, q);
      p += parts_[i]->PointWidth(dimension);
      q += parts_[i]->PointWidth(dimension);
    }
    for (size_t i = 0; i < parts_.size(); ++i) {
      double factor = weight;
      if (HasAmplitude(i)) factor *= *a++ * *b++;
      double others = 1.0;
      for (size_t j = 0; j < values.size(); ++j) others *= j == i ? 1.0 : values[j];
      visit(i, a, b, factor * others);
      a += parts_[i]->PointWidth(dimension);
      b += parts_[i]->PointWidth(dimension);
    }
  }

  std::vector<Part> parts_;
  bool is_sum_;
};

std::vector<ScaleGroup> Shared(std::vector<ScaleGroup> groups) {
  for (ScaleGroup& group : groups) group.per_input = false;
  return groups;
}

class Isotropic : public CovarianceDescription {
 public:
  explicit Isotropic(Part part)
      : CovarianceDescription(Shared(part->scale_groups())), part_(std::move(part)) {}

  int64_t PointWidth(int64_t dimension) const override { return part_->PointWidth(dimension); }

  void Prepare(const double* scales, int64_t dimension, const double* x, const double* centre,
               double* point) const override {
    part_->Prepare(Expanded(scales, dimension).data(), dimension, x, centre, point);
  }

  double Value(int64_t dimension, const double* a, const double* b) const override {
    return part_->Value(dimension, a, b);
  }

  void AddGradient(int64_t dimension, const double* a, const double* b, double weight,
                   double* gradient) const override {
    absl::FixedArray<double, 64> all(part_->ScaleCount(dimension), 0.0);
    part_->AddGradient(dimension, a, b, weight, all.data());
    const double* next = all.data();
    for (const ScaleGroup& group : part_->scale_groups()) {
      for (int64_t d = 0; d < (group.per_input ? dimension : 1); ++d) *gradient += *next++;
      ++gradient;
    }
  }

  void AddInputGradient(const double* scales, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    part_->AddInputGradient(Expanded(scales, dimension).data(), dimension, a, b, weight, gradient);
  }

  double Variance(const double* scales, int64_t dimension, const double* x) const override {
    return part_->Variance(Expanded(scales, dimension).data(), dimension, x);
  }

  double SpectralMass(const double* scales, int64_t dimension) const override {
    return part_->SpectralMass(Expanded(scales, dimension).data(), dimension);
  }
  void AddFrequency(const double* scales, int64_t dimension, absl::FunctionRef<double()> normal,
                    double* frequency) const override {
    part_->AddFrequency(Expanded(scales, dimension).data(), dimension, normal, frequency);
  }

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    DeviceCodeRequest part = request;
    part.suffix = request.suffix + "_0";
    const int64_t all = part_->ScaleCount(request.dimension);
    return absl::StrCat(part_->DeviceCode(part),
                        WithSuffix(R"(
static inline REALV unit_covariance@(const REALV* a, POINT_SPACE const REAL* b) { return unit_covariance@_0(a, b); }
static inline float unit_variance@(__global const float* point, const long stride) {
  return unit_variance@_0(point, stride);
}
static inline void add_gradient@(const REALV* a, POINT_SPACE const REAL* b, const REALV k, const REALV weight,
                                 REALV* sums) {
)",
                                   request),
                        "  REALV all[", std::max<int64_t>(all, 1), "];\n  for (int d = 0; d < ",
                        all, "; ++d) all[d] = (REALV)0;\n",
                        WithSuffix("  add_gradient@_0(a, b, k, weight, all);\n", request),
                        OfGroups(request.dimension, "sums[$0] += all[d]"), "}\n");
  }

  std::string PreparationCode(const DeviceCodeRequest& request) const override {
    DeviceCodeRequest part = request;
    part.suffix = request.suffix + "_0";
    return absl::StrCat(part_->PreparationCode(part), WithSuffix(kPreparationHead, request),
                        "  double all[", std::max<int64_t>(part_->ScaleCount(request.dimension), 1),
                        "];\n", OfGroups(request.dimension, "all[d] = scales[$0]"),
                        "  prepare_point", part.suffix, "(all, x, centre, point);\n}\n");
  }

 private:
  // Device code that does this for every scale d of every group $0.
  std::string OfGroups(int64_t dimension, const char* statement) const {
    std::string code;
    int64_t next = 0;
    for (size_t g = 0; g < part_->scale_groups().size(); ++g) {
      const int64_t end = next + (part_->scale_groups()[g].per_input ? dimension : 1);
      absl::StrAppend(&code, "  for (int d = ", next, "; d < ", end, "; ++d) ",
                      absl::Substitute(statement, g), ";\n");
      next = end;
    }
    return code;
  }

  absl::FixedArray<double, 64> Expanded(const double* scales, int64_t dimension) const {
    absl::FixedArray<double, 64> all(part_->ScaleCount(dimension));
    double* next = all.data();
    for (const ScaleGroup& group : part_->scale_groups()) {
      for (int64_t d = 0; d < (group.per_input ? dimension : 1); ++d) *next++ = *scales;
      ++scales;
    }
    return all;
  }

  Part part_;
};

std::vector<ScaleGroup> Restricted(std::vector<ScaleGroup> groups,
                                   const std::vector<int64_t>& columns) {
  for (ScaleGroup& group : groups) group.columns = columns;
  return groups;
}

// Points are prepared from the columns alone; all else is the part's.
class OfColumns : public CovarianceDescription {
 public:
  OfColumns(const CovariancePart& part, const std::vector<int64_t>& columns)
      : CovarianceDescription(Restricted(part->scale_groups(), columns)),
        part_(part),
        columns_(columns) {}

  int64_t LeastDimension() const override { return columns_.back() + 1; }
  int64_t PointWidth(int64_t /*dimension*/) const override { return part_->PointWidth(count()); }

  void Prepare(const double* scales, int64_t /*dimension*/, const double* x, const double* centre,
               double* point) const override {
    part_->Prepare(scales, count(), Gathered(x).data(), Gathered(centre).data(), point);
  }

  double Value(int64_t /*dimension*/, const double* a, const double* b) const override {
    return part_->Value(count(), a, b);
  }

  void AddGradient(int64_t /*dimension*/, const double* a, const double* b, double weight,
                   double* gradient) const override {
    part_->AddGradient(count(), a, b, weight, gradient);
  }

  void AddInputGradient(const double* scales, int64_t /*dimension*/, const double* a,
                        const double* b, double weight, double* gradient) const override {
    absl::FixedArray<double, 64> gathered(columns_.size(), 0.0);
    part_->AddInputGradient(scales, count(), a, b, weight, gathered.data());
    for (size_t c = 0; c < columns_.size(); ++c) gradient[columns_[c]] += gathered[c];
  }

  double Variance(const double* scales, int64_t /*dimension*/, const double* x) const override {
    return part_->Variance(scales, count(), Gathered(x).data());
  }

  double SpectralMass(const double* scales, int64_t /*dimension*/) const override {
    return part_->SpectralMass(scales, count());
  }
  void AddFrequency(const double* scales, int64_t /*dimension*/, absl::FunctionRef<double()> normal,
                    double* frequency) const override {
    absl::FixedArray<double, 64> gathered(columns_.size(), 0.0);
    part_->AddFrequency(scales, count(), normal, gathered.data());
    for (size_t c = 0; c < columns_.size(); ++c) frequency[columns_[c]] += gathered[c];
  }

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    return part_->DeviceCode({count(), request.suffix, request.points});
  }

  std::string PreparationCode(const DeviceCodeRequest& request) const override {
    const DeviceCodeRequest part = {count(), request.suffix + "_0", request.points};
    std::string gathering;
    for (size_t c = 0; c < columns_.size(); ++c) {
      absl::StrAppend(&gathering, "  own_x[", c, "] = x[", columns_[c], "];\n  own_centre[", c,
                      "] = centre[", columns_[c], "];\n");
    }
    return absl::StrCat(part_->PreparationCode(part), WithSuffix(kPreparationHead, request),
                        "  double own_x[", count(), "], own_centre[", count(), "];\n", gathering,
                        "  prepare_point", part.suffix, "(scales, own_x, own_centre, point);\n}\n");
  }

 private:
  int64_t count() const { return static_cast<int64_t>(columns_.size()); }

  absl::FixedArray<double, 64> Gathered(const double* x) const {
    absl::FixedArray<double, 64> gathered(columns_.size());
    for (size_t c = 0; c < columns_.size(); ++c) gathered[c] = x[columns_[c]];
    return gathered;
  }

  CovariancePart part_;
  std::vector<int64_t> columns_;
};

}  // namespace

CovariancePart MakeComposition(std::vector<CovariancePart> parts, bool is_sum) {
  return std::make_shared<Composition>(std::move(parts), is_sum);
}

CovariancePart MakeIsotropic(CovariancePart part) {
  return std::make_shared<Isotropic>(std::move(part));
}

CovariancePart MakeOfColumns(const CovariancePart& part, const std::vector<int64_t>& columns) {
  return std::make_shared<OfColumns>(part, columns);
}

}  // namespace egosieve::kernels
