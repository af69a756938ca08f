// What other programs' own readers make of the masks: pycocotools, pycolmap and Pillow, in the
// Python that EGOSIEVE_READERS names, else python3:
//
//   python3 -m venv readers && readers/bin/pip install numpy pillow pycocotools pycolmap
//   export EGOSIEVE_READERS=$PWD/readers/bin/python
//   bazel test --test_env=EGOSIEVE_READERS //tests/tools:parts_test --test_filter=Readers*
//
// Skipped where they are not installed.
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "tests/testing/fresh_folder.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/outcome.h"
#include "tests/tools/testing/program.h"
#include "tests/tools/testing/run_command.h"
#include "tools/cli/command.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr char kHead[] = R"(
import sys
try:
    import numpy as np
    from PIL import Image
    %s
except ImportError as error:
    print("missing", error)
    sys.exit(0)
root = sys.argv[1]
ids = lambda i: np.array(Image.open(f"{root}/drive/run/ids/{i:06d}.png"))
moving = lambda i: np.array(Image.open(f"{root}/drive/run/masks/{i:06d}.png")) > 0
)";

constexpr char kNumbered[] = R"(
coco = COCO(root + "/coco/annotations.json")
for image in coco.getImgIds():
    drawn = np.zeros_like(ids(image - 1))
    for annotation in coco.loadAnns(coco.getAnnIds(imgIds=[image])):
        mask = coco.annToMask(annotation)
        segmentation = annotation["segmentation"]
        assert masks.encode(np.asfortranarray(mask))["counts"].decode() == segmentation["counts"]
        assert list(masks.toBbox(segmentation)) == annotation["bbox"]
        assert masks.area(segmentation) == annotation["area"]
        drawn[mask > 0] = annotation["track_id"]
    assert (drawn == ids(image - 1)).all()

for i in range(6):
    image = Image.open(f"{root}/davis/{i:06d}.png")
    assert image.mode == "P" and (np.array(image) == ids(i)).all()

rows = [line.split() for line in open(root + "/mots/drive.txt")]
for frame, number, category, height, width, text in rows:
    mask = masks.decode({"size": [int(height), int(width)], "counts": text.encode()})
    image = np.array(Image.open(f"{root}/mots/drive/{int(frame):06d}.png"))
    assert ((image == int(number)) == (mask > 0)).all() and int(number) // 1000 == int(category)
print("ok", len(coco.getImgIds()), len(rows) > 3)
)";

// COLMAP takes every image, and no feature of a masked pixel.
constexpr char kColmap[] = R"(
pycolmap.logging.minloglevel = pycolmap.logging.ERROR
def features(masks):
    path = f"{root}/{masks or 'all'}.db"
    reader = pycolmap.ImageReaderOptions()
    if masks:
        reader.mask_path = f"{root}/{masks}"
    pycolmap.extract_features(path, f"{root}/drive/frames", reader_options=reader, device=pycolmap.Device.cpu)
    database = pycolmap.Database.open(path)
    images = database.read_all_images()
    masked = 0
    for image in images:
        mask = pycolmap.Bitmap.read(f"{root}/colmap/{image.name}.png", False).to_array().squeeze()
        assert ((mask == 0) == moving(int(image.name[:6]))).all()
        points = database.read_keypoints(image.image_id)[:, :2].astype(int)
        masked += int((mask[points[:, 1], points[:, 0]] == 0).sum())
    return len(images), masked
with_masks, without = features("colmap"), features(None)
print("ok", with_masks, without[0], without[1] > 0)
)";

// The others by the rules that they document. nerfstudio: a mask for each frame or for none, of one
// channel, of the picture's size, 0 left out. instant-ngp: dynamic_mask_NAME.png beside the
// picture, not 0 left out. gaussian-splatting: the alpha of the picture.
constexpr char kScenes[] = R"(
frames = json.load(open(f"{root}/nerfstudio/transforms.json"))["frames"]
for frame in frames:
    picture = Image.open(f"{root}/nerfstudio/" + frame["file_path"])
    mask = np.array(Image.open(f"{root}/nerfstudio/" + frame["mask_path"]))
    assert mask.ndim == 2 and mask.shape == (picture.height, picture.width)
    assert (~mask.astype(bool) == moving(int(frame["file_path"][-10:-4]))).all()
for i in range(6):
    mask = np.array(Image.open(f"{root}/instant-ngp/dynamic_mask_{i:06d}.png").convert("RGBA"))
    assert ((mask[:, :, 0] != 0) == moving(i)).all()
    picture = np.array(Image.open(f"{root}/gaussian-splatting/{i:06d}.png"))
    assert picture.shape[2] == 4 and ((picture[:, :, 3] == 0) == moving(i)).all()
    assert (picture[:, :, :3] == np.array(Image.open(f"{root}/drive/frames/{i:06d}.png").convert("RGB"))).all()
print("ok", len(frames))
)";

class Readers : public testing::Test {
 protected:
  Readers() : root_(FreshFolder()), run_(WriteFakeRun(root_ + "/drive")) {
    nlohmann::json transforms;
    for (int i = 0; i < 6; ++i) {
      transforms["frames"].push_back({{"file_path", absl::StrFormat("frames/%06d.png", i)}});
    }
    EXPECT_TRUE(WriteFileAtomically(root_ + "/drive/transforms.json", transforms.dump()).ok());
  }

  void Write(const std::string& format) const {
    ASSERT_THAT(RunCommandForTest(MakeMasksCommand(),
                                  {run_.folder.path(), absl::StrCat("--for=", format),
                                   absl::StrCat("--out=", root_, "/", format), "--progress=none"}),
                Succeeds())
        << format;
  }

  // Skipped where Python lacks one of the imports.
  void ExpectEnd(const std::string& imports, const std::string& script,
                 const std::string& end) const {
    const std::string path = root_ + "/read.py";
    const std::string text = absl::StrReplaceAll(kHead, {{"%s", imports}}) + script;
    EXPECT_TRUE(WriteFileAtomically(path, text).ok());
    const char* python = std::getenv("EGOSIEVE_READERS");
    const std::string output = ShellOutput(
        absl::StrCat(python == nullptr ? "python3" : python, " ", path, " ", root_, " 2>&1"));
    if (output.starts_with("missing") || output.find("not found") != std::string::npos) {
      GTEST_SKIP() << output;
    }
    EXPECT_TRUE(output.ends_with(end)) << output;
  }

  std::string root_;
  FakeRun run_;
};

TEST_F(Readers, OfNumbersSeeTheRunsMovers) {
  for (const char* format : {"coco", "davis", "mots"}) Write(format);
  ExpectEnd("import pycocotools.mask as masks; from pycocotools.coco import COCO", kNumbered,
            "ok 6 True\n");
}

TEST_F(Readers, ColmapTakesAllImagesAndNothingThatMoves) {
  Write("colmap");
  ExpectEnd("import pycolmap", kColmap, "ok (6, 0) 6 True\n");
}

TEST_F(Readers, OfScenesLeaveOutWhatMoves) {
  for (const char* format : {"nerfstudio", "instant-ngp", "gaussian-splatting"}) Write(format);
  ExpectEnd("import json", kScenes, "ok 6\n");
}

}  // namespace
}  // namespace egosieve::tools
