// Unwraps a surface and bakes its texture.
#include "surface/texture.h"

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "surface/texture_bake.h"
#include "surface/texture_charts.h"
#include "surface/texture_fit.h"
#include "surface/texture_layout.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

constexpr int kLargestAutomaticSize = 4096;  // that every browser and program can show

// A surface moves by its texture only if texels are no longer than this many of the photos' pixels:
// coarser ones cannot show what the photos show, and the surface would bend to it.
constexpr double kLongestTexel_px = 1.5;

// `footprint`: length of the median photo's pixel on the surface.
TextureLayout LayOut(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                     double footprint, const TextureChoice& choice) {
  if (choice.size > 0) return LayOutTextureOfSize(mesh, charts, choice.size);
  return LayOutTexture(mesh, charts, footprint, kLargestAutomaticSize);
}

struct FittedTexture {
  double footprint = 0;  // of the median photo's pixel on the surface
  size_t charts = 0;
  TextureLayout layout;
  BakedTexture baked;
  TextureFit fit;
};

// Gives the mesh texture coordinates and moves it. Returns nothing if no photo sees it.
std::optional<FittedTexture> Fit(TriangleMesh& mesh, const TriangleMesh& hiding,
                                 std::span<TexturePhoto> photos, const TextureChoice& choice,
                                 int moves) {
  FindTrust(mesh, photos, hiding);
  const double footprint = MedianFootprint(mesh, photos);
  if (footprint == 0) return std::nullopt;
  const std::vector<TextureChart> charts = CutIntoCharts(mesh);
  FittedTexture fitted{footprint, charts.size(), LayOut(mesh, charts, footprint, choice), {}, {}};
  fitted.baked = BakeTexture(mesh, fitted.layout, photos);
  mesh.corner_coordinates = CornerCoordinates(fitted.layout);
  const bool is_fine = fitted.layout.texel_size <= kLongestTexel_px * footprint;
  fitted.fit = FitTexture(mesh, fitted.layout, photos, is_fine ? moves : 0, fitted.baked.image);
  return fitted;
}

void ReportMoves(const TextureFit& fit, Stage& stage) {
  if (!(fit.error > 0)) return;
  LogInfo(
      "alignment by the texture: vertices moved by {:.2g} pixels on average; the surface is off by "
      "{:.1f} levels of 255 (root mean square)",
      fit.mean_move_px, 255 * fit.error);
  stage.Count("texture_alignment", {{"mean_move_px", fit.mean_move_px}, {"error", fit.error}});
}

}  // namespace

TextureChoice ParseTextureChoice(const std::string& text) {
  if (text == "auto") return {};
  if (text == "off") return {false, 0};
  int size = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), size);
  if (error != std::errc() || end != text.data() + text.size() || size < kMinTextureSize ||
      size > kMaxTextureSize) {
    throw UsageError(fmt::format("'{}' is no texture size; expected auto, off, or {} to {} texels",
                                 text, kMinTextureSize, kMaxTextureSize));
  }
  return {true, size};
}

TexturedMesh MakeTexture(TriangleMesh mesh, const TriangleMesh& hiding,
                         std::span<TexturePhoto> photos, const TextureChoice& choice, int moves,
                         Stage& stage) {
  std::optional<FittedTexture> fitted = Fit(mesh, hiding, photos, choice, moves);
  if (!fitted) {
    LogWarning("no texture, only vertex colours: none of {} photos sees the surface",
               photos.size());
    return {std::move(mesh), {}};
  }
  if (choice.size == 0 && fitted->layout.texel_size > fitted->footprint) {
    LogInfo(
        "texture: texels are {:.2f} times as long as the photos' pixels on the surface are in the "
        "median, because it would have more than {} x {} texels; a size of your own may be up to "
        "{}",
        fitted->layout.texel_size / fitted->footprint, kLargestAutomaticSize, kLargestAutomaticSize,
        kMaxTextureSize);
  }
  LogInfo(
      "texture: {} x {} texels of {:.3g} world units, {} charts; photos show {:.1f} % of it well",
      fitted->layout.size, fitted->layout.size, fitted->layout.texel_size,
      WithThousands(fitted->charts), 100 * fitted->baked.seen_share);
  stage.Count("texture", {{"size", fitted->layout.size},
                          {"texel_size", fitted->layout.texel_size},
                          {"charts", fitted->charts},
                          {"photos", photos.size()},
                          {"triangles_with_more_photos", fitted->baked.limited_triangles},
                          {"seen_share", fitted->baked.seen_share}});
  ReportMoves(fitted->fit, stage);
  return {std::move(mesh), std::move(fitted->baked.image)};
}

TriangleMesh AlignByTexture(TriangleMesh mesh, std::span<TexturePhoto> photos,
                            const TextureChoice& choice, int moves, Stage& stage) {
  const std::optional<FittedTexture> fitted = Fit(mesh, {}, photos, choice, moves);
  if (fitted) ReportMoves(fitted->fit, stage);
  mesh.corner_coordinates.clear();
  return mesh;
}

}  // namespace tetrec
