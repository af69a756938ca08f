// Model files: the state of an online model, for continuing its learning or for predictions
// elsewhere.
//
// The format is NumPy's .npz (gp/io/array_file.h): in Python, numpy.load(path) gives the arrays
//
//   format_version        i8 [1]     the largest bracketed number of the arrays present, else 1
//   covariance_function   i8 [1]     0 arcsine, 1 squared exponential, 2 another
//   covariance_name       u1 [...]   for another: its text for CovarianceFunction::Parse
//   scales                f8 [P]     kernels/base/covariance_parameters.h
//   signal_noise          f8 [2]     sigma_f, sigma_n
//   inputs                f8 [n, D]
//   targets               f8 [n]     y; of k outputs, k > 1: f8 [n, k] (2)
//   noise_variances       f8 [n]     v, on top of sigma_n^2, if any point has one (2)
//   mean_function         i8 [1]     1 constant, 2 linear; absent: zero (2)
//   sparse                i8 [2]     for a sparse model: 1 DTC, 2 FITC; most inducing inputs (3)
//   iterative             f8 [2]     for an iterative model: rank, tolerance (5)
//   alpha                 f8 [n k]   its weights, from which a reader starts (5)
//   laplace               i8 [1]     1 where the points stand for Laplace's approximation of a
//                                    classifier (4)
//   normalized            i8 [1]     1 where y is not in the units of the user, which the annotations
//                                    explain to the program that wrote them (6)
//   identities            i8 [n]     increasing
//   birth_frames          i8 [n]     insertion times; the name is that of the first version
//   next_identity         i8 [1]
//   squash                f8 [2]     a, b
//   trainer_*             the state of the trainer, if there is one; a smoothed objective of NaN
//                         means none
//   annotations           u1 [...]   the caller's bytes, uninterpreted
//
// The factor is not stored: its n^2 numbers follow from the rest. So do an iterative model's
// weights, but at a higher cost than that of checking them (gp/model/iterative_model.h). If a run
// calls ExactModel::Refactorize when it writes, it continues with the same bits as a run that
// starts from the file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "gp/calibration/probabilistic_least_squares.h"
#include "gp/model/exact_model.h"
#include "gp/model/iterative_model.h"
#include "gp/model/sparse_solution.h"
#include "gp/training/hyperparameter_trainer.h"

namespace egosieve::gp {

// The latest version; all earlier ones can be read.
inline constexpr int64_t kModelFormatVersion = 6;

// Of an iterative model.
struct IterativeFile {
  IterativeModelOptions options;  // the limit of iterations is not stored
  std::vector<double> alpha;      // n x k
};

struct ModelFile {
  ExactModelState model;
  SquashParameters squash;
  std::optional<TrainerState> trainer;
  std::string annotations;
  // For a sparse model: approximation, DTC or FITC, and inducing_points; the other options have
  // their defaults.
  std::optional<SparseModelOptions> sparse = std::nullopt;
  std::optional<IterativeFile> iterative = std::nullopt;
  bool is_laplace = false;  // gp/training/laplace_approximation.h
  bool is_normalized = false;
};

// The file is written completely or not at all (kernels/files/atomic_file.h). InvalidArgument for
// an invalid model.
absl::Status WriteModelFile(const std::string& path, const ModelFile& file);

// Errors name the file. DataLoss if it is damaged, truncated or not a model; Unimplemented for a
// later version; InvalidArgument if its arrays do not form a valid model; FailedPrecondition if the
// file is larger than a quarter of the machine's memory, or what a model computes, 8 n^2 bytes of
// an exact and 8 n m of an iterative one, than all of it, or where y is normalised and must not be.
absl::StatusOr<ModelFile> ReadModelFile(const std::string& path, bool may_be_normalized = false);

// The same in memory. Equal models give equal bytes.
absl::StatusOr<std::string> SerializeModel(const ModelFile& file);
absl::StatusOr<ModelFile> ParseModel(std::string_view bytes, bool may_be_normalized = false);

}  // namespace egosieve::gp
