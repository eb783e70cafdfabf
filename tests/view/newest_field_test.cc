// Which file of a run is shown.
#include "view/newest_field.h"

#include "core/error.h"
#include "core/file.h"
#include "core/manifest.h"
#include "expect_error.h"
#include "mesh/delaunay.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <chrono>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using Kind = FieldFile::Kind;
using namespace std::chrono_literals;

// `age` orders the files, whatever the file system's clock resolves.
void Touch(const fs::path& file, std::chrono::seconds age) {
  fs::create_directories(file.parent_path());
  WriteText(file, "{}");
  fs::last_write_time(file, fs::file_time_type::clock::now() - age);
}

TEST(NewestField, IsTheCheckpointOfAnUnfinishedFitThenTheFittedFieldThenTheStart) {
  const ScratchFolder run;
  Touch(run / "1_scene" / "scene.json", 9s);
  const ViewedRun found = FindRun(run.path());
  ExpectError<DataError>([&] { NewestField(found); }, {"3_field", "contains no field yet"});
  Touch(run / "2_tetrahedra" / "field.tetf", 8s);
  EXPECT_EQ(NewestField(found).kind, Kind::kStart);
  Touch(run / "3_field" / "checkpoint.bin", 7s);
  EXPECT_EQ(NewestField(found).kind, Kind::kCheckpoint);
  const FieldFile checkpoint = NewestField(found);
  Touch(run / "3_field" / "checkpoint.bin", 6s);
  EXPECT_NE(NewestField(found), checkpoint) << "a newer checkpoint is another file";
  Touch(run / "3_field" / "field.tetf", 5s);
  EXPECT_EQ(NewestField(found).kind, Kind::kFitted);
}

TEST(NewestField, OfAStageFolderIsTheOneOfItsRun) {
  const ScratchFolder run;
  Touch(run / "1_scene" / "scene.json", 9s);
  Touch(run / "2_tetrahedra" / "field.tetf", 8s);
  Touch(run / "3_field" / "field.tetf", 7s);
  WriteJson(run / "3_field" / kStatusFile, StatusOfNewRun("optimize", "key", {}, ""));
  EXPECT_EQ(NewestField(FindRun(run / "3_field")).kind, Kind::kFitted);
  EXPECT_EQ(FindRun(run / "3_field").scene, run / "1_scene");
  WriteJson(run / "2_tetrahedra" / kStatusFile, StatusOfNewRun("tetrahedralize", "key", {}, ""));
  EXPECT_EQ(NewestField(FindRun(run / "2_tetrahedra")).kind, Kind::kStart);
}

TEST(ReadFieldFile, AFittedFieldComesWithTheExposuresOfItsPhotos) {
  const ScratchFolder folder;
  std::vector<glm::vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1, (i >> 1) & 1, i >> 2);
  RadianceField field;
  field.mesh = BuildDelaunay(corners).mesh;
  field.density.assign(8, 1.0f);
  field.color_srgb.assign(8, glm::vec3(0.5f));
  WriteField(folder / "field.tetf", field);
  const FieldFile fitted{Kind::kFitted, folder / "field.tetf", {}};
  EXPECT_TRUE(ReadFieldFile(fitted, {}).exposures.empty());
  WritePhotoExposures(folder / kPhotoExposuresFile, {{"a.jpg", glm::dvec3(0.5), {}}});
  const FieldContent content = ReadFieldFile(fitted, {});
  EXPECT_EQ(content.field.density.size(), 8u);
  ASSERT_EQ(content.exposures.size(), 1u);
  EXPECT_EQ(content.exposures[0].name, "a.jpg");
  EXPECT_EQ(content.exposures[0].gain, glm::dvec3(0.5));
  // A start has seen no photo.
  EXPECT_TRUE(ReadFieldFile({Kind::kStart, fitted.path, {}}, {}).exposures.empty());
}

TEST(NewestField, NeedsAFolderOfARun) {
  const ScratchFolder empty;
  ExpectError<DataError>([&] { FindRun(empty.path()); }, {"contains no run"});
  ExpectError<UsageError>([&] { FindRun(empty / "nowhere"); }, {"nowhere", "not a folder"});
}

}  // namespace
}  // namespace tetrec
