#include "eval/report.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/stage_input.h"
#include "eval/chart.h"
#include "eval/fake_run.h"
#include "eval/html.h"
#include "eval/mesh_preview.h"
#include "eval/plot.h"
#include "expect_error.h"
#include "geometry/checked_geometry.h"
#include "paths.h"
#include "run/camera_corrections.h"
#include "run/photo_exposures.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

namespace tetrec {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

// Runs tetrec-evaluate with these arguments.
ChildResult RunEvaluate(const std::vector<std::string>& arguments) {
  return RunChild(test::ProgramFolder() / "tetrec-evaluate", arguments, {});
}

TEST(Html, EverythingThatCouldEndATextOrAnAttributeIsEscaped) {
  EXPECT_EQ(EscapeHtml("<script>alert('1') & \"2\"</script>"),
            "&lt;script&gt;alert(&#39;1&#39;) &amp; &quot;2&quot;&lt;/script&gt;");
  EXPECT_EQ(EscapeHtml(std::string("a\0b\x1b", 4)), "a&#xFFFD;b&#xFFFD;");
  EXPECT_EQ(EscapeHtml("Zürich 3 × 4"), "Zürich 3 × 4");
}

// The example of "Content Security Policy Level 3", section 8.3: openssl gives the same hash.
TEST(Html, ScriptSourceIsTheHashThatBrowsersCompute) {
  EXPECT_EQ(ScriptSource("alert('Hello, world.');"),
            "'sha256-qznLcsROx4GACP2dm0UCKCzCG+HiZ1guq6ZZDob/Tng='");
}

TEST(Report, EveryViewHasASliderBetweenPhotoAndRendering) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
  const std::string html = ReadText(folder / "6_report/report.html");
  for (const char* view : {"test/r_0", "test/r_1", "test/r_2"}) {
    const std::string label = fmt::format(
        "aria-label=\"line between ground truth, on the left, and render of view {}\"", view);
    const size_t slider = html.find(label);
    ASSERT_NE(slider, std::string::npos) << view;
    EXPECT_EQ(html.find(label, slider + 1), std::string::npos) << view;
    EXPECT_EQ(html.rfind("<input class=\"slider\" type=\"range\"", slider),
              html.rfind('<', slider));
  }
}

TEST(Report, LowQualityIsWarnedOf) {
  const ScratchFolder folder;
  const auto warnings = [&](const char* name, double noise) {
    WriteFakeRun(folder / name, {.noise = noise});
    EXPECT_EQ(RunEvaluate({folder / name / "4_views", "-o", folder / name / "6_report"}).exit_code,
              0);
    return ReadText(folder / name / "6_report/report.html");
  };
  EXPECT_THAT(warnings("good", 6), Not(HasSubstr("have a mean PSNR of only")));
  EXPECT_THAT(warnings("bad", 40), HasSubstr("have a mean PSNR of only"));
}

TEST(Report, ViewsOfNearlyOneColourAreWarnedOfByName) {
  const ScratchFolder folder;
  const auto report = [&](const char* name, uint8_t rest) {
    const std::filesystem::path run = folder / name, views = run / "4_views";
    WriteFakeRun(run, {});
    // One rendering keeps only a share of its contrast.
    Image image = ReadImage(views / "renders/1.png");
    for (uint8_t& value : image.pixels) value = uint8_t(100 + value * rest / 100);
    WriteImage(views / "renders/1.png", image);
    WriteFakeManifest(views, "render", "../3_field",
                      {"views.json", "renders/0.png", "gt/0.png", "renders/1.png", "gt/1.png",
                       "renders/2.png", "gt/2.png"});
    EXPECT_EQ(RunEvaluate({views, "-o", run / "6_report"}).exit_code, 0);
    return ReadText(run / "6_report/report.html");
  };
  EXPECT_THAT(report("flat", 15),
              HasSubstr("1 of 3 views are rendered in nearly one colour: test/r_1. "));
  EXPECT_THAT(report("dull", 50), Not(HasSubstr("nearly one colour")));
}

TEST(Html, Base64IsThatOfRfc4648) {
  // The RFC's own examples.
  const std::string head = "data:image/svg+xml;base64,";
  EXPECT_EQ(SvgDataUri(""), head);
  EXPECT_EQ(SvgDataUri("f"), head + "Zg==");
  EXPECT_EQ(SvgDataUri("fo"), head + "Zm8=");
  EXPECT_EQ(SvgDataUri("foo"), head + "Zm9v");
  EXPECT_EQ(SvgDataUri("foobar"), head + "Zm9vYmFy");
}

TEST(Report, AWholeRunBecomesOneSafePage) {
  const ScratchFolder folder;
  FakeRun fake;
  fake.view_names = {"test/<script>alert(1)</script>", "\" onerror=\"alert(2)", "test/r_2"};
  fake.dataset = "../../data/<b>bold";
  fake.warnings = {"<img src=http://example.com/x.png>"};
  WriteFakeRun(folder.path(), fake);
  const ChildResult result =
      RunEvaluate({folder / "4_views", folder / "5_surface", "-o", folder / "6_report"});
  ASSERT_EQ(result.exit_code, 0) << ::testing::PrintToString(result.last_lines);

  const std::string html = ReadText(folder / "6_report/report.html");
  EXPECT_LT(html.size(), size_t{15'000'000});
  EXPECT_THAT(html, HasSubstr("Content-Security-Policy"));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(1)&lt;/script&gt;"));
  // The only script is the page's own, and the policy allows no other.
  EXPECT_EQ(html.find("<script"), html.rfind("<script>"));
  const size_t begin = html.find("<script>") + 8;
  const std::string script = html.substr(begin, html.find("</script>") - begin);
  EXPECT_THAT(html, HasSubstr("; script-src " + ScriptSource(script) + "\">"));
  EXPECT_THAT(html, Not(HasSubstr("<script>alert")));
  for (const char* poison : {"<b>bold", "<img src=http", "onerror=\"", "src=\"http", "url("}) {
    EXPECT_THAT(html, Not(HasSubstr(poison)));
  }
  // Every image is inlined and has a text for those who cannot see it.
  for (size_t at = html.find("<img"); at != std::string::npos; at = html.find("<img", at + 1)) {
    const std::string tag = html.substr(at, html.find('>', at) - at);
    EXPECT_EQ(tag.rfind("<img src=\"data:image/", 0), 0u) << tag.substr(0, 80);
    EXPECT_THAT(tag, HasSubstr(" alt=\""));
  }
}

TEST(Report, NamesTheSizesOfViewsOfSeveral) {
  const auto html_of = [](const std::vector<Image>& truths) {
    const ScratchFolder folder;
    WriteFakeRun(folder.path(), {}, truths);
    EXPECT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
    return ReadText(folder / "6_report/report.html");
  };
  const Image portrait = TestPicture(48, 64, 1), landscape = TestPicture(64, 48, 2);
  EXPECT_THAT(html_of({portrait}), HasSubstr("<li>Resolution <b>48×64 px</b>"));
  EXPECT_THAT(html_of({portrait, landscape, landscape}), HasSubstr("<b>64×48 and 48×64 px</b>"));
  EXPECT_THAT(html_of({portrait, landscape, TestPicture(64, 64, 3)}),
              HasSubstr(" px and 2 other sizes</b>"));
}

TEST(Report, MetricsJsonHasTheNumbersOfTheRunAndItsProtocol) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
  const nlohmann::json m = ReadJson(folder / "6_report/metrics.json");
  EXPECT_EQ(m["schema"], 1);
  EXPECT_EQ(m["resolution"], (nlohmann::json{64, 48}));
  EXPECT_EQ(m["background"], "white");
  EXPECT_EQ(m["rays_per_pixel"], 4);
  EXPECT_EQ(m["split"], "test");
  EXPECT_EQ(m["tets"], 21000);
  EXPECT_EQ(m["vertices"], 3800);
  EXPECT_EQ(m["field_bytes"], 1000);
  EXPECT_EQ(m["seconds"]["optimize"], 120.0);
  EXPECT_EQ(m["seconds"]["import"], 12.5);
  EXPECT_TRUE(m["seconds"]["sfm"].is_null());
  EXPECT_EQ(m["peak_rss_bytes"], 900 << 20);
  EXPECT_EQ(m["device"], "llvmpipe, Mesa 22.3.6");
  EXPECT_TRUE(m["lpips"].is_null());
  EXPECT_TRUE(m["surface"].is_null());
  ASSERT_EQ(m["views"].size(), 3u);
  double psnr = 0, mse = 0;
  for (const nlohmann::json& view : m["views"]) {
    psnr += view["psnr"].get<double>() / 3;
    mse += view["mse"].get<double>() / 3;
    EXPECT_TRUE(view["foreground_psnr"].is_number());
  }
  EXPECT_NEAR(m["psnr"].get<double>(), psnr, 1e-12);
  EXPECT_NEAR(m["psnr_of_mean_mse"].get<double>(), -10 * std::log10(mse), 1e-12);
  // The logarithm is convex: the mean of PSNRs is never below the PSNR of the mean.
  EXPECT_GT(psnr, m["psnr_of_mean_mse"].get<double>());
}

TEST(Report, CorrectedColoursAreJudgedApartFromTheRawOnes) {
  const ScratchFolder folder;
  const auto evaluate = [&](const char* name, double gain) {
    WriteFakeRun(folder / name, {.gain = gain});
    EXPECT_EQ(RunEvaluate({folder / name / "4_views", "-o", folder / name / "6_report"}).exit_code,
              0);
    return ReadJson(folder / name / "6_report/metrics.json");
  };
  const nlohmann::json even = evaluate("even", 1.0), dark = evaluate("dark", 0.8);
  EXPECT_LT(dark["psnr"].get<double>(), even["psnr"].get<double>() - 3);
  EXPECT_LT(dark["psnr_right_half"].get<double>(), even["psnr_right_half"].get<double>() - 3);
  // Colours of 8 bits were cut to four fifths of them.
  EXPECT_NEAR(dark["psnr_color_corrected"].get<double>(),
              even["psnr_color_corrected"].get<double>(), 0.5);
  EXPECT_TRUE(dark["views"][2]["psnr_color_corrected"].is_number());
  EXPECT_THAT(dark["psnr_color_corrected_protocol"].get<std::string>(), HasSubstr("left half"));
  EXPECT_TRUE(dark["uneven_photos"].is_null());
  const std::string html = ReadText(folder / "dark/6_report/report.html");
  EXPECT_THAT(html, HasSubstr("Right half, corrected"));
  EXPECT_THAT(html, Not(HasSubstr("Exposure of the training photos")));
}

TEST(Report, ExposuresOfTheTrainingPhotosAreListedTheFarthestFirst) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  const auto report = [&](const std::vector<PhotoExposure>& exposures, const char* out) {
    WritePhotoExposures(folder / "3_field" / kPhotoExposuresFile, exposures);
    EXPECT_EQ(RunEvaluate({folder / "4_views", "-o", folder / out}).exit_code, 0);
    return ReadText(folder / out / "report.html");
  };
  const glm::dvec3 one(1.0), zero(0.0);
  const std::string uneven =
      report({{"near", one * 0.99, zero}, {"<far>", one * 1.3, zero}}, "uneven");
  EXPECT_THAT(uneven, HasSubstr("&lt;far&gt;</td><td class=\"n\">1.300"));
  EXPECT_LT(uneven.find("&lt;far&gt;"), uneven.find("<td>near"));
  EXPECT_EQ(ReadJson(folder / "uneven/metrics.json")["uneven_photos"], 1);
  const std::string even = report({{"a", one, zero}, {"b", one, zero}}, "even");
  EXPECT_THAT(even, HasSubstr("Even: no photo differs"));
}

TEST(Report, CorrectedCamerasAreListedTheFarthestFirst) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  WriteCameraCorrections(folder / "3_field" / kCameraCorrectionsFile,
                         {{"near", {}, 0.01, 0.001, 0.2}, {"<far>", {}, 0.5, 0.02, 3.25}});
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
  const std::string html = ReadText(folder / "6_report/report.html");
  EXPECT_THAT(html, HasSubstr("Corrected cameras"));
  EXPECT_THAT(html, HasSubstr("&lt;far&gt;</td><td class=\"n\">3.25 px"));
  EXPECT_LT(html.find("&lt;far&gt;"), html.find("<td>near"));
  EXPECT_EQ(ReadJson(folder / "6_report/metrics.json")["moved_cameras"], 1);
}

TEST(Report, RefinedCamerasAreJudgedApartFromTheRawOnes) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "raw"}).exit_code, 0);
  const nlohmann::json raw = ReadJson(folder / "raw/metrics.json");
  EXPECT_TRUE(raw["psnr_refined_cameras"].is_null());
  EXPECT_THAT(ReadText(folder / "raw/report.html"), Not(HasSubstr("refined cameras")));

  // The refined picture of each view is the raw one of the first, which is the best.
  RenderedViews rendered = ReadRenderedViews(folder / "4_views" / kRenderedViewsFile);
  for (RenderedView& view : rendered.views) {
    view.refined = rendered.views[0].render;
    view.truth = rendered.views[0].truth;
    view.refined_shift_px = 0.5;
  }
  WriteRenderedViews(folder / "4_views" / kRenderedViewsFile, rendered);
  WriteFakeManifest(folder / "4_views", "render", "../3_field", {kRenderedViewsFile});
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "refined"}).exit_code, 0);
  const nlohmann::json refined = ReadJson(folder / "refined/metrics.json");
  EXPECT_EQ(refined["psnr_refined_cameras"], raw["views"][0]["psnr"]);
  EXPECT_EQ(refined["views"][0]["psnr"], raw["views"][0]["psnr"]);
  EXPECT_TRUE(refined["psnr_refined_cameras_color_corrected"].is_number());
  EXPECT_THAT(ReadText(folder / "refined/report.html"), HasSubstr("PSNR with refined cameras"));
}

TEST(Report, ATrueSurfaceIsScoredThroughTheCameras) {
  const ScratchFolder folder;
  const FakeRun fake;
  WriteFakeRun(folder.path(), fake);
  // The truth: the run's unit sphere and cameras, in a frame twice as large and moved.
  const glm::dvec3 shift(10, -4, 2);
  WriteTriangleMeshPly(folder / "truth.ply", TestSphere(50, 2, shift));
  nlohmann::json frames = nlohmann::json::array();
  for (const View& view : TestScene(fake.view_names).views) {
    const glm::dmat3& r = view.cam_from_world.rotation;
    const glm::dvec3 t = -(r * (2.0 * view.cam_from_world.Inverse().translation + shift));
    nlohmann::json rows;
    for (int i = 0; i < 3; ++i)
      rows.push_back(nlohmann::json::array({r[0][i], r[1][i], r[2][i], t[i]}));
    frames.push_back({{"file", "photos/" + view.name + ".jpg"}, {"cam_from_world", rows}});
  }
  WriteJson(folder / "cameras.json", {{"frames", frames}});
  const ChildResult result = RunEvaluate(
      {folder / "4_views", folder / "5_surface", "-o", folder / "6_report", "--ground-truth",
       folder / "truth.ply", "--cameras", folder / "cameras.json", "--surface-samples", "5000"});
  ASSERT_EQ(result.exit_code, 0) << ::testing::PrintToString(result.last_lines);
  const nlohmann::json surface = ReadJson(folder / "6_report/metrics.json")["surface"];
  EXPECT_EQ(surface["ground_truth"]["f_score"], 1.0);
  // Two polyhedra of one sphere: each is up to 2 (1 - cos(pi / 40)) = 0.006 below it.
  EXPECT_LT(surface["ground_truth"]["accuracy"].get<double>(), 0.006);
  EXPECT_NEAR(surface["alignment"]["scale"].get<double>(), 2, 1e-9);
  EXPECT_LT(surface["alignment"]["center_rms"].get<double>(), 1e-9);
  EXPECT_EQ(surface["watertight"], true);
}

TEST(Report, ASurfaceIsJudgedInItsOwnFrame) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  // The surface lies on its side, three times as large; its manifest has the way back.
  const Similarity3 surface_from_input{3, glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0}), {5, 6, 7}};
  const TriangleMesh truth = Transformed(TestSphere(40, 1), {1, glm::dmat3(1.0), {0, 0, 0.5}});
  WriteTriangleMeshPly(folder / "truth.ply", truth);
  WriteTriangleMeshPly(folder / "5_surface/surface.ply", Transformed(truth, surface_from_input));
  const auto evaluate = [&](const nlohmann::json& notes) {
    WriteFakeManifest(folder / "5_surface", "surface", "../3_field", {"surface.ply"},
                      {{"notes", notes}});
    const ChildResult result = RunEvaluate(
        {folder / "4_views", folder / "5_surface", "-o", folder / "6_report", "--ground-truth",
         folder / "truth.ply", "--surface-samples", "5000", "--force"});
    EXPECT_EQ(result.exit_code, 0) << ::testing::PrintToString(result.last_lines);
    return ReadJson(folder / "6_report/metrics.json");
  };
  const auto f_score = [](const nlohmann::json& metrics) {
    return metrics["surface"]["ground_truth"]["f_score"];
  };
  const char* warning = "no part of the surface is inside the scored box, from -1.05,";
  const nlohmann::json input_from_surface = ToJson(surface_from_input.Inverse());
  const nlohmann::json right = evaluate({{"input_from_surface", input_from_surface}});
  EXPECT_EQ(f_score(right), 1.0);
  EXPECT_THAT(right["warnings"].dump(), Not(HasSubstr(warning)));
  const nlohmann::json wrong = evaluate(nlohmann::json::object());
  EXPECT_EQ(f_score(wrong), 0.0);
  EXPECT_THAT(wrong["warnings"].dump(), HasSubstr(warning));
}

TEST(Report, ASurfaceOfAnotherFieldThanTheViewsIsAWarning) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  const auto made_from = [&](const char* stage_folder, const std::string& hash) {
    nlohmann::json manifest = ReadJson(folder / stage_folder / "manifest.json");
    manifest["inputs"][0].update({{"stage", "optimize"}, {"sha256", hash}});
    WriteJson(folder / stage_folder / "manifest.json", manifest);
  };
  const std::string field = HashOfResult(ReadJson(folder / "3_field" / "manifest.json"));
  made_from("4_views", field);
  for (const std::string& other : {std::string("of another"), field}) {
    made_from("5_surface", other);
    const ChildResult result = RunEvaluate(
        {folder / "4_views", folder / "5_surface", "-o", folder / "6_report", "--force"});
    ASSERT_EQ(result.exit_code, 0) << ::testing::PrintToString(result.last_lines);
    EXPECT_EQ(ReadJson(folder / "6_report/metrics.json")["warnings"].dump().find(
                  "made from another field than the views") == std::string::npos,
              other == field);
  }
}

TEST(Report, ViewsEqualToTheTruthAreNullAndCountedInJson) {
  const ScratchFolder folder;
  FakeRun fake;
  fake.noise = 0;
  WriteFakeRun(folder.path(), fake);
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
  const nlohmann::json m = ReadJson(folder / "6_report/metrics.json");
  EXPECT_TRUE(m["psnr"].is_null());
  EXPECT_TRUE(m["views"][0]["psnr"].is_null());
  EXPECT_EQ(m["identical_views"], 3);
  EXPECT_NEAR(m["ssim"].get<double>(), 1, 1e-12);
  EXPECT_THAT(ReadText(folder / "6_report/report.html"), HasSubstr("identical"));
}

TEST(Report, ARunWithoutItsFieldIsStillScoredWithAWarning) {
  const ScratchFolder folder;
  FakeRun fake;
  fake.with_field_folder = false;
  WriteFakeRun(folder.path(), fake);
  ASSERT_EQ(RunEvaluate({folder / "4_views", "-o", folder / "6_report"}).exit_code, 0);
  const nlohmann::json m = ReadJson(folder / "6_report/metrics.json");
  EXPECT_TRUE(m["psnr"].is_number());
  EXPECT_TRUE(m["tets"].is_null());
  EXPECT_GE(m["warnings"].size(), 1u);
}

TEST(Report, BadViewsFilesAndOptionsEndInTheRightExitCode) {
  const ScratchFolder folder;
  WriteFakeRun(folder.path(), {});
  const std::string views = folder / "4_views", surface = folder / "5_surface",
                    out = folder / "6_report";
  EXPECT_EQ(RunEvaluate({views}).exit_code, 2);
  EXPECT_EQ(RunEvaluate({views, "-o", out, "--ground-truth", "truth.ply"}).exit_code,
            2);  // no surface
  EXPECT_EQ(RunEvaluate({views, surface, "-o", out, "--threshold", "0"}).exit_code, 2);
  EXPECT_EQ(RunEvaluate({surface, "-o", out}).exit_code, 3);  // the wrong folder
  EXPECT_EQ(RunEvaluate({folder / "none", "-o", out}).exit_code, 3);

  nlohmann::json bad = ReadJson(folder / "4_views/views.json");
  bad["views"][0]["render"] = "../secret.png";
  WriteJson(folder / "4_views/views.json", bad);
  // Somebody who prepares a folder writes hashes that fit.
  WriteFakeManifest(folder / "4_views", "render", "../3_field", {kRenderedViewsFile});
  const ChildResult result = RunEvaluate({views, "-o", out});
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(result.last_lines.back(), HasSubstr("views[0].render is \"../secret.png\""));
}

TEST(MeshPreview, ASphereIsADiscInEveryViewAndBackSidesAreBlue) {
  PreviewOptions options;
  options.size_px = 64;
  options.views = 4;
  options.bounds = {glm::dvec3(-1.01), glm::dvec3(1.01)};
  options.use_colors = false;
  TriangleMesh sphere = TestSphere(40, 1);
  const auto count = [&](const Image& image, auto test) {
    int pixels = 0;
    for (int y = 0; y < 64; ++y) {
      for (int x = 0; x < 64; ++x) pixels += test(image.At(x, y));
    }
    return pixels;
  };
  const auto warm = [](const uint8_t* p) { return p[0] > p[2] && p[0] < 230; };
  const auto blue = [](const uint8_t* p) { return p[2] > p[0] + 10; };
  // The sphere fills 96 % of the width: a disc of radius 0.96 * 32.
  const double disc = M_PI * std::pow(0.96 * 32, 2);
  for (const Image& image : RenderTurntable(sphere, options)) {
    EXPECT_NEAR(count(image, warm), disc,
                0.03 * disc);  // rim pixels: circumference / area = 2 / 31
    EXPECT_EQ(count(image, blue), 0);
  }
  for (glm::uvec3& triangle : sphere.triangles) std::swap(triangle.x, triangle.y);
  for (const Image& image : RenderTurntable(sphere, options)) {
    EXPECT_NEAR(count(image, blue), disc, 0.06 * disc);
  }
}

TEST(MeshPreview, UpIsUpAndTheTurnGoesAround) {
  // A stick along the up axis with a red top.
  TriangleMesh stick = TestSphere(20, 1);
  for (size_t i = 0; i < stick.positions.size(); ++i) {
    const bool top = stick.positions[i].y > 0;
    stick.colors_srgb[i] = {uint8_t(top ? 250 : 0), 0, uint8_t(top ? 0 : 250)};
  }
  PreviewOptions options;
  options.size_px = 40;
  options.up = {0, 1, 0};
  options.bounds = {glm::dvec3(-1.01), glm::dvec3(1.01)};
  for (const Image& image : RenderTurntable(stick, options)) {
    EXPECT_GT(image.At(20, 6)[0], image.At(20, 6)[2]);
    EXPECT_LT(image.At(20, 34)[0], image.At(20, 34)[2]);
  }
}

TEST(Chart, TwoRunsAreDrawnAndTabulated) {
  if (FindProgram("gnuplot").empty()) GTEST_SKIP() << "no gnuplot in PATH";
  const ScratchFolder folder;
  WriteFakeRun(folder / "it's <a> run", {});
  WriteFakeRun(folder / "b", {});
  const std::vector<RunCurve> curves = {ReadRunCurve(folder / "it's <a> run"),
                                        ReadRunCurve(folder / "b/3_field")};
  EXPECT_EQ(curves[0].name, "it's <a> run");
  EXPECT_EQ(curves[1].name, "b");
  EXPECT_EQ(curves[0].rows.size(), 6u);  // those with a held-out PSNR
  WriteChart(curves, {}, folder / "chart");
  const std::string svg = ReadText(folder / "chart/chart.svg");
  EXPECT_THAT(svg, HasSubstr("it's &lt;a"));
  EXPECT_THAT(svg, HasSubstr("64×48 px, background white"));
  EXPECT_EQ(ReadImage(folder / "chart/chart.png").width, 900);
  const nlohmann::json record = ReadJson(folder / "chart/chart.json");
  EXPECT_EQ(record["runs"].size(), 2u);
  EXPECT_EQ(record["runs"][1]["seconds_and_heldout_psnr"].size(), 6u);
  const std::string csv = ReadText(folder / "chart/chart.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 13);
  EXPECT_FALSE(std::filesystem::exists(folder / "chart/.gnuplot"));
}

TEST(Chart, WithoutGnuplotItNamesThePackage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nowhere", 1);
  const ScratchFolder folder;
  Plot plot;
  plot.series = {{"a", {1, 2}, {1, 2}, 0, false, true}};
  ExpectError<EnvironmentError>([&] { DrawPlot(plot, folder / "a.svg", folder / "s"); },
                                {"gnuplot-nox", "apt-get install"});
  setenv("PATH", path.c_str(), 1);
}

TEST(Plot, ALongTitleIsBrokenIntoLinesAndKeptWhole) {
  const ScratchFolder folder;
  Plot plot;
  for (int i = 0; i < 60; ++i) plot.title += fmt::format("it's{} ", i);
  plot.series = {{"a", {1, 2}, {1, 2}, 0, false, true}};
  DrawPlot(plot, folder / "a.svg", folder / "s");
  const std::string svg = ReadText(folder / "a.svg");
  size_t previous = 0;
  int lines = 1;
  for (int i = 0; i < 60; ++i) {
    const size_t place = svg.find(fmt::format("s{}", i), previous);
    ASSERT_NE(place, std::string::npos) << i;
    if (i > 0) lines += svg.substr(previous, place - previous).find('<') != std::string::npos;
    previous = place;
  }
  EXPECT_GE(lines, 4);  // 400 letters, about 106 per line
  EXPECT_LE(lines, 5);
}

TEST(Chart, ARunWithoutMeasurementsIsRefused) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { ReadRunCurve(folder.path()); }, {"metrics.csv"});
  folder.Write("3_field/metrics.csv",
               "iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase\n1,1,1,1,1,"
               ",1,1,p\n");
  ExpectError<DataError>([&] { ReadRunCurve(folder.path()); }, {"no row has a held-out PSNR"});
}

}  // namespace
}  // namespace tetrec
