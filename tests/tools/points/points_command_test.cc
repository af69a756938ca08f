#include <filesystem>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"
#include "tools/colmap/model_files.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

// Four pictures of 40 x 30 pixels; the masks of the first three are 0 left of x = 10.
class PointsCommand : public testing::Test {
 protected:
  PointsCommand() : root_(FreshFolder()), sparse_(root_ + "/sparse"), out_(root_ + "/out") {
    fs::create_directories(root_ + "/masks/cam");
    fs::create_directories(root_ + "/empty");
    cv::Mat1b mask(30, 40, uint8_t{255});
    mask.colRange(0, 10) = 0;
    for (int i = 0; i < 3; ++i) {
      cv::imwrite(absl::StrFormat("%s/masks/cam/%d.jpg.png", root_, i), mask);
    }
    model_.folder = sparse_;
    model_.cameras = {{1, 0, 40, 30, {35, 20, 15}}};
    for (uint32_t i = 0; i < 4; ++i) {
      model_.images.push_back({i, {1, 0, 0, 0, 0, 0, 0}, 1, absl::StrFormat("cam/%d.jpg", i), {}});
    }
  }

  // A point that is seen at x = at[i] of picture i, and there at y = 5; below -1: not in it.
  void AddPoint(int64_t id, const std::vector<double>& at) {
    SparsePoint point{.id = id};
    for (uint32_t i = 0; i < at.size(); ++i) {
      if (at[i] < -1.0) continue;
      auto& observations = model_.images[i].observations;
      point.track.push_back({i, static_cast<uint32_t>(observations.size())});
      observations.push_back({at[i], 5.0, id});
    }
    model_.points.push_back(point);
  }

  CommandOutcome Points(const std::string& flag = "--json",
                        const std::string& masks = "masks") const {
    return RunCommandForTest(MakePointsCommand(), {sparse_, "--masks=" + root_ + "/" + masks,
                                                   "--out=" + out_, "--progress=none", flag});
  }

  std::vector<int64_t> Kept() const {
    std::vector<int64_t> ids;
    for (const SparsePoint& point : Value(ReadSparseModel(out_, true)).points) {
      ids.push_back(point.id);
    }
    return ids;
  }

  std::string root_, sparse_, out_;
  SparseModel model_;
};

TEST_F(PointsCommand, DropsWhatIsMaskedInHalfOfItsObservations) {
  constexpr double kAbsent = -9.0;
  AddPoint(10, {9.99, 0.0, 5.0, 30.0});            // always
  AddPoint(11, {9.99, 10.0, kAbsent, 30.0});       // in one of two: half
  AddPoint(12, {9.99, 10.0, 10.0, 5.0});           // in one of three; the fourth has no mask
  AddPoint(13, {30.0, 39.99, kAbsent, 5.0});       // in none
  AddPoint(14, {kAbsent, kAbsent, kAbsent, 5.0});  // seen in no mask
  AddPoint(15, {9.99, -0.5, 40.0, kAbsent});       // in one of one: two lie outside the picture
  for (const bool is_text : {false, true}) {
    model_.is_text = is_text;
    ASSERT_TRUE(WriteSparseModel(model_, sparse_ + (is_text ? "_text" : "")).ok());
  }
  for (const std::string form : {"", "_text"}) {
    sparse_ = root_ + "/sparse" + form;
    out_ = root_ + "/out" + form;
    testing::internal::CaptureStdout();
    const CommandOutcome outcome = Points();
    const std::string told = testing::internal::GetCapturedStdout();
    ASSERT_THAT(outcome, Succeeds());
    const auto result = nlohmann::json::parse(told);
    EXPECT_EQ(result.at("points"), 6);
    EXPECT_EQ(result.at("dropped"), 3);
    EXPECT_EQ(result.at("images_with_mask"), 3);
    EXPECT_THAT(Kept(), ElementsAre(12, 13, 14));
    // Every other byte of the model is as it was.
    const SparseModel made = Value(ReadSparseModel(out_, true));
    EXPECT_EQ(made.is_text, !form.empty());
    SparseModel expected = model_;
    for (SparseImage& image : expected.images) {
      for (Observation& observation : image.observations) {
        const int64_t id = observation.point;
        if (id == 10 || id == 11 || id == 15) observation.point = kNoPoint;
      }
    }
    EXPECT_EQ(Format(made.images, false), Format(expected.images, false));
    EXPECT_EQ(Format(made.cameras, false), Format(expected.cameras, false));
    EXPECT_EQ(made.points[0].track.size(), 4u);
  }
}

TEST_F(PointsCommand, CopiesRigsAndFrames) {
  AddPoint(10, {20.0});
  ASSERT_TRUE(WriteSparseModel(model_, sparse_).ok());
  for (const char* name : {"rigs.bin", "frames.bin"}) {
    ASSERT_TRUE(WriteFileAtomically(sparse_ + "/" + name, absl::StrCat("of ", name)).ok());
  }
  ASSERT_THAT(Points(), Succeeds());
  EXPECT_EQ(Value(ReadFile(out_ + "/rigs.bin")), "of rigs.bin");
  EXPECT_EQ(Value(ReadFile(out_ + "/frames.bin")), "of frames.bin");
}

// One clear line, and nothing is written.
TEST_F(PointsCommand, SaysWhatIsWrong) {
  AddPoint(10, {20.0, 20.0});
  ASSERT_TRUE(WriteSparseModel(model_, sparse_).ok());
  const auto before = *ListFolder(sparse_);
  EXPECT_THAT(Points("--json", "absent"), EndsWithLine(3, "no such folder"));
  EXPECT_THAT(Points("--json", "empty"), EndsWithLine(3, "holds no mask"));
  const std::string bytes = *ReadFile(sparse_ + "/points3D.bin");
  ASSERT_TRUE(WriteFileAtomically(sparse_ + "/points3D.bin", bytes.substr(0, 60)).ok());
  EXPECT_THAT(Points(), EndsWithLine(3, "points3D.bin: byte"));
  ASSERT_TRUE(WriteFileAtomically(sparse_ + "/points3D.bin", std::string(8, '\0')).ok());
  EXPECT_THAT(Points(), EndsWithLine(3, "observes point 10, which the model lacks"));
  ASSERT_TRUE(WriteFileAtomically(sparse_ + "/points3D.bin", bytes).ok());
  model_.cameras[0].width = 41;
  ASSERT_TRUE(WriteSparseModel(model_, sparse_).ok());
  EXPECT_THAT(Points(), EndsWithLine(2, "has 40 x 30 pixels, its camera 41 x 30"));
  EXPECT_FALSE(fs::exists(out_));
  out_ = root_ + "/masks/../empty";
  ASSERT_TRUE(WriteFileAtomically(root_ + "/empty/a", "").ok());
  EXPECT_THAT(Points(), EndsWithLine(2, "is not empty"));
  out_ = sparse_;
  EXPECT_THAT(Points(), EndsWithLine(2, "lies in what is read"));
  EXPECT_THAT(Points("--overwrite"), EndsWithLine(2, "lies in what is read"));
  sparse_ = root_ + "/masks";
  EXPECT_THAT(Points("--overwrite"), EndsWithLine(3, "holds no model of COLMAP"));
  EXPECT_EQ(*ListFolder(out_), before);
}

}  // namespace
}  // namespace egosieve::tools
