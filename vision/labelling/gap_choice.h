// How many pictures lie between the two of a pair (frame_gap auto): enough for parallax.
//
//   p <- p^(1-w) (parallax / gap)^w        pixels a picture, tracked over the drive          (GC1)
//   gap = ceil(wanted / p),  at most `longest`                                               (GC2)
//
// parallax is what the camera's rotation leaves unexplained of half of the static places
// (two_view_motion.h), wanted 3 pixels. A camera that hardly travels takes the longest gap: what
// moves slowly shows there, and what is fast is followed over one picture (pair_motions.h). On
// davis-train, mean AUC and IoU of the dense map: 0.986 and 0.65 so, 0.983 and 0.62 with gap 1
// wherever p is below 0.35.
//
// The gap stays as it is while wanted / p moves by less than `margin` beyond it, so that three
// views find equal gaps.
#ifndef EGOSIEVE_VISION_LABELLING_GAP_CHOICE_H_
#define EGOSIEVE_VISION_LABELLING_GAP_CHOICE_H_

namespace egosieve::vision {

struct GapState {
  int gap = 1;
  bool has_parallax = false;
  double log_parallax = 0.0;  // log p
};

// parallax_pixels: of a pair with `gap` pictures between.
void ObserveParallax(double parallax_pixels, int gap, int longest, GapState& state);

}  // namespace egosieve::vision

#endif  // EGOSIEVE_VISION_LABELLING_GAP_CHOICE_H_
