#include "kernels/covariance/covariance_expression.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "absl/container/fixed_array.h"
#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "kernels/base/status_macros.h"

namespace egosieve::kernels {
namespace {

using Part = std::shared_ptr<const CovarianceDescription>;
using Names = std::map<std::string, Part, std::less<>>;

constexpr int kDeepest = 32;  // parentheses within each other

// The amplitude of a term of a sum, against the first.
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

// Sums and products. An amplitude lies before each term of a sum but the first, among the scales
// and among a point's values.
class Composition : public CovarianceDescription {
 public:
  Composition(std::vector<Part> parts, bool is_sum)
      : CovarianceDescription(GroupsOf(parts, is_sum)), parts_(std::move(parts)), is_sum_(is_sum) {}

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
    const double* first_a = a;
    const double* first_b = b;
    for (size_t i = 0; i < parts_.size(); ++i) {
      double factor = weight;
      if (HasAmplitude(i)) {
        factor *= *a++ * *b++;
        *gradient++ += 2.0 * factor * parts_[i]->Value(dimension, a, b);
      }
      if (!is_sum_) factor *= ProductWithout(i, dimension, first_a, first_b);
      parts_[i]->AddGradient(dimension, a, b, factor, gradient);
      gradient += parts_[i]->ScaleCount(dimension);
      a += parts_[i]->PointWidth(dimension);
      b += parts_[i]->PointWidth(dimension);
    }
  }

  void AddInputGradient(const double* scales, int64_t dimension, const double* a, const double* b,
                        double weight, double* gradient) const override {
    const double* first_a = a;
    const double* first_b = b;
    for (size_t i = 0; i < parts_.size(); ++i) {
      double factor = weight;
      if (HasAmplitude(i)) {
        factor *= *a++ * *b++;
        ++scales;
      }
      if (!is_sum_) factor *= ProductWithout(i, dimension, first_a, first_b);
      parts_[i]->AddInputGradient(scales, dimension, a, b, factor, gradient);
      scales += parts_[i]->ScaleCount(dimension);
      a += parts_[i]->PointWidth(dimension);
      b += parts_[i]->PointWidth(dimension);
    }
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

 private:
  bool HasAmplitude(size_t i) const { return is_sum_ && i > 0; }

  static ConstMatrixView<float> ColumnsOf(const ConstMatrixView<float>& points, int64_t first,
                                          int64_t count) {
    if (points.rows == 0) return {};
    return {points.data + first, points.rows, count, points.stride};
  }

  double ProductWithout(size_t left_out, int64_t dimension, const double* a,
                        const double* b) const {
    double product = 1.0;
    for (size_t i = 0; i < parts_.size(); ++i) {
      if (i != left_out) product *= parts_[i]->Value(dimension, a, b);
      a += parts_[i]->PointWidth(dimension);
      b += parts_[i]->PointWidth(dimension);
    }
    return product;
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

  std::string DeviceCode(const DeviceCodeRequest& request) const override {
    DeviceCodeRequest part = request;
    part.suffix = request.suffix + "_0";
    std::string sums;
    int64_t next = 0;
    for (size_t g = 0; g < part_->scale_groups().size(); ++g) {
      const int64_t count = part_->scale_groups()[g].per_input ? request.dimension : 1;
      absl::StrAppend(&sums, "  for (int d = ", next, "; d < ", next + count, "; ++d) sums[", g,
                      "] += all[d];\n");
      next += count;
    }
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
                        "  REALV all[", std::max<int64_t>(next, 1), "];\n  for (int d = 0; d < ",
                        next, "; ++d) all[d] = (REALV)0;\n",
                        WithSuffix("  add_gradient@_0(a, b, k, weight, all);\n", request), sums,
                        "}\n");
  }

 private:
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

// Recursive descent over the grammar.
class Parser {
 public:
  Parser(std::string_view text, const Names& names) : text_(text), names_(names) {}

  absl::StatusOr<NamedDescription> Parse() {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription sum, Sum(0));
    SkipSpace();
    if (place_ != text_.size()) return Error("'+' or '*'");
    return sum;
  }

 private:
  absl::StatusOr<NamedDescription> Sum(int depth) {
    return Chain('+', depth, [this](int d) {
      return Chain('*', d, [this](int inner) { return Factor(inner); });
    });
  }

  template <typename Next>
  absl::StatusOr<NamedDescription> Chain(char sign, int depth, const Next& next) {
    std::vector<std::string> texts;
    std::vector<Part> parts;
    do {
      EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription part, next(depth));
      texts.push_back(std::move(part.text));
      parts.push_back(std::move(part.description));
    } while (Take(sign));
    if (parts.size() == 1) return NamedDescription{std::move(texts[0]), std::move(parts[0])};
    return NamedDescription{absl::StrJoin(texts, sign == '+' ? " + " : " * "),
                            std::make_shared<Composition>(std::move(parts), sign == '+')};
  }

  absl::StatusOr<NamedDescription> Factor(int depth) {
    if (depth > kDeepest) return Error("fewer parentheses within each other");
    if (Take('(')) return Enclosed("", depth);
    SkipSpace();
    size_t end = place_;
    while (end < text_.size() && (absl::ascii_isalnum(text_[end]) || text_[end] == '_')) ++end;
    const std::string_view name = text_.substr(place_, end - place_);
    if (name == "isotropic") {
      place_ = end;
      if (!Take('(')) return Error("'(' after isotropic");
      EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription part, Enclosed(name, depth));
      part.description = std::make_shared<Isotropic>(std::move(part.description));
      return part;
    }
    const auto found = names_.find(name);
    if (found == names_.end()) return Error("a covariance function");
    place_ = end;
    return NamedDescription{found->first, found->second};
  }

  // After the opening parenthesis. Parentheses around what needs none are left out.
  absl::StatusOr<NamedDescription> Enclosed(std::string_view before, int depth) {
    EGOSIEVE_ASSIGN_OR_RETURN(NamedDescription sum, Sum(depth + 1));
    if (!Take(')')) return Error("')'");
    if (!before.empty() || sum.text.find(' ') != std::string::npos) {
      sum.text = absl::StrCat(absl::string_view(before.data(), before.size()), "(", sum.text, ")");
    }
    return sum;
  }

  void SkipSpace() {
    while (place_ < text_.size() && absl::ascii_isspace(text_[place_])) ++place_;
  }

  bool Take(char wanted) {
    SkipSpace();
    if (place_ == text_.size() || text_[place_] != wanted) return false;
    ++place_;
    return true;
  }

  absl::Status Error(const char* expected) const {
    return absl::InvalidArgumentError(
        absl::StrCat("covariance \"", absl::string_view(text_.data(), text_.size()),
                     "\": expected ", expected, " at character ", place_ + 1, "; functions are ",
                     absl::StrJoin(names_, ", ", [](std::string* out, const auto& entry) {
                       absl::StrAppend(out, entry.first);
                     })));
  }

  std::string_view text_;
  const Names& names_;
  size_t place_ = 0;
};

}  // namespace

absl::StatusOr<NamedDescription> ParseCovariance(std::string_view text, const Names& names) {
  return Parser(text, names).Parse();
}

}  // namespace egosieve::kernels
