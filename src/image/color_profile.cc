// Colour spaces by Little CMS.
#include "image/color_profile.h"

#include "core/log.h"
#include "core/short_list.h"
#include "image/jpeg_data.h"
#include "image/png_data.h"
#include "image/size_limits.h"
#include "image/tiff_file.h"

#include <lcms2.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <new>
#include <optional>
#include <type_traits>
#include <utility>

namespace tetrec {
namespace {

constexpr int kSameLevels = 2;  // rounding, and other approximations of sRGB's curve

struct CloseProfile {
  void operator()(cmsHPROFILE profile) const { cmsCloseProfile(profile); }
};
struct DeleteTransform {
  void operator()(cmsHTRANSFORM transform) const { cmsDeleteTransform(transform); }
};
struct FreeCurve {
  void operator()(cmsToneCurve* curve) const { cmsFreeToneCurve(curve); }
};
using Profile = std::unique_ptr<std::remove_pointer_t<cmsHPROFILE>, CloseProfile>;
using Transform = std::unique_ptr<std::remove_pointer_t<cmsHTRANSFORM>, DeleteTransform>;

// Empty: damaged.
std::optional<std::vector<uint8_t>> ProfileOf(std::span<const uint8_t> file,
                                              const std::string& name) {
  if (IsTiff(file)) return ColorProfileOfTiff(file, name);
  if (IsPng(file)) return ColorProfileOfPng(file, name);
  return IsJpeg(file) ? ReadJpegMarkers(file, name).color_profile : std::nullopt;
}

// The three primaries and their curves alone, which cost little to read. Tables, which a profile
// may have instead or besides, could be of any number and size. Null if the profile is damaged or
// of another kind.
Profile PrimariesAndCurves(std::span<const uint8_t> bytes) {
  if (bytes.empty() || bytes.size() > kMostColorProfile_bytes) return nullptr;
  const Profile whole(cmsOpenProfileFromMem(bytes.data(), cmsUInt32Number(bytes.size())));
  if (!whole || cmsGetColorSpace(whole.get()) != cmsSigRgbData) return nullptr;
  Profile part(cmsCreateProfilePlaceholder(nullptr));
  if (!part) throw std::bad_alloc();
  cmsSetProfileVersion(part.get(), 4.3);
  cmsSetDeviceClass(part.get(), cmsSigDisplayClass);
  cmsSetColorSpace(part.get(), cmsSigRgbData);
  cmsSetPCS(part.get(), cmsSigXYZData);
  for (const cmsTagSignature tag :
       {cmsSigRedColorantTag, cmsSigGreenColorantTag, cmsSigBlueColorantTag, cmsSigRedTRCTag,
        cmsSigGreenTRCTag, cmsSigBlueTRCTag}) {
    const void* const value = cmsReadTag(whole.get(), tag);
    if (value == nullptr || cmsWriteTag(part.get(), tag, value) == 0) return nullptr;
  }
  return part;
}

bool NotesAdobeRgb(std::span<const uint8_t> file, const std::string& name) {
  return IsJpeg(file) && ReadJpegMarkers(file, name).notes.are_adobe_rgb;
}

// Source: Adobe RGB (1998) Color Image Encoding, 2005, section 4.3.
Profile AdobeRgb() {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries{{0.64, 0.33, 1}, {0.21, 0.71, 1}, {0.15, 0.06, 1}};
  const std::unique_ptr<cmsToneCurve, FreeCurve> curve(cmsBuildGamma(nullptr, 2.19921875));
  cmsToneCurve* const curves[] = {curve.get(), curve.get(), curve.get()};
  Profile profile(cmsCreateRGBProfile(&white, &primaries, curves));
  if (!curve || !profile) throw std::bad_alloc();
  return profile;
}

// Null if the profile cannot be used.
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
  for (int r = 0; r <= kSteps; ++r) {
    for (int g = 0; g <= kSteps; ++g) {
      for (int b = 0; b <= kSteps; ++b) {
        for (const int step : {r, g, b}) before.push_back(uint8_t(255 * step / kSteps));
      }
    }
  }
  std::vector<uint8_t> after(before.size());
  cmsDoTransform(from_rgb.get(), before.data(), after.data(), cmsUInt32Number(before.size() / 3));
  return std::ranges::equal(before, after,
                            [](int a, int b) { return std::abs(a - b) <= kSameLevels; });
}

}  // namespace

ProfileUse ApplyColorProfile(std::span<const uint8_t> file, const std::string& name, Image& image) {
  const std::optional<std::vector<uint8_t>> embedded = ProfileOf(file, name);
  if (!embedded && !NotesAdobeRgb(file, name)) return ProfileUse::kNone;
  const Profile profile = embedded ? PrimariesAndCurves(*embedded) : AdobeRgb();
  Transform transform = profile ? ToSrgb(profile, TYPE_RGB_8) : nullptr;
  if (!transform) return ProfileUse::kIgnored;
  if (IsSrgb(transform)) return ProfileUse::kNone;
  if (image.channels == 4) transform = ToSrgb(profile, TYPE_RGBA_8);
  if (!transform) throw std::bad_alloc();
  for (int y = 0; y < image.height; ++y) {
    cmsDoTransform(transform.get(), image.At(0, y), image.At(0, y), cmsUInt32Number(image.width));
  }
  return ProfileUse::kApplied;
}

void LogProfileUses(const std::vector<std::string>& names, const std::vector<ProfileUse>& uses) {
  if (const auto applied = std::ranges::count(uses, ProfileUse::kApplied); applied > 0) {
    LogInfo("images in a colour space other than sRGB, converted to sRGB: {}", applied);
  }
  std::vector<std::string> ignored;
  for (size_t i = 0; i < uses.size(); ++i) {
    if (uses[i] == ProfileUse::kIgnored) ignored.push_back(names[i]);
  }
  if (ignored.empty()) return;
  LogWarning(
      "images whose colour profile is damaged, or not one of RGB primaries and curves, read as "
      "sRGB: {} ({})",
      ignored.size(), ShortList(ignored));
}

}  // namespace tetrec
