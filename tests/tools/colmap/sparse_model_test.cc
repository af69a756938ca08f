#include "tools/colmap/sparse_model.h"

#include <cstring>
#include <filesystem>
#include <limits>
#include <random>
#include <string>

#include "absl/strings/str_replace.h"
#include "tests/testing/fresh_folder.h"
#include "tests/testing/status.h"
#include "tools/colmap/model_files.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

auto IsDamaged(const std::string& words) { return IsError(absl::StatusCode::kDataLoss, words); }

// COLMAP's documentation of its output format has these lines.
constexpr char kCameras[] =
    "# Camera list with one line of data per camera:\n"
    "1 SIMPLE_PINHOLE 3072 2304 2559.81 1536 1152\n"
    "2 PINHOLE 3072 2304 2560.56 2560.56 1536 1152\n"
    "3 SIMPLE_RADIAL 3072 2304 2559.69 1536 1152 -0.0218531\n";
constexpr char kImages[] =
    "# Image list with two lines of data per image:\n"
    "1 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 1 P1180141.JPG\n"
    "2362.39 248.498 58396 1784.7 268.254 59027 1784.7 268.254 -1\n"
    "2 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 1 dir/P 2.JPG\n"
    "\n";
constexpr char kPoints[] =
    "58396 1.67241 0.292931 0.609726 115 121 122 1.33927 1 0\n"
    "59027 1.93847 0.314929 -0.09 115 0 255 0.5 1 1 1 2\n";

// Numbers that text could spoil, and every camera model.
SparseModel MakeModel() {
  SparseModel model;
  for (int number = 0; FindCameraModel(number) != nullptr; ++number) {
    SparseCamera camera = {static_cast<uint32_t>(40 - number), number, 640, 480, {}};
    for (int k = 0; k < FindCameraModel(number)->parameters; ++k) {
      camera.parameters.push_back(1.0 / (k + 3.0));
    }
    model.cameras.push_back(camera);
  }
  const double hard[] = {0.1, -0.0, 1e-310, 2.0 / 3.0, std::numeric_limits<double>::infinity()};
  for (uint32_t id : {7u, 3u, 5u}) {
    SparseImage image = {id, {0.5, 0.5, 0.5, 0.5, 1.0 / 3.0, -1e300, 0.0}, 40, "a b/c.jpg", {}};
    for (uint32_t k = 0; k < 5 * (id - 3); ++k) {
      image.observations.push_back({hard[k % 5], 17.25, k % 3 == 0 ? kNoPoint : int64_t{1} << k});
    }
    model.images.push_back(image);
  }
  model.points.push_back(
      {int64_t{1} << 40, {0.1, 0.2, -0.3}, {0, 128, 255}, 0.7, {{7, 1}, {5, 2}}});
  model.points.push_back({2, {1e-9, 0.0, 7.0}, {1, 2, 3}, -1.0, {}});
  return model;
}

TEST(SparseModel, HasItsBytesAgainAfterText) {
  const SparseModel model = MakeModel();
  const auto cameras = Format(model.cameras, false);
  const auto images = Format(model.images, false);
  const auto points = Format(model.points, false);
  const auto read_cameras = Value(Parse<SparseCamera>(cameras, false));
  const auto read_images = Value(Parse<SparseImage>(images, false));
  const auto read_points = Value(Parse<SparsePoint>(points, false));
  const std::string text = Format(read_images, true);
  EXPECT_EQ(Format(Value(Parse<SparseImage>(text, true)), true), text);
  EXPECT_EQ(Format(Value(Parse<SparseImage>(text, true)), false), images);
  EXPECT_EQ(Format(Value(Parse<SparseCamera>(Format(read_cameras, true), true)), false), cameras);
  EXPECT_EQ(Format(Value(Parse<SparsePoint>(Format(read_points, true), true)), false), points);
  // Windows' ends of lines.
  EXPECT_EQ(
      Format(Value(Parse<SparseImage>(absl::StrReplaceAll(text, {{"\n", "\r\n"}}), true)), false),
      images);
}

TEST(SparseModel, IsReadAsColmapDocumentsIt) {
  const auto cameras = Value(Parse<SparseCamera>(kCameras, true));
  ASSERT_EQ(cameras.size(), 3u);
  EXPECT_EQ(cameras[2].model, 2);
  EXPECT_THAT(cameras[2].parameters, ElementsAre(2559.69, 1536, 1152, -0.0218531));
  const auto images = Value(Parse<SparseImage>(kImages, true));
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].pose[6], 3.74354);
  EXPECT_EQ(images[0].name, "P1180141.JPG");
  ASSERT_EQ(images[0].observations.size(), 3u);
  EXPECT_EQ(images[0].observations[1].point, 59027);
  EXPECT_EQ(images[0].observations[2].point, kNoPoint);
  EXPECT_EQ(images[1].name, "dir/P 2.JPG");
  EXPECT_TRUE(images[1].observations.empty());
  const auto points = Value(Parse<SparsePoint>(kPoints, true));
  ASSERT_EQ(points.size(), 2u);
  EXPECT_EQ(points[1].rgb[2], 255);
  EXPECT_EQ(points[1].track[1].observation, 2u);
}

template <typename Number>
void Put(std::string& bytes, Number number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
}

TEST(SparseModel, IsReadFromColmapsBytes) {
  std::string bytes;
  Put(bytes, uint64_t{1});
  Put(bytes, uint32_t{9});
  Put(bytes, int32_t{1});
  Put(bytes, uint64_t{640});
  Put(bytes, uint64_t{480});
  for (const double parameter : {500.0, 510.0, 320.0, 240.0}) Put(bytes, parameter);
  const auto cameras = Value(Parse<SparseCamera>(bytes, false));
  ASSERT_EQ(cameras.size(), 1u);
  EXPECT_EQ(cameras[0].id, 9u);
  EXPECT_EQ(cameras[0].height, 480u);
  EXPECT_THAT(cameras[0].parameters, ElementsAre(500, 510, 320, 240));
  std::string unknown = bytes;
  unknown[12] = 99;
  EXPECT_THAT(Parse<SparseCamera>(unknown, false), IsDamaged("there is no camera model 99"));
  unknown[12] = unknown[13] = unknown[14] = unknown[15] = '\xff';
  EXPECT_THAT(Parse<SparseCamera>(unknown, false), IsDamaged("there is no camera model -1"));
}

// Every beginning of a file is an error, and so is a count that the file cannot hold.
template <typename Parse>
void ExpectErrors(const std::string& bytes, const std::vector<size_t>& counts, Parse parse) {
  for (size_t length = 0; length < bytes.size(); ++length) {
    ASSERT_THAT(parse(bytes.substr(0, length), false), IsDamaged("byte ")) << length;
  }
  EXPECT_THAT(parse(bytes + "x", false), IsDamaged("more bytes than its items"));
  for (const size_t at : counts) {
    for (const uint64_t count : {uint64_t{1} << 32, ~uint64_t{0}, ~uint64_t{0} / 24}) {
      std::string huge = bytes;
      std::memcpy(huge.data() + at, &count, sizeof(count));
      EXPECT_THAT(parse(huge, false), IsDamaged("more than the file holds")) << at;
    }
  }
  std::mt19937 random(5);
  for (int i = 0; i < 2000; ++i) {
    std::string other = bytes;
    for (int k = 0; k < 3; ++k) other[random() % other.size()] = static_cast<char>(random());
    (void)parse(other, false);  // no crash
    (void)parse(other, true);
  }
}

TEST(SparseModel, RefusesDamagedBytes) {
  const SparseModel model = MakeModel();
  ExpectErrors(Format(model.cameras, false), {0}, Parse<SparseCamera>);
  ExpectErrors(Format(model.images, false), {0, 8 + 64 + 10}, Parse<SparseImage>);
  ExpectErrors(Format(model.points, false), {0, 8 + 43}, Parse<SparsePoint>);
}

TEST(SparseModel, RefusesDamagedText) {
  EXPECT_THAT(Parse<SparseCamera>("1 MAGIC 4 4 1", true),
              IsDamaged("line 1: the model MAGIC is not"));
  EXPECT_THAT(Parse<SparseCamera>("\n1 PINHOLE 4 4 1 2 3", true),
              IsDamaged("line 2: a number is missing"));
  EXPECT_THAT(Parse<SparseCamera>("1 PINHOLE 4 4 1 2 3 4 5", true), IsDamaged("'5' is more than"));
  EXPECT_THAT(Parse<SparseCamera>("-1 PINHOLE 4 4 1 2 3 4", true),
              IsDamaged("'-1' is no such number"));
  EXPECT_THAT(Parse<SparseImage>("1 1 0 0 0 0 0 0 1", true), IsDamaged("the image has no name"));
  EXPECT_THAT(Parse<SparseImage>("1 1 0 0 0 0 0 0 1 a.jpg", true),
              IsDamaged("line 1: the file ends"));
  EXPECT_THAT(Parse<SparseImage>("1 1 0 0 0 0 0 0 1 a.jpg\n1.5 2", true),
              IsDamaged("line 2: a number is"));
  EXPECT_THAT(Parse<SparsePoint>("1 0 0 0 1 2 256 0", true), IsDamaged("'256' is no such number"));
  EXPECT_THAT(Parse<SparsePoint>("1 0 0 0 1 2 3 0 1", true), IsDamaged("a number is missing"));
}

class SparseFolder : public testing::Test {
 protected:
  SparseFolder() : root_(FreshFolder()) {
    fs::create_directories(root_ + "/sparse/0");
    Write("cameras.txt", kCameras);
    Write("images.txt", kImages);
    Write("points3D.txt", kPoints);
  }
  void Write(const std::string& name, const std::string& bytes) const {
    ASSERT_TRUE(WriteFileAtomically(root_ + "/sparse/0/" + name, bytes).ok());
  }

  std::string root_;
};

TEST_F(SparseFolder, IsFoundAndWrittenInItsForm) {
  Write("rigs.txt", "# rigs\n");
  const SparseModel text = Value(ReadSparseModel(root_, true));
  EXPECT_EQ(text.folder, root_ + "/sparse/0");
  ASSERT_TRUE(WriteSparseModel(text, root_ + "/out").ok());
  EXPECT_THAT(*ListFolder(root_ + "/out"),
              ElementsAre("cameras.txt", "images.txt", "points3D.txt", "rigs.txt"));
  EXPECT_EQ(*ReadFile(root_ + "/out/rigs.txt"), "# rigs\n");
  EXPECT_EQ(Format(Value(ReadSparseModel(root_ + "/out", true)).images, false),
            Format(text.images, false));
  // COLMAP reads the binary files where there are both.
  Write("cameras.bin", Format(std::vector{text.cameras[0]}, false));
  Write("images.bin", Format(std::vector{text.images[1]}, false));
  const SparseModel binary = Value(ReadSparseModel(root_ + "/sparse", false));
  EXPECT_FALSE(binary.is_text);
  EXPECT_EQ(binary.images.size(), 1u);
  EXPECT_THAT(ReadSparseModel(root_, true), IsError(absl::StatusCode::kNotFound, "points3D.bin"));
}

TEST_F(SparseFolder, RefusesWhatRefersToNothing) {
  EXPECT_THAT(ReadSparseModel(root_ + "/absent", true),
              IsError(absl::StatusCode::kNotFound, "holds no model of COLMAP"));
  Write("points3D.txt", "1 0 0 0 1 2 3 0 1 3\n");
  EXPECT_THAT(ReadSparseModel(root_, true), IsDamaged("an observation 3 of image 1"));
  Write("points3D.txt", "1 0 0 0 1 2 3 0 8 0\n");
  EXPECT_THAT(ReadSparseModel(root_, true), IsDamaged("of image 8, which is missing"));
  Write("points3D.txt", "1 0 0 0 1 2 3 0\n1 0 0 0 1 2 3 0\n");
  EXPECT_THAT(ReadSparseModel(root_, true), IsDamaged("two points have one id"));
  Write("cameras.txt", "2 PINHOLE 3072 2304 2560.56 2560.56 1536 1152\n");
  EXPECT_THAT(ReadSparseModel(root_, false), IsDamaged("the camera 1 of image 1 is missing"));
}

}  // namespace
}  // namespace egosieve::tools
