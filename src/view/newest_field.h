// Which field of a run to show: the newest, also while tetrec-optimize is running.
#pragma once

#include "field/radiance_field.h"
#include "run/photo_exposures.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// The folders that a viewer reads. `field` may not exist yet.
struct ViewedRun {
  std::filesystem::path scene, start, field;
};

// `folder`: a run folder, or the folder of tetrec-tetrahedralize or tetrec-optimize. The scene is
// the one that a manifest names; of an unfinished stage, the one in the same run folder. Throws
// UsageError if there is no such folder, and DataError if it is neither.
ViewedRun FindRun(const std::filesystem::path& folder);

// A file with a field, at one moment of its life.
struct FieldFile {
  enum class Kind { kStart, kCheckpoint, kFitted };
  Kind kind = Kind::kStart;
  std::filesystem::path path;
  std::filesystem::file_time_type written;
  bool operator==(const FieldFile&) const = default;
};

// The last checkpoint of an unfinished fit, else the fitted field, else the start. Throws DataError
// if there is none.
FieldFile NewestField(const ViewedRun& run);

struct FieldContent {
  RadianceField field;
  std::vector<PhotoExposure> exposures;  // of the training photos; empty if none were estimated
};

// The exposures are in the checkpoint, or in a file beside the fitted field. Throws DataError if a
// file is damaged or no longer exists, or has the exposures of another number of photos than the
// scene has.
FieldContent ReadFieldFile(const FieldFile& file, const Scene& scene);

// What the file is, in words for the page.
std::string Describe(const FieldFile& file);

}  // namespace tetrec
