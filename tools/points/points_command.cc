// egosieve points SPARSE: COLMAP's model without the points on what moves (masked_points.h).
#include <CLI/CLI.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "kernels/base/status_macros.h"
#include "tools/cli/command.h"
#include "tools/cli/progress.h"
#include "tools/cli/result_flag.h"
#include "tools/cli/warning.h"
#include "tools/colmap/sparse_model.h"
#include "tools/points/masked_points.h"
#include "tools/run_folder/map_image.h"
#include "tools/run_folder/written_folder.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;

class PointsCommand : public Command {
 public:
  std::string name() const override { return "points"; }
  std::string summary() const override {
    return "Drops the points of a COLMAP model that lie on what moves.";
  }
  std::string example() const override {
    return "egosieve points sparse/0 --masks=masks --out=sparse_static/0";
  }

  void AddFlags(CLI::App& app) override {
    app.add_option("SPARSE", sparse_,
                   "COLMAP's model: cameras, images and points3D, as .bin or .txt")
        ->required()
        ->type_name("")
        ->configurable(false);
    app.add_option("--masks", masks_,
                   "Masks of the model's pictures, as masks --for=colmap writes them: IMAGE.png, 0 "
                   "where masked")
        ->required()
        ->type_name("DIR");
    app.add_option("-o,--out", out_,
                   "The folder to write the model to, in the form in which it was read")
        ->required()
        ->type_name("DIR");
    app.add_flag("--overwrite", overwrite_, "Replace files of the same names in --out");
    progress_.AddFlag(app);
    result_.AddFlag(app);
  }

  absl::StatusOr<ExitCode> Run() override {
    std::error_code error;
    if (!fs::is_directory(masks_, error)) {
      return absl::NotFoundError(absl::StrCat(
          "--masks=", masks_, ": no such folder; egosieve masks --for=colmap makes it"));
    }
    EGOSIEVE_ASSIGN_OR_RETURN(SparseModel model, ReadSparseModel(sparse_, true));
    EGOSIEVE_RETURN_IF_ERROR(
        CheckWrittenFolder("--out", out_, {model.folder, masks_}, {}, overwrite_));
    Progress progress("points", progress_, static_cast<int64_t>(model.images.size()));
    EGOSIEVE_ASSIGN_OR_RETURN(
        const MaskedPoints result,
        DropMaskedPoints(
            [&](const SparseImage& image) -> absl::StatusOr<cv::Mat1b> {
              if (!progress.AdvanceUninterrupted()) {
                return absl::CancelledError("interrupted; nothing is written");
              }
              return ReadMask(image);
            },
            model));
    progress.Finish();
    if (result.images_with_mask == 0) {
      return absl::NotFoundError(
          absl::StrCat("--masks=", masks_, " holds no mask of the model's images; name them ",
                       model.images.empty() ? "IMAGE" : model.images.front().name,
                       ".png, as masks --for=colmap does"));
    }
    EGOSIEVE_RETURN_IF_ERROR(WriteSparseModel(model, out_));
    result_.Tell(name(),
                 {{"folder", out_},
                  {"points", result.points},
                  {"dropped", result.dropped},
                  {"images", result.images},
                  {"images_with_mask", result.images_with_mask}},
                 absl::StrFormat("%d of %d points dropped; the model is in %s\n", result.dropped,
                                 result.points, out_));
    if (result.images_with_mask < result.images) {
      Warn(absl::StrCat(result.images - result.images_with_mask, " of ", result.images,
                        " images have no mask; their observations did not count"));
    }
    return ExitCode::kDone;
  }

 private:
  // Empty if the image has none.
  absl::StatusOr<cv::Mat1b> ReadMask(const SparseImage& image) const {
    const std::string path = absl::StrCat(masks_, "/", image.name, ".png");
    std::error_code error;
    if (!fs::exists(path, error)) return cv::Mat1b();
    EGOSIEVE_ASSIGN_OR_RETURN(
        const cv::Mat mask, ReadImage(path, cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION));
    return cv::Mat1b(mask);
  }

  std::string sparse_, masks_, out_;
  bool overwrite_ = false;
  ProgressFlag progress_;
  ResultFlag result_;
};

}  // namespace

std::unique_ptr<Command> MakePointsCommand() { return std::make_unique<PointsCommand>(); }

}  // namespace egosieve::tools
