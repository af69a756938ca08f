// What every labelled frame must be, and two that must be the same.
#pragma once

#include "vision/labelling/labelled_frame.h"

namespace egosieve::vision {

// Counts that belong together, values in their ranges, places inside the picture, and labels or a
// reason.
void ExpectWellFormed(const LabelledFrame& frame);

// But for the times, to the last bit.
void ExpectSame(const LabelledFrame& a, const LabelledFrame& b);

}  // namespace egosieve::vision
