// What other programs' own readers make of the masks: pycocotools and Pillow, where Python has them
// (pip install pycocotools pillow); skipped where not.
#include <cstdio>
#include <memory>
#include <string>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "tests/tools/testing/fake_run.h"
#include "tests/tools/testing/fresh_folder.h"
#include "tests/tools/testing/run_command.h"
#include "tools/masks/masks_command.h"
#include "tools/run_folder/atomic_file.h"

namespace egosieve::tools {
namespace {

constexpr char kScript[] = R"(
import sys
try:
    import numpy as np
    import pycocotools.mask as masks
    from PIL import Image
    from pycocotools.coco import COCO
except ImportError:
    print("missing")
    sys.exit(0)
root = sys.argv[1]
ids = lambda i: np.array(Image.open(f"{root}/drive/run/ids/{i:06d}.png"))

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

std::string Output(const std::string& command) {
  std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string output;
  char buffer[256];
  while (pipe != nullptr && fgets(buffer, sizeof buffer, pipe.get()) != nullptr) output += buffer;
  return output;
}

TEST(Readers, SeeTheRunsMovers) {
  const std::string root = FreshFolder();
  const FakeRun run = WriteFakeRun(root + "/drive");
  for (const char* format : {"coco", "davis", "mots"}) {
    ASSERT_EQ(RunCommandForTest(MakeMasksCommand(),
                                {run.folder.path(), absl::StrCat("--for=", format),
                                 absl::StrCat("--out=", root, "/", format), "--progress=none"})
                  .code,
              0);
  }
  const std::string script = root + "/read.py";
  ASSERT_TRUE(WriteFileAtomically(script, kScript).ok());
  const std::string output = Output("python3 " + script + " " + root + " 2>&1");
  if (output == "missing\n" || output.find("not found") != std::string::npos) {
    GTEST_SKIP() << "Python has no pycocotools or no Pillow";
  }
  EXPECT_TRUE(output.ends_with("ok 6 True\n")) << output;
}

}  // namespace
}  // namespace egosieve::tools
