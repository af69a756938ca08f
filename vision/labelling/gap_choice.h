// How many pictures lie between the two of a pair (frame_gap auto): enough for parallax.
//
//   p <- p^(1-w) (parallax / gap)^w        pixels a picture, tracked over the drive          (G1)
//   gap = ceil(wanted / p),  at most `longest`;  1 where p < least                           (G2)
//
// wanted is 1.5: over 34 synthetic drives (walked and driven, 320 and 640 pixels wide) labels had a
// mean AUC of 0.886 at the gap of (G2), 0.876 with 2 pixels wanted, 0.879 with 1, 0.858 at gap 1
// throughout and 0.892 at the best gap of each. A longer gap is not the better one by itself: what
// is near changes its look, and what moves covers and uncovers more.
//
// parallax is what the best homography leaves unexplained (motion_model.h). Where it leaves next to
// nothing (a camera that turns, far scenes in the hand) a longer gap brings none, only longer flow.
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
