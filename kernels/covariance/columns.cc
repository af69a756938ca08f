// Functions of some of the inputs; see covariance_expression.h.
#include <memory>
#include <string>
#include <vector>

#include "absl/container/fixed_array.h"
#include "absl/strings/str_cat.h"
#include "kernels/covariance/covariance_composition.h"
#include "kernels/covariance/elementary.h"

namespace egosieve::kernels {
namespace {

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

CovariancePart MakeOfColumns(const CovariancePart& part, const std::vector<int64_t>& columns) {
  return std::make_shared<OfColumns>(part, columns);
}

}  // namespace egosieve::kernels
