// Prints how well each kind of evidence tells movers from the rest at the labelled tracks of
// KT3DMoSeg: the area under the ROC curve by clip, frame gap and term. EGOSIEVE_DATA names the
// data.
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/vision/evidence/clip_score.h"
#include "tests/vision/evidence/labelled_clip.h"

namespace {

using egosieve::vision::EvidenceOptions;

struct Row {
  const char* name;
  EvidenceOptions options;
};

std::vector<Row> Rows(const EvidenceOptions& base) {
  const auto with = [&](bool epipolar, bool depth, bool memory) {
    EvidenceOptions options = base;
    options.epipolar = epipolar;
    options.negative_depth = depth;
    options.accumulation = memory;
    return options;
  };
  return {{"epipolar", with(true, false, false)},
          {"negative depth", with(false, true, false)},
          {"epipolar + depth", with(true, true, false)},
          {"epipolar, accumulated", with(true, false, true)},
          {"all", with(true, true, true)}};
}

int Print(const std::string& data, const EvidenceOptions& base) {
  std::vector<egosieve::vision::LabelledClip> clips;
  for (const char* name : {"Seq005_Clip01", "Seq013_Clip02", "Seq028_Clip01"}) {
    auto clip = egosieve::vision::LoadLabelledClip(data + "/kt3dmoseg/" + name);
    if (!clip.ok()) {
      std::fprintf(stderr, "%s\n", clip.status().ToString().c_str());
      return 3;
    }
    clips.push_back(*std::move(clip));
  }
  for (int gap = 1; gap <= 3; ++gap) {
    std::printf("gap %d %31s", gap, "");
    for (const auto& clip : clips) std::printf(" %14s", clip.name.c_str());
    std::printf(" %7s  calibration  ms\n", "mean");
    std::vector<std::vector<egosieve::vision::ClipMotion>> motions;
    for (const auto& clip : clips) motions.push_back(*egosieve::vision::FundamentalsOf(clip, gap));
    for (const Row& row : Rows(base)) {
      std::printf("  %-34s", row.name);
      double auc = 0.0, error = 0.0, milliseconds = 0.0;
      for (size_t c = 0; c < clips.size(); ++c) {
        const auto score = egosieve::vision::ScoreClip(clips[c], motions[c], gap, row.options);
        if (!score.ok()) {
          std::fprintf(stderr, "%s\n", score.status().ToString().c_str());
          return 4;
        }
        std::printf("         %.4f", score->auc);
        auc += score->auc / 3;
        error += score->calibration_error / 3;
        milliseconds += score->milliseconds / 3;
      }
      std::printf("  %.4f  %11.3f %4.1f\n", auc, error, milliseconds);
    }
  }
  return 0;
}

}  // namespace

// Arguments, all optional: forgetting, tempering, focal length in pixels.
int main(int argc, char** argv) {
  const char* data = std::getenv("EGOSIEVE_DATA");
  if (data == nullptr) {
    std::fprintf(stderr, "set EGOSIEVE_DATA to the folder of the test data\n");
    return 2;
  }
  EvidenceOptions options;
  if (argc > 1) options.forgetting = std::atof(argv[1]);
  if (argc > 2) options.tempering = std::atof(argv[2]);
  if (argc > 3) options.focal_pixels = std::atof(argv[3]);
  return Print(data, options);
}
