// Import of volumes.
#include "scene/volume_import.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/short_list.h"
#include "geometry/look_at.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <random>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

constexpr const char* kGroundTruth = "ground_truth/volume.nrrd";

// What decoded samples take, and shaded ones beside them: density and colour.
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
    if (!good) throw UsageError(fmt::format("{} {}: expected {}", option, text, expected));
    at = behind + 1;
  }
  return numbers;
}

// The generator's own uniform distribution: the library's differ between implementations.
double Uniform(std::mt19937_64& generator) { return double(generator() >> 11) * 0x1p-53; }

// Uniform over all rotations: a uniform unit quaternion (Shoemake 1992).
glm::dmat3 RandomRotation(uint64_t seed) {
  std::mt19937_64 generator(seed);
  const double u = Uniform(generator), a = 2 * std::numbers::pi * Uniform(generator),
               b = 2 * std::numbers::pi * Uniform(generator);
  const double p = std::sqrt(1 - u), q = std::sqrt(u);
  return glm::mat3_cast(
      glm::dquat(q * std::cos(b), p * std::sin(a), p * std::cos(a), q * std::sin(b)));
}

Split SplitOf(int index, int holdout) {
  if (holdout == 0) return Split::kTrain;
  if (index % holdout == 0) return Split::kTest;
  return index % holdout == holdout / 2 ? Split::kValidation : Split::kTrain;
}

// Centre 0, longest side 2.
Similarity3 InputFromWorld(const Volume& volume) {
  const glm::dvec3 extent = volume.Extent();
  return {0.5 * std::max({extent.x, extent.y, extent.z}), glm::dmat3(1.0),
          volume.origin + 0.5 * extent};
}

void RenderViews(const VolumeRays& rays, const Scene& scene, int rays_per_side,
                 const fs::path& folder) {
  constexpr size_t kBlock = 16;  // between two looks at the user's wish to stop
  Progress progress("pictures", double(scene.views.size()));
  for (const View& view : scene.views) {
    fs::create_directories((folder / view.image).parent_path());
  }
  for (size_t first = 0; first < scene.views.size(); first += kBlock) {
    ThrowIfStopRequested("nothing is kept");
    const size_t count = std::min(kBlock, scene.views.size() - first);
    ParallelFor(count, 1, [&](size_t begin, size_t end) {
      for (size_t i = first + begin; i < first + end; ++i) {
        const View& view = scene.views[i];
        WriteImage(folder / view.image,
                   RenderVolume(rays, scene.cameras[0], view.cam_from_world, rays_per_side));
      }
    });
    progress.Update(double(first + count));
  }
}

void WriteGroundTruth(const fs::path& path, const Volume& volume,
                      const Similarity3& world_from_input, const VolumeRays& rays) {
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

// Integers of few of their type's values, as 12 bits stored in 16: positions that go by the type's
// range rarely mean them.
void WarnOfNarrowData(const fs::path& path, const VolumeFile& file) {
  constexpr double kNarrow = 1.0 / 8;
  const ValueRange type_range = RangeOf(file.type);
  const double least = file.volume.least_value, largest = file.volume.largest_value;
  if (!type_range || !(largest - least < kNarrow * ((*type_range)[1] - (*type_range)[0]))) return;
  LogWarning(
      "{}: its samples go from {} to {}, a small part of {}'s {} to {}; the transfer function's "
      "positions refer to the type's range, so that --value-range LOW,HIGH may be wanted",
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
        fmt::format("{}: nothing of it is visible: {} has opacity 0 everywhere; raise "
                    "it at some position",
                    path.string(), function_path.string()));
  }
  throw DataError(fmt::format(
      "{}: nothing of it is visible: its samples go from {} to {}, but {} has opacity above 0 at "
      "the values {}; move its positions{} (positions 0 and 1 are the values {} and {})",
      path.string(), volume.least_value, volume.largest_value, function_path.string(),
      ShortList(stretches), function.given_in_values ? "" : ", or give --value-range LOW,HIGH",
      volume.value_at_0, volume.value_at_1));
}

double PercentOf(size_t part, size_t all) { return 100 * double(part) / double(all); }

void TellSamples(const VolumeFile& file, size_t dense) {
  const Volume& volume = file.volume;
  LogInfo("{} x {} x {} samples of {}, {} to {}; the values {} to {} become 0 to 1", volume.size.x,
          volume.size.y, volume.size.z, Name(file.type), volume.least_value, volume.largest_value,
          volume.value_at_0, volume.value_at_1);
  LogInfo("{} samples ({:.3g} %) have opacity above 0", WithThousands(dense),
          PercentOf(dense, volume.samples.size()));
  if (volume.clamped == 0) return;
  LogInfo("{} samples ({:.3g} %) lie outside of --value-range and are clamped",
          WithThousands(volume.clamped), PercentOf(volume.clamped, volume.samples.size()));
}

}  // namespace

VolumeLayout VolumeImportOptions::Layout() const {
  VolumeLayout layout;
  const auto size =
      ThreeNumbers<int>(dimensions, "--dimensions", "samples along x, y and z, like 103x94x161");
  layout.size = {size[0], size[1], size[2]};
  const std::optional<SampleType> type = FromName<SampleType>(sample_type);
  if (!type) {
    throw UsageError(
        fmt::format("--sample-type {}: expected {}", sample_type, AllNames<SampleType>()));
  }
  layout.type = *type;
  if (!byte_order.empty() && byte_order != "little" && byte_order != "big") {
    throw UsageError(fmt::format("--byte-order {}: expected little or big", byte_order));
  }
  layout.big_endian = byte_order == "big";
  if (!spacing.empty()) {
    const auto sides = ThreeNumbers<double>(spacing, "--spacing",
                                            "three numbers above 0 along x, y and z, like 1x1x1.5");
    layout.spacing = {sides[0], sides[1], sides[2]};
  }
  try {
    layout.Check("--dimensions and --spacing");
  } catch (const DataError& error) {  // here it is the command line that is wrong
    throw UsageError(error.what());
  }
  return layout;
}

ValueRange VolumeImportOptions::Range() const {
  if (value_range.empty()) return std::nullopt;
  return glm::dvec2(value_range.at(0), value_range.at(1));
}

void VolumeImportOptions::Check() const {
  const auto expect = [](bool good, const char* option, const auto& value, const char* expected) {
    if (!good) throw UsageError(fmt::format("{} {}: expected {}", option, value, expected));
  };
  const bool good_range =
      value_range.empty() || (value_range.size() == 2 && value_range[0] < value_range[1] &&
                              std::isfinite(value_range[1] - value_range[0]));
  expect(good_range, "--value-range", fmt::format("{}", fmt::join(value_range, ",")),
         "two numbers, the first below the second: the values that become 0 and 1");
  expect(attenuation > 0 && attenuation <= 1e6, "--attenuation", attenuation,
         "a number above 0 and up to 1e6");
  expect(cameras >= 3 && cameras <= 100000, "--cameras", cameras, "3 to 100000");
  expect(size_px >= 1 && size_px <= 8192, "--size", size_px, "1 to 8192 pixels");
  expect(holdout == 0 || holdout >= 3, "--holdout", holdout,
         "0 or 3 and more: of so many views of a volume one is for test, one for validation");
  expect(rays_per_side >= 1 && rays_per_side <= 16, "--rays-per-side", rays_per_side, "1 to 16");
  if (background == Background::kScene) {
    throw UsageError("--background scene: pictures with alpha need white or black");
  }
}

void VolumeImportOptions::CheckFor(const fs::path& volume) const {
  if (NeedsLayout(volume)) {
    if (dimensions.empty() || sample_type.empty()) {
      throw UsageError(fmt::format(
          "{}: a raw file does not tell its layout; give --dimensions and --sample-type",
          volume.string()));
    }
    Layout();
    return;
  }
  const std::pair<const char*, const std::string&> raw_only[] = {{"--dimensions", dimensions},
                                                                 {"--sample-type", sample_type},
                                                                 {"--byte-order", byte_order},
                                                                 {"--spacing", spacing}};
  for (const auto& [option, value] : raw_only) {
    if (!value.empty()) {
      throw UsageError(fmt::format("{} {}: is for .raw files; the header of {} tells its layout",
                                   option, value, volume.string()));
    }
  }
}

void AddSphereOfViews(const VolumeImportOptions& options, double radius, Scene& scene) {
  const int count = options.cameras, size_px = options.size_px;
  const double distance = 2.5 * radius;
  // The ball fills the shorter side: its outline is seen under asin(radius / distance).
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
      "{}: {} x {} x {} samples need {:.1f} GiB of memory, {} has {:.1f} GiB free; take every "
      "second sample, or a machine with more memory",
      name, layout.size.x, layout.size.y, layout.size.z, gib(needed), free.of, gib(free.bytes)));
}

ImportedVolume ImportVolume(const fs::path& path, const fs::path& transfer_function,
                            const fs::path& folder, const VolumeImportOptions& options,
                            const FreeMemory& free) {
  options.Check();
  options.CheckFor(path);
  const bool is_raw = NeedsLayout(path);
  const VolumeLayout layout = is_raw ? options.Layout() : ReadVolumeLayout(path);
  CheckVolumeMemory(layout, path.string(), free);
  ImportedVolume imported;
  imported.file =
      is_raw ? ReadRawVolume(path, layout, options.Range()) : ReadVolume(path, options.Range());
  const Volume& volume = imported.file.volume;
  const TransferFunction function =
      ReadTransferFunction(transfer_function, {volume.value_at_0, volume.value_at_1});
  if (!options.Range() && !function.given_in_values) WarnOfNarrowData(path, imported.file);

  Scene& scene = imported.scene;
  scene.background = options.background;
  scene.has_alpha = true;
  scene.input_from_world = InputFromWorld(volume);
  const Similarity3 world_from_input = scene.input_from_world.Inverse();
  scene.subject_bounds = {world_from_input * volume.origin,
                          world_from_input * (volume.origin + volume.Extent())};
  AddSphereOfViews(options, 0.5 * scene.subject_bounds.Diagonal(), scene);

  // The longest side is 2 world units.
  const VolumeRays rays(volume, function, 0.5 * options.attenuation, options.shading,
                        world_from_input);
  imported.dense_samples = rays.CountDense();
  TellSamples(imported.file, imported.dense_samples);
  if (!rays.AnythingVisible()) FailInvisible(path, volume, transfer_function, function);
  WriteGroundTruth(folder / kGroundTruth, volume, world_from_input, rays);
  RenderViews(rays, scene, options.rays_per_side, folder);
  WriteScene(folder, scene);
  return imported;
}

void RunVolumeImport(const VolumeImportOptions& options, Stage& stage) {
  const Timer timer;
  for (const char* output : {"scene.json", "images", kGroundTruth}) stage.Output(output);
  const ImportedVolume imported = ImportVolume(
      stage.Input("DATASET"), stage.Input("transfer-function"), stage.folder(), options);
  const Scene& scene = imported.scene;
  const Volume& volume = imported.file.volume;
  LogInfo("{} training, {} validation, {} test views", scene.ViewsOf(Split::kTrain).size(),
          scene.ViewsOf(Split::kValidation).size(), scene.ViewsOf(Split::kTest).size());
  if (!imported.file.unused_fields.empty()) {
    LogInfo("fields of the header that nothing here depends on: {}",
            fmt::join(imported.file.unused_fields, ", "));
  }
  const Camera& camera = scene.cameras[0];
  LogInfo("pictures of {} x {} pixels", camera.width, camera.height);
  stage.Note("resolution", {camera.width, camera.height});
  stage.Count("samples", {volume.size.x, volume.size.y, volume.size.z});
  stage.Count("samples_with_opacity", imported.dense_samples);
  stage.Count("clamped_samples", volume.clamped);
  stage.Count("train_views", scene.ViewsOf(Split::kTrain).size());
  stage.Count("validation_views", scene.ViewsOf(Split::kValidation).size());
  stage.Count("test_views", scene.ViewsOf(Split::kTest).size());
  stage.Count("cameras", scene.cameras.size());
  stage.Note("sample_type", Name(imported.file.type));
  stage.Note("value_at_0", volume.value_at_0);
  stage.Note("value_at_1", volume.value_at_1);
  stage.Note("least_value", volume.least_value);
  stage.Note("largest_value", volume.largest_value);
  stage.Note("unused_header_fields", imported.file.unused_fields);
  stage.Seconds("import", timer.seconds());
}

}  // namespace tetrec
