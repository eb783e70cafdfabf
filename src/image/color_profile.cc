// ICC colour profiles, by Little CMS.
#include "image/color_profile.h"

#include "core/log.h"
#include "image/big_endian.h"
#include "image/jpeg_data.h"
#include "image/png_data.h"
#include "image/tiff_file.h"

#include <lcms2.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

namespace tetrec {
namespace {

// More than the tables of a printer have. A short file may give a long profile once inflated.
constexpr size_t kMostProfile_bytes = size_t{1} << 23;

constexpr int kSameLevels = 2;  // rounding, and other approximations of sRGB's curve

struct CloseProfile {
  void operator()(cmsHPROFILE profile) const { cmsCloseProfile(profile); }
};
struct DeleteTransform {
  void operator()(cmsHTRANSFORM transform) const { cmsDeleteTransform(transform); }
};
using Profile = std::unique_ptr<std::remove_pointer_t<cmsHPROFILE>, CloseProfile>;
using Transform = std::unique_ptr<std::remove_pointer_t<cmsHTRANSFORM>, DeleteTransform>;

// Empty if the data is damaged or too long.
std::vector<uint8_t> Inflated(std::span<const uint8_t> data) {
  std::vector<uint8_t> profile(kMostProfile_bytes);
  uLongf size = profile.size();
  if (uncompress(profile.data(), &size, data.data(), uLong(data.size())) != Z_OK) size = 0;
  profile.resize(size);
  return profile;
}

// The content of a PNG's iCCP chunk: a name, a zero, the method of compression (0), and the profile
// (PNG, ISO 15948, section 11.3.3.3).
std::vector<uint8_t> ProfileOfChunk(std::span<const uint8_t> chunk) {
  const auto zero = std::ranges::find(chunk, uint8_t(0));
  const auto begin = size_t(zero - chunk.begin());
  return chunk.size() - begin < 2 ? std::vector<uint8_t>() : Inflated(chunk.subspan(begin + 2));
}

// Empty if there is none; not checked.
std::vector<uint8_t> ProfileOf(std::span<const uint8_t> file, const std::string& name) {
  if (IsTiff(file)) return ColorProfileOfTiff(file, name);
  if (IsPng(file)) {
    const PngFacts facts = ReadPngChunks(file, name);
    return facts.color_profile.empty() ? std::vector<uint8_t>()
                                       : ProfileOfChunk(facts.color_profile);
  }
  return IsJpeg(file) ? ReadJpegMarkers(file, name).color_profile : std::vector<uint8_t>();
}

Transform ToSrgb(const Profile& from, cmsUInt32Number format) {
  const Profile srgb(cmsCreate_sRGBProfile());
  return Transform(cmsCreateTransform(from.get(), format, srgb.get(), format,
                                      INTENT_RELATIVE_COLORIMETRIC,
                                      cmsFLAGS_BLACKPOINTCOMPENSATION | cmsFLAGS_COPY_ALPHA));
}

// By colours all over the space.
bool IsSrgb(const Transform& from_rgb) {
  constexpr int kSteps = 8;
  std::vector<uint8_t> before;
  for (int i = 0; i < (kSteps + 1) * (kSteps + 1) * (kSteps + 1); ++i) {
    for (const int step :
         {i % (kSteps + 1), i / (kSteps + 1) % (kSteps + 1), i / ((kSteps + 1) * (kSteps + 1))}) {
      before.push_back(uint8_t(255 * step / kSteps));
    }
  }
  std::vector<uint8_t> after(before.size());
  cmsDoTransform(from_rgb.get(), before.data(), after.data(), cmsUInt32Number(before.size() / 3));
  return std::ranges::equal(before, after,
                            [](int a, int b) { return std::abs(a - b) <= kSameLevels; });
}

}  // namespace

void ApplyColorProfile(std::span<const uint8_t> file, const std::string& name, Image& image) {
  const std::vector<uint8_t> bytes = ProfileOf(file, name);
  if (bytes.empty()) return;
  const Profile profile(cmsOpenProfileFromMem(bytes.data(), cmsUInt32Number(bytes.size())));
  const bool is_rgb = profile && cmsGetColorSpace(profile.get()) == cmsSigRgbData;
  const Transform probe = is_rgb ? ToSrgb(profile, TYPE_RGB_8) : nullptr;
  if (!probe) {
    LogWarning("{}: its colour profile is {}; its numbers are taken for sRGB", name,
               profile && !is_rgb ? "not one of RGB" : "damaged");
    return;
  }
  if (IsSrgb(probe)) return;
  const Transform transform = ToSrgb(profile, image.channels == 4 ? TYPE_RGBA_8 : TYPE_RGB_8);
  for (int y = 0; y < image.height; ++y) {
    cmsDoTransform(transform.get(), image.At(0, y), image.At(0, y), cmsUInt32Number(image.width));
  }
}

}  // namespace tetrec
