#include "run/rendered_views.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

nlohmann::json ExampleViews() {
  return nlohmann::json::parse(R"({
    "schema": 1, "background": "white", "rays_per_pixel": 4, "split": "test",
    "resolution": [64, 48],
    "views": [
      {"name": "test/r_0", "split": "test", "render": "renders/test_r_0.png",
       "ground_truth": "gt/test_r_0.png", "mask": "masks/test_r_0.png",
       "depth": "depth/test_r_0.exr", "normals": "normals/test_r_0.exr",
       "refined": "refined/test_r_0.png",
       "refined_shift_px": 0.75},
      {"name": "test/r_1", "split": "test", "render": "renders/test_r_1.png",
       "ground_truth": "gt/test_r_1.png", "mask": null,
       "depth": null, "normals": null, "refined": null, "refined_shift_px": null}]})");
}

TEST(RenderedViews, WhatWasWrittenIsReadBackForBothKindsOfMasks) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / kRenderedViewsFile;
  for (const bool seen : {false, true}) {
    nlohmann::json example = ExampleViews();
    for (nlohmann::json& view : example["views"]) {
      if (!seen) continue;
      view["seen"] = view["mask"];
      view.erase("mask");
    }
    const RenderedViews rendered = ParseRenderedViews(example, path);
    ASSERT_EQ(rendered.views.size(), 2u);
    const RenderedView& first = rendered.views[0];
    EXPECT_EQ(first.render, folder / "renders/test_r_0.png");
    EXPECT_EQ(first.refined, folder / "refined/test_r_0.png");
    EXPECT_EQ(first.refined_shift_px, 0.75);
    EXPECT_EQ(rendered.views[1].refined, std::nullopt);
    EXPECT_EQ(first.truth, folder / "gt/test_r_0.png");
    EXPECT_EQ(seen ? first.seen : first.mask, folder / "masks/test_r_0.png");
    EXPECT_FALSE(seen ? first.mask : first.seen);
    EXPECT_EQ(first.depth, folder / "depth/test_r_0.exr");
    EXPECT_EQ(first.normals, folder / "normals/test_r_0.exr");
    EXPECT_FALSE(rendered.views[1].depth || rendered.views[1].normals);
    EXPECT_FALSE(rendered.views[1].mask || rendered.views[1].seen);
    WriteRenderedViews(path, rendered);
    EXPECT_EQ(ReadJson(path), example);
    EXPECT_EQ(ReadRenderedViews(path).views[1].name, "test/r_1");
  }
}

TEST(RenderedViews, WhatCouldNotBeReadIsNotWritten) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / kRenderedViewsFile;
  RenderedViews rendered = ParseRenderedViews(ExampleViews(), path);
  rendered.views[1].render = rendered.views[0].render;
  ExpectError<DataError>([&] { WriteRenderedViews(path, rendered); },
                         {"views.json: views[1].render is \"renders/test_r_0.png\""});
  rendered.views[1].render = folder.path().parent_path() / "elsewhere.png";
  ExpectError<DataError>([&] { WriteRenderedViews(path, rendered); },
                         {"views[1].render", "leaves the folder"});
  rendered.views.clear();
  ExpectError<DataError>([&] { WriteRenderedViews(path, rendered); }, {"views is empty"});
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(RenderedViews, NamesTheBadField) {
  const auto refused = [&](const std::string& pointer, const nlohmann::json& value,
                           const std::string& message) {
    nlohmann::json bad = ExampleViews();
    bad[nlohmann::json::json_pointer(pointer)] = value;
    ExpectError<DataError>([&] { ParseRenderedViews(bad, "4_views/views.json"); },
                           {"views.json: " + message});
  };
  refused("/schema", 2, "schema is 2; expected 1");
  refused("/background", 3, "background is 3; expected text");
  refused("/split", nullptr, "split is null; expected text");
  refused("/views", nlohmann::json::array(), "views is empty: there is nothing to judge");
  refused("/views/0/render", "../../secret.png",
          "views[0].render is \"../../secret.png\", which leaves the folder");
  refused("/views/0/render", "/etc/passwd", "views[0].render is \"/etc/passwd\", which leaves");
  refused("/views/0/mask", "../mask.png", "views[0].mask is \"../mask.png\", which leaves");
  refused("/views/0/seen", false, "views[0].seen is false; expected text");
  refused("/views/1/name", "test/r_0", "views[1].name is \"test/r_0\" for the second time");
  refused("/views/1/render", "renders/test_r_0.png",
          "views[1].render is \"renders/test_r_0.png\", the image of an earlier view");
  refused("/views/1/render", "renders/./test_r_0.png",
          "views[1].render is \"renders/./test_r_0.png\", the image of an earlier view");
  refused("/views/0/ground_truth", nullptr, "views[0].ground_truth is null; expected text");
  refused("/rays_per_pixel", -1, "rays_per_pixel is -1; expected 1 to");
  refused("/resolution", nlohmann::json::array({64}),
          "resolution has 1 items; expected more than 1");
}

}  // namespace
}  // namespace tetrec
