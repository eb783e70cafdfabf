// The hold-out rule: every N-th view by name is held out for judging, the others train.
#pragma once

#include "scene/scene.h"

#include <algorithm>
#include <vector>

namespace tetrec {

// N of most published results on photos.
inline constexpr int kUsualHoldout = 8;

// Throws UsageError unless `every` is 0 (no view is held out) or leaves some view to train on.
void CheckHoldout(int every);

// Whether the view at this place in the order of names is held out: the first is, and every
// `every`-th after it. An `every` of 0 holds out none.
bool IsHeldOut(size_t place, int every);

// Sorts views (or anything else with a name and a split) by name, makes the held-out ones test
// views and the others training views.
template <class Named>
void HoldOut(std::vector<Named>& views, int every) {
  std::sort(views.begin(), views.end(),
            [](const Named& a, const Named& b) { return a.name < b.name; });
  for (size_t i = 0; i < views.size(); ++i) {
    views[i].split = IsHeldOut(i, every) ? Split::kTest : Split::kTrain;
  }
}

}  // namespace tetrec
