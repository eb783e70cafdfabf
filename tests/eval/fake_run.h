// A made-up run folder like those that the stages leave, for tests of code that only reads runs.
#pragma once

#include "core/file.h"
#include "image/image.h"
#include "mesh/triangle_shapes.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct FakeRun {
  std::vector<std::string> view_names = {"test/r_0", "test/r_1", "test/r_2"};
  std::string dataset = "../../data/fake";
  bool with_masks = true;
  bool with_field_folder = true;  // false: the chain of manifests is broken there
  double noise = 6;               // of the renders [8-bit steps]
  double gain = 1;                // of the renders
  std::vector<std::string> warnings;
};

inline Image TestPicture(int width, int height, int variant) {
  Image image{width, height, 3, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double u = double(x) / width, v = double(y) / height;
      for (int c = 0; c < 3; ++c) {
        const double wave = std::sin(9 * u + 2 * c + variant) * std::cos(7 * v - c);
        image.pixels.push_back(uint8_t(std::lround(127 + 90 * wave)));
      }
    }
  }
  return image;
}

// Adds a fixed pattern of about +-amount; no random numbers, so equal everywhere.
inline Image Disturbed(const Image& image, double amount) {
  Image other = image;
  for (size_t i = 0; i < other.pixels.size(); ++i) {
    const double step = amount * std::sin(double(i * i % 1013));
    other.pixels[i] = uint8_t(std::clamp(std::lround(other.pixels[i] + step), 0l, 255l));
  }
  return other;
}

// Cameras on a ring around the origin, looking at it, z up.
inline Scene TestScene(const std::vector<std::string>& held_out) {
  Scene scene;
  scene.cameras.push_back({64, 48, 60, 60, 32, 24});
  scene.background = Background::kWhite;
  scene.subject_bounds = {glm::dvec3(-1), glm::dvec3(1)};
  for (size_t i = 0; i < 8 + held_out.size(); ++i) {
    View view;
    const bool train = i < 8;
    view.name = train ? fmt::format("train/r_{}", i) : held_out[i - 8];
    view.image = fmt::format("images/{}.png", i);
    view.split = train ? Split::kTrain : Split::kTest;
    const double turn = 2 * M_PI * double(i) / double(8 + held_out.size());
    const glm::dvec3 center(3 * std::cos(turn), 3 * std::sin(turn), 1 + 0.3 * std::sin(3 * turn));
    const glm::dvec3 forward = glm::normalize(-center);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    const glm::dmat3 world_from_cam(right, glm::cross(forward, right), forward);
    view.cam_from_world.rotation = glm::transpose(world_from_cam);
    view.cam_from_world.translation = -(view.cam_from_world.rotation * center);
    scene.views.push_back(view);
  }
  return scene;
}

inline void WriteFakeManifest(const std::filesystem::path& folder, const std::string& stage,
                              const std::string& input, const std::vector<std::string>& outputs,
                              const nlohmann::json& more = nlohmann::json::object()) {
  nlohmann::json records = nlohmann::json::array();
  for (const std::string& output : outputs) {
    records.push_back({{"path", output},
                       {"bytes", uint64_t(std::filesystem::file_size(folder / output))},
                       {"sha256", Sha256OfFile(folder / output)}});
  }
  const bool first = stage == "import" || stage == "sfm";
  nlohmann::json manifest = {
      {"schema", 1},
      {"stage", stage},
      {"version", 1},
      {"program_version", "0.1.0"},
      {"git", "0123abc"},
      {"key", stage},
      {"command", "tetrec-" + stage + " " + input + " -o " + folder.filename().string()},
      {"options", nlohmann::json::object()},
      {"seed", nullptr},
      {"inputs", {{{"name", "INPUT"}, {"path", input}, {"kind", first ? "folder" : "stage"}}}},
      {"previous", first ? nlohmann::json() : nlohmann::json(input)},
      {"outputs", records},
      {"device", nullptr},
      {"counts", nlohmann::json::object()},
      {"notes", nlohmann::json::object()},
      {"warnings", nlohmann::json::array()},
      {"seconds", {{"total", 12.5}}},
      {"peak_rss_bytes", uint64_t{200} << 20},
      {"finished", "2024-01-01T00:00:00Z"}};
  manifest.update(more);
  WriteJson(folder / "manifest.json", manifest);
}

// 120 s of a made-up optimisation, held-out PSNR every tenth row.
inline std::string FakeMetricsCsv() {
  std::string csv = "iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase\n";
  for (int i = 1; i <= 60; ++i) {
    const double psnr = 30 - 18 * std::exp(-i / 12.0) + 0.3 * std::sin(5.0 * i);
    csv += fmt::format("{},{},{},{:.6f},{:.3f},{},{},{},optimize\n", 20 * i, 2 * i, 40960 * i,
                       std::pow(10, -psnr / 10), psnr,
                       i % 10 == 0 ? fmt::format("{:.3f}", psnr - 0.8) : "", 5000 + 4000 * (i / 15),
                       1000 + 700 * (i / 15));
  }
  return csv;
}

// Writes RUN/1_scene ... RUN/5_surface. The surface is a unit sphere.
inline void WriteFakeRun(const std::filesystem::path& run, const FakeRun& options,
                         const std::vector<Image>& truths = {}) {
  namespace fs = std::filesystem;
  for (const char* folder : {"1_scene", "2_tetrahedra", "3_field", "4_views/renders", "4_views/gt",
                             "4_views/masks", "5_surface"}) {
    fs::create_directories(run / folder);
  }
  const Scene scene = TestScene(options.view_names);
  fs::create_directories(run / "1_scene" / "images");
  for (const View& view : scene.views)
    WriteImage(run / "1_scene" / view.image, TestPicture(64, 48, 0));
  WriteScene(run / "1_scene", scene);
  WriteFakeManifest(run / "1_scene", "import", options.dataset, {"scene.json"},
                    {{"counts", {{"views", 11}}}, {"warnings", options.warnings}});
  WriteText(run / "2_tetrahedra" / "mesh.tet", "mesh");
  WriteFakeManifest(run / "2_tetrahedra", "tetrahedralize", "../1_scene", {"mesh.tet"});
  WriteText(run / "3_field" / "metrics.csv", FakeMetricsCsv());
  WriteText(run / "3_field" / "field.tetf", std::string(1000, 'x'));
  WriteFakeManifest(run / "3_field", "optimize", "../2_tetrahedra", {"metrics.csv", "field.tetf"},
                    {{"counts", {{"tets", 21000}, {"vertices", 3800}}},
                     {"device", {{"name", "llvmpipe"}, {"driver", "Mesa 22.3.6"}}},
                     {"seed", 7},
                     {"seconds", {{"total", 120.0}}},
                     {"peak_rss_bytes", uint64_t{900} << 20}});

  RenderedViews rendered{"white", "test", 4, 64, 48, {}};
  std::vector<std::string> outputs = {kRenderedViewsFile};
  for (size_t i = 0; i < options.view_names.size(); ++i) {
    const Image truth = truths.empty() ? TestPicture(64, 48, int(i)) : truths[i % truths.size()];
    rendered.width = truth.width, rendered.height = truth.height;
    const std::string render = fmt::format("renders/{}.png", i), gt = fmt::format("gt/{}.png", i),
                      mask = fmt::format("masks/{}.png", i);
    Image picture = Disturbed(truth, options.noise * (1 + 0.5 * double(i % 5)));
    for (uint8_t& value : picture.pixels) value = uint8_t(options.gain * value);
    WriteImage(run / "4_views" / render, picture);
    WriteImage(run / "4_views" / gt, truth);
    Image subject{truth.width, truth.height, 3, std::vector<uint8_t>(truth.pixels.size(), 0)};
    std::fill(subject.pixels.begin() + subject.pixels.size() / 2, subject.pixels.end(),
              uint8_t{255});
    WriteImage(run / "4_views" / mask, subject);
    const std::filesystem::path folder = run / "4_views";
    rendered.views.push_back(
        {options.view_names[i], "test", folder / render, folder / gt, {}, {}, {}, {}, {}});
    if (options.with_masks) rendered.views.back().mask = folder / mask;
    outputs.insert(outputs.end(), {render, gt});
  }
  WriteRenderedViews(run / "4_views" / kRenderedViewsFile, rendered);
  WriteFakeManifest(run / "4_views", "render", "../3_field", outputs,
                    {{"device", {{"name", "another"}, {"driver", "1"}}}});
  WriteTriangleMeshPly(run / "5_surface" / "surface.ply", TestSphere(40, 1));
  WriteFakeManifest(run / "5_surface", "surface", "../3_field", {"surface.ply"});
  if (!options.with_field_folder) fs::remove_all(run / "3_field");
}

}  // namespace tetrec
