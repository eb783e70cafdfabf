// Damages to the training photos and cameras of a scene, as they happen to users. Held-out views
// stay as they are, because they judge.
#pragma once

#include "scene/synthetic.h"

#include <cstdint>

namespace tetrec {

// A scene with one image per view; SyntheticScene serves scenes from files, too.
using SceneWithImages = SyntheticScene;

// Keeps `count` training views, evenly chosen, or all if there are fewer.
void KeepTrainingViews(SceneWithImages& given, size_t count);
// Adds every third training view once more, under another name.
void RepeatEveryThirdView(SceneWithImages& given);
// Turns the camera of the middle training view about its own y axis; its image stays.
void TurnOneCamera(SceneWithImages& given, double degrees);
// Makes the middle training image black. Alpha stays.
void BlackenOneImage(SceneWithImages& given);
// Multiplies the linear light of the middle training image by `gain`; what is too bright is
// clipped.
void ExposeOneImage(SceneWithImages& given, double gain);
// Averages every second training image over squares of 2 `radius_px` + 1 pixels, alpha included.
void BlurHalfOfImages(SceneWithImages& given, int radius_px);
// Adds Gaussian noise of this standard deviation (full scale 1) to the training images.
void AddNoise(SceneWithImages& given, double deviation, uint64_t seed);

}  // namespace tetrec
