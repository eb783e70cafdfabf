// Damages to training photos and cameras.
#include "stability/picture_damage.h"

#include "core/error.h"
#include "core/random.h"
#include "core/spread_choice.h"
#include "image/srgb.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetrec {
namespace {

// The training view that a damage to a single view hits.
size_t MiddleView(const Scene& scene) {
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  TETREC_CHECK(!training.empty(), "a scene without training views");
  return size_t(training[training.size() / 2]);
}

// Calls change(r, g or b) for every colour value of the image and stores what it returns, rounded
// and clipped; values are in [0, 1].
template <class Change>
void ChangeColors(Image& image, const Change& change) {
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    if (image.channels == 4 && i % 4 == 3) continue;
    const double value = std::clamp(change(image.pixels[i] / 255.0), 0.0, 1.0);
    image.pixels[i] = uint8_t(std::lround(255 * value));
  }
}

double Gaussian(MersenneRandom& random) {  // Box and Muller 1958
  const double radius = std::sqrt(-2 * std::log(1 - random.Uniform()));
  return radius * std::cos(2 * std::numbers::pi * random.Uniform());
}

// The mean over the pixels of a square that are inside the image; colours weighted by alpha.
Image BoxBlurred(const Image& image, int radius) {
  Image blurred = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      double sum[4] = {}, weight = 0;
      int pixels = 0;
      for (int v = std::max(0, y - radius); v <= std::min(image.height - 1, y + radius); ++v) {
        for (int u = std::max(0, x - radius); u <= std::min(image.width - 1, x + radius); ++u) {
          const uint8_t* from = image.At(u, v);
          const double alpha = image.channels == 4 ? from[3] / 255.0 : 1;
          for (int c = 0; c < 3; ++c) sum[c] += alpha * from[c];
          weight += alpha;
          ++pixels;
        }
      }
      uint8_t* to = blurred.At(x, y);
      for (int c = 0; c < 3; ++c) to[c] = weight > 0 ? uint8_t(std::lround(sum[c] / weight)) : 0;
      if (image.channels == 4) to[3] = uint8_t(std::lround(255 * weight / pixels));
    }
  }
  return blurred;
}

}  // namespace

void KeepTrainingViews(SceneWithImages& given, size_t count) {
  const std::vector<int> training = given.scene.ViewsOf(Split::kTrain);
  std::vector<bool> keep(given.scene.views.size(), true);
  for (const int view : training) keep[size_t(view)] = false;
  for (const int view : SpreadChoice<int>(training, count)) keep[size_t(view)] = true;
  SceneWithImages kept = given;
  kept.scene.views.clear();
  kept.images.clear();
  for (size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    kept.scene.views.push_back(given.scene.views[i]);
    kept.images.push_back(given.images[i]);
  }
  given = std::move(kept);
}

void RepeatEveryThirdView(SceneWithImages& given) {
  const std::vector<int> training = given.scene.ViewsOf(Split::kTrain);
  for (size_t i = 0; i < training.size(); i += 3) {
    View again = given.scene.views[size_t(training[i])];
    again.name += "-again";
    again.image = again.image.substr(0, again.image.rfind('.')) + "-again.png";
    given.scene.views.push_back(again);
    given.images.push_back(given.images[size_t(training[i])]);
  }
}

void TurnOneCamera(SceneWithImages& given, double degrees) {
  const double angle = degrees * std::numbers::pi / 180, c = std::cos(angle), s = std::sin(angle);
  const glm::dmat3 turn(c, 0, -s, 0, 1, 0, s, 0, c);
  Rigid3& cam_from_world = given.scene.views[MiddleView(given.scene)].cam_from_world;
  cam_from_world = Rigid3{turn, glm::dvec3(0.0)} * cam_from_world;
}

void BlackenOneImage(SceneWithImages& given) {
  ChangeColors(given.images[MiddleView(given.scene)], [](double) { return 0.0; });
}

void ExposeOneImage(SceneWithImages& given, double gain) {
  ChangeColors(given.images[MiddleView(given.scene)], [gain](double value) {
    return SrgbFromLinear(std::min(1.0, gain * LinearFromSrgb(value)));
  });
}

void BlurHalfOfImages(SceneWithImages& given, int radius_px) {
  const std::vector<int> training = given.scene.ViewsOf(Split::kTrain);
  for (size_t i = 0; i < training.size(); i += 2) {
    Image& image = given.images[size_t(training[i])];
    image = BoxBlurred(image, radius_px);
  }
}

void AddNoise(SceneWithImages& given, double deviation, uint64_t seed) {
  MersenneRandom random(seed);
  for (const int view : given.scene.ViewsOf(Split::kTrain)) {
    ChangeColors(given.images[size_t(view)],
                 [&](double value) { return value + deviation * Gaussian(random); });
  }
}

}  // namespace tetrec
