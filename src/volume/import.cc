// Imports volumes.
#include "volume/import.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/short_list.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "geometry/look_at.h"
#include "geometry/random_vectors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

constexpr const char* kGroundTruth = "ground_truth/volume.nrrd";

// Memory of a decoded sample and, in addition, of its shaded form (density and colour).
constexpr uint64_t kBytesPerSample = sizeof(float), kBytesPerShaded = sizeof(glm::vec4);

// "AxBxC"
template <class T>
std::array<T, 3> ThreeNumbers(const std::string& text, const char* option, const char* expected) {
  std::array<T, 3> numbers{};
  const char* at = text.data();
  const char* end = at + text.size();
  for (size_t i = 0; i < 3; ++i) {
    const auto [behind, error] = std::from_chars(at, end, numbers[i]);
    const bool last = i == 2;
    const bool good =
        error == std::errc() && (last ? behind == end : behind < end && *behind == 'x');
    if (!good) throw UsageError(fmt::format("{} is {}; expected {}", option, text, expected));
    at = behind + 1;
  }
  return numbers;
}

// Uniform over all rotations. The parts of the quaternion are in the order in which scenes have
// always been turned: a seed keeps its views.
glm::dmat3 RandomRotation(uint64_t seed) {
  MersenneRandom random(seed);
  const glm::dquat q = RandomQuaternion(random);
  return glm::mat3_cast(glm::dquat(q.z, q.w, q.x, q.y));
}

// Test views as in photo scenes, and a validation view in the middle between two of them.
Split SplitOf(int index, int holdout) {
  if (IsHeldOut(size_t(index), holdout)) return Split::kTest;
  const bool is_middle = holdout > 0 && index % holdout == holdout / 2;
  return is_middle ? Split::kValidation : Split::kTrain;
}

// To a world in which the volume has centre 0 and longest side 2.
Similarity3 InputFromWorld(const Volume& volume) {
  const glm::dvec3 extent = volume.Extent();
  return {0.5 * std::max({extent.x, extent.y, extent.z}), glm::dmat3(1.0),
          volume.origin + 0.5 * extent};
}

void RenderViews(const RayIntegrator& rays, const Scene& scene, int rays_per_side,
                 const fs::path& folder) {
  for (const View& view : scene.views) {
    fs::create_directories((folder / view.image).parent_path());
  }
  ParallelForEach(scene.views.size(), "images", "nothing is kept", [&](size_t i) {
    const View& view = scene.views[i];
    WriteImage(folder / view.image,
               RenderVolume(rays, scene.cameras[0], view.cam_from_world, rays_per_side));
  });
}

void WriteGroundTruth(const fs::path& path, const Volume& volume,
                      const Similarity3& world_from_input, const RayIntegrator& rays) {
  const glm::dvec3 origin = world_from_input * volume.origin;
  const glm::dvec3 spacing = world_from_input.scale * volume.spacing;
  const std::string header = fmt::format(
      "NRRD0004\n# density [1 / world unit] and display sRGB at every sample\ntype: float\n"
      "dimension: 4\nsizes: 4 {} {} {}\nkinds: vector space space space\nspace dimension: 3\n"
      "space directions: none ({},0,0) (0,{},0) (0,0,{})\nspace origin: ({},{},{})\n"
      "encoding: raw\nendian: little\n\n",
      volume.size.x, volume.size.y, volume.size.z, spacing.x, spacing.y, spacing.z, origin.x,
      origin.y, origin.z);
  static_assert(sizeof(glm::vec4) == 4 * sizeof(float));
  const std::span<const glm::vec4> shaded(rays.shaded_samples());
  fs::create_directories(path.parent_path());
  FileWriter writer(path, header.size() + shaded.size_bytes());
  writer.WriteArray(std::span<const char>(header));
  writer.WriteArray(shaded);
  writer.Finish();
}

// Warns about integers that use a small part of their type's range, such as 12 bits stored in 16: a
// transfer function for the whole range of the type is rarely meant for them.
void WarnOfNarrowData(const fs::path& path, const VolumeFile& file) {
  constexpr double kNarrow = 1.0 / 8;
  const ValueRange type_range = RangeOf(file.type);
  const double least = file.volume.least_value, largest = file.volume.largest_value;
  if (!type_range || !(largest - least < kNarrow * ((*type_range)[1] - (*type_range)[0]))) return;
  LogWarning(
      "{}: its samples range from {} to {}, a small part of {}'s {} to {}; the transfer function's "
      "positions refer to the type's range, so they may need the data's own value range LOW,HIGH",
      path.string(), least, largest, Name(file.type), (*type_range)[0], (*type_range)[1]);
}

[[noreturn]] void FailInvisible(const fs::path& path, const Volume& volume,
                                const fs::path& function_path, const TransferFunction& function) {
  std::vector<std::string> stretches;
  const double span = volume.value_at_1 - volume.value_at_0;
  for (const glm::dvec2& stretch : function.OpaqueStretches()) {
    stretches.push_back(fmt::format("{:.6g} to {:.6g}", volume.value_at_0 + span * stretch[0],
                                    volume.value_at_0 + span * stretch[1]));
  }
  if (stretches.empty()) {
    throw DataError(
        fmt::format("{}: nothing in it is visible: {} has opacity 0 everywhere; raise "
                    "it at some position",
                    path.string(), function_path.string()));
  }
  throw DataError(fmt::format(
      "{}: nothing in it is visible: its samples range from {} to {}, but {} has opacity above 0 "
      "at "
      "the values {}; move its positions{} (positions 0 and 1 are the values {} and {})",
      path.string(), volume.least_value, volume.largest_value, function_path.string(),
      ShortList(stretches), function.given_in_values ? "" : ", or give a value range LOW,HIGH",
      volume.value_at_0, volume.value_at_1));
}

double PercentOf(size_t part, size_t all) { return 100 * double(part) / double(all); }

void LogSamples(const VolumeFile& file, size_t dense) {
  const Volume& volume = file.volume;
  LogInfo("{} x {} x {} samples of {}, {} to {}; the values {} to {} become 0 to 1", volume.size.x,
          volume.size.y, volume.size.z, Name(file.type), volume.least_value, volume.largest_value,
          volume.value_at_0, volume.value_at_1);
  LogInfo("{} samples ({:.3g} %) have opacity above 0", WithThousands(dense),
          PercentOf(dense, volume.samples.size()));
  if (volume.clamped == 0) return;
  LogInfo("{} samples ({:.3g} %) are outside the value range and are clamped",
          WithThousands(volume.clamped), PercentOf(volume.clamped, volume.samples.size()));
}

}  // namespace

glm::ivec3 ParseDimensions(const std::string& text) {
  const auto size =
      ThreeNumbers<int>(text, "dimensions", "samples along x, y and z, like 103x94x161");
  return {size[0], size[1], size[2]};
}

glm::dvec3 ParseSpacing(const std::string& text) {
  const auto sides =
      ThreeNumbers<double>(text, "spacing", "three numbers above 0 along x, y and z, like 1x1x1.5");
  return {sides[0], sides[1], sides[2]};
}

VolumeLayout VolumeImportOptions::Layout() const {
  TETREC_CHECK(dimensions && sample_type, "a raw volume without its layout");
  VolumeLayout layout;
  layout.size = *dimensions;
  layout.type = *sample_type;
  layout.big_endian = byte_order == ByteOrder::kBig;
  if (spacing) layout.spacing = *spacing;
  try {
    layout.Check("raw layout");
  } catch (const DataError& error) {  // the options are wrong, not a file
    throw UsageError(error.what());
  }
  return layout;
}

void VolumeImportOptions::Check() const {
  const auto expect = [](bool good, const char* option, const auto& value, const char* expected) {
    if (!good) throw UsageError(fmt::format("{} is {}; expected {}", option, value, expected));
  };
  if (value_range) {
    const auto [low, high] = std::pair((*value_range)[0], (*value_range)[1]);
    expect(low < high && std::isfinite(high - low), "value-range", fmt::format("{},{}", low, high),
           "two numbers, the first below the second: the values that become 0 and 1");
  }
  expect(attenuation > 0 && attenuation <= 1e6, "attenuation", attenuation,
         "a number above 0, at most 1e6");
  expect(cameras >= 3 && cameras <= 100000, "cameras", cameras, "3 to 100000");
  expect(size_px >= 1 && size_px <= 8192, "size", size_px, "1 to 8192 pixels");
  expect(holdout == 0 || holdout >= 3, "holdout", holdout,
         "0 or at least 3: of this many views of a volume, one is for test and one for validation");
  expect(rays_per_side >= 1 && rays_per_side <= 16, "rays-per-side", rays_per_side, "1 to 16");
  expect(background != Background::kScene, "background", Name(background),
         "white or black behind images with alpha");
}

void VolumeImportOptions::CheckFor(const fs::path& volume) const {
  if (NeedsLayout(volume)) {
    if (!dimensions || !sample_type) {
      throw UsageError(fmt::format(
          "{}: a raw file does not specify its layout; give its dimensions and its sample type",
          volume.string()));
    }
    Layout();
    return;
  }
  const std::pair<const char*, bool> raw_only[] = {{"dimensions", dimensions.has_value()},
                                                   {"sample-type", sample_type.has_value()},
                                                   {"byte-order", byte_order.has_value()},
                                                   {"spacing", spacing.has_value()}};
  for (const auto& [option, is_given] : raw_only) {
    if (!is_given) continue;
    throw UsageError(fmt::format("{} is for .raw files only; the header of {} specifies its layout",
                                 option, volume.string()));
  }
}

void AddSphereOfViews(const VolumeImportOptions& options, double radius, Scene& scene) {
  const int count = options.cameras, size_px = options.size_px;
  const double distance = 2.5 * radius;
  // The ball fills the image: its outline appears at the angle asin(radius / distance).
  const double focal_px = 0.5 * size_px * std::sqrt(distance * distance - radius * radius) / radius;
  const int camera = int(scene.cameras.size());
  scene.cameras.push_back({size_px, size_px, focal_px, focal_px, 0.5 * size_px, 0.5 * size_px});
  const glm::dmat3 turn = RandomRotation(options.seed);
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2.0 * i + 1) / count, r = std::sqrt(1 - z * z);
    const glm::dvec3 lattice(r * std::cos(golden_angle * i), r * std::sin(golden_angle * i), z);
    View view;
    view.camera = camera;
    view.split = SplitOf(i, options.holdout);
    view.name = fmt::format("{}/{:05}", Name(view.split), i);
    view.image = "images/" + view.name + ".png";
    view.cam_from_world = CamLookingAt(distance * (turn * lattice), glm::dvec3(0.0));
    scene.views.push_back(std::move(view));
  }
}

void CheckVolumeMemory(const VolumeLayout& layout, const std::string& name,
                       const FreeMemory& free) {
  const uint64_t needed = layout.Count() * (kBytesPerSample + kBytesPerShaded);
  if (needed <= free.bytes) return;
  const auto gib = [](uint64_t bytes) { return double(bytes) * 0x1p-30; };
  throw EnvironmentError(fmt::format(
      "{}: {} x {} x {} samples need {:.1f} GiB of memory, {} has {:.1f} GiB free; reduce it to "
      "every "
      "second sample, or use a machine with more memory",
      name, layout.size.x, layout.size.y, layout.size.z, gib(needed), free.of, gib(free.bytes)));
}

ImportedVolume ReadVolumeForImport(const fs::path& path, const fs::path& transfer_function,
                                   const VolumeImportOptions& options, const FreeMemory& free) {
  options.Check();
  options.CheckFor(path);
  const bool is_raw = NeedsLayout(path);
  const VolumeLayout layout = is_raw ? options.Layout() : ReadVolumeLayout(path);
  CheckVolumeMemory(layout, path.string(), free);
  auto file =
      std::make_unique<const VolumeFile>(is_raw ? ReadRawVolume(path, layout, options.value_range)
                                                : ReadVolume(path, options.value_range));
  const Volume& volume = file->volume;
  const TransferFunction function =
      ReadTransferFunction(transfer_function, {volume.value_at_0, volume.value_at_1});
  if (!options.value_range && !function.given_in_values) WarnOfNarrowData(path, *file);

  Scene scene;
  scene.background = options.background;
  scene.has_alpha = true;
  scene.input_from_world = InputFromWorld(volume);
  const Similarity3 world_from_input = scene.input_from_world.Inverse();
  scene.subject_bounds = {world_from_input * volume.origin,
                          world_from_input * (volume.origin + volume.Extent())};
  AddSphereOfViews(options, 0.5 * scene.subject_bounds.Diagonal(), scene);

  // The longest side is 2 world units.
  RayIntegrator rays(volume, function, 0.5 * options.attenuation, options.shading,
                     world_from_input);
  LogSamples(*file, rays.CountDense());
  if (!rays.AnythingVisible()) FailInvisible(path, volume, transfer_function, function);
  return {std::move(scene), std::move(file), std::move(rays)};
}

void WriteImportedVolume(const ImportedVolume& imported, int rays_per_side,
                         const fs::path& folder) {
  const Scene& scene = imported.scene;
  WriteGroundTruth(folder / kGroundTruth, imported.file->volume, scene.input_from_world.Inverse(),
                   imported.rays);
  RenderViews(imported.rays, scene, rays_per_side, folder);
  WriteScene(folder, scene);
}

void RunVolumeImport(const VolumeImportOptions& options, Stage& stage) {
  const Timer timer;
  const ImportedVolume imported =
      ReadVolumeForImport(stage.Input("DATASET"), stage.Input("transfer-function"), options);
  for (const char* output : {"scene.json", "images", kGroundTruth}) stage.Output(output);
  WriteImportedVolume(imported, options.rays_per_side, stage.folder());
  const Scene& scene = imported.scene;
  const VolumeFile& file = *imported.file;
  const Volume& volume = file.volume;
  LogInfo("{} training, {} validation, {} test views", scene.ViewsOf(Split::kTrain).size(),
          scene.ViewsOf(Split::kValidation).size(), scene.ViewsOf(Split::kTest).size());
  if (!file.unused_fields.empty()) {
    LogInfo("unused fields of the header: {}", fmt::join(file.unused_fields, ", "));
  }
  const Camera& camera = scene.cameras[0];
  LogInfo("images of {} x {} pixels", camera.width, camera.height);
  stage.Note("resolution", {camera.width, camera.height});
  stage.Count("samples", {volume.size.x, volume.size.y, volume.size.z});
  stage.Count("samples_with_opacity", imported.rays.CountDense());
  stage.Count("clamped_samples", volume.clamped);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  stage.Count("cameras", scene.cameras.size());
  stage.Note("sample_type", Name(file.type));
  stage.Note("value_at_0", volume.value_at_0);
  stage.Note("value_at_1", volume.value_at_1);
  stage.Note("least_value", volume.least_value);
  stage.Note("largest_value", volume.largest_value);
  stage.Note("unused_header_fields", file.unused_fields);
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
