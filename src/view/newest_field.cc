// Folders and files of a run.
#include "view/newest_field.h"

#include "core/error.h"
#include "core/manifest.h"
#include "optimize/checkpoint.h"

#include <fmt/format.h>

#include <optional>
#include <span>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

std::string StageOf(const fs::path& folder) {
  for (const char* name : {kManifestFile, kStatusFile}) {
    const nlohmann::json facts = ReadManifestOrStatus(folder / name);
    if (!facts.is_null()) return facts["stage"];
  }
  return "";
}

// An unfinished stage has no manifest, which would name the folder before it.
fs::path SceneOf(const fs::path& folder, const fs::path& run) {
  if (fs::exists(folder / kManifestFile)) return PreviousStage(folder, {"sfm", "import"});
  return run / "1_scene";
}

std::optional<FieldFile> FileIfThere(FieldFile::Kind kind, const fs::path& path) {
  std::error_code error;
  const fs::file_time_type written = fs::last_write_time(path, error);
  if (error) return std::nullopt;
  return FieldFile{kind, path, written};
}

// A checkpoint has one exposure for each training view, in the scene's order, or none.
std::vector<PhotoExposure> NamedExposures(std::span<const ViewExposure> exposures,
                                          const Scene& scene, const fs::path& file) {
  const std::vector<int> views = scene.ViewsOf(Split::kTrain);
  if (!exposures.empty() && exposures.size() != views.size()) {
    throw DataError(
        fmt::format("{}: contains the exposures of {} photos, but the scene has {} "
                    "training photos; fit the field again",
                    file.string(), exposures.size(), views.size()));
  }
  std::vector<PhotoExposure> named;
  for (size_t i = 0; i < exposures.size(); ++i) {
    named.push_back({scene.views[size_t(views[i])].name, exposures[i].gain, exposures[i].offset});
  }
  return named;
}

}  // namespace

ViewedRun FindRun(const fs::path& folder) {
  if (!fs::is_directory(folder)) {
    throw UsageError(
        fmt::format("RUN is '{}', which is not a folder; give a run folder", folder.string()));
  }
  const fs::path here = fs::absolute(folder / "").lexically_normal().parent_path();
  const std::string stage = StageOf(here);
  ViewedRun run;
  if (stage == "optimize") {
    run = {SceneOf(here, here.parent_path()), here.parent_path() / "2_tetrahedra", here};
  } else if (stage == "tetrahedralize") {
    run = {SceneOf(here, here.parent_path()), here, {}};
  } else {
    const fs::path field = here / "3_field", start = here / "2_tetrahedra";
    run = {SceneOf(fs::exists(field / kManifestFile) ? field : start, here), start, field};
  }
  if (!fs::exists(run.scene / "scene.json")) {
    throw DataError(
        fmt::format("{}: contains no run: there is no {}; give the folder that "
                    "contains 1_scene and 3_field, or that of tetrec-optimize",
                    folder.string(), (run.scene / "scene.json").string()));
  }
  return run;
}

FieldFile NewestField(const ViewedRun& run) {
  using Kind = FieldFile::Kind;
  if (!run.field.empty()) {
    const auto fitted = FileIfThere(Kind::kFitted, run.field / "field.tetf");
    const auto checkpoint = FileIfThere(Kind::kCheckpoint, run.field / kCheckpointFile);
    if (checkpoint && (!fitted || checkpoint->written > fitted->written)) return *checkpoint;
    if (fitted) return *fitted;
  }
  if (const auto start = FileIfThere(Kind::kStart, run.start / "field.tetf")) return *start;
  throw DataError(
      fmt::format("{}: contains no field yet; run tetrec-tetrahedralize or tetrec-optimize first",
                  (run.field.empty() ? run.start : run.field).string()));
}

FieldContent ReadFieldFile(const FieldFile& file, const Scene& scene) {
  if (file.kind != FieldFile::Kind::kCheckpoint) {
    FieldContent content{ReadField(file.path, Orientations::kAny), {}};
    const fs::path exposures = file.path.parent_path() / kPhotoExposuresFile;
    const bool has_exposures = file.kind == FieldFile::Kind::kFitted && fs::exists(exposures);
    if (has_exposures) content.exposures = ReadPhotoExposures(exposures);
    return content;
  }
  Checkpoint checkpoint = ReadCheckpoint(file.path);
  std::vector<PhotoExposure> exposures =
      NamedExposures(checkpoint.exposure.exposures, scene, file.path);
  return {FieldOf(std::move(checkpoint.mesh), checkpoint.state), std::move(exposures)};
}

std::string Describe(const FieldFile& file) {
  switch (file.kind) {
    case FieldFile::Kind::kCheckpoint:
      return "last checkpoint of an unfinished fit";
    case FieldFile::Kind::kFitted:
      return "fitted field";
    case FieldFile::Kind::kStart:
      break;
  }
  return "start, before any fit";
}

}  // namespace tetrec
