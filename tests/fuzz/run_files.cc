// Fuzz target: the small files of a run's folders. The first byte selects the file that the rest
// is. What is accepted must be written and read again without an error.
#include "core/manifest.h"
#include "fuzz/fuzz_target.h"
#include "run/camera_corrections.h"
#include "run/field_world.h"
#include "run/left_out_photos.h"
#include "run/mesh_growth.h"
#include "run/photo_exposures.h"
#include "run/rendered_views.h"
#include "run/training_log.h"

#include <array>

namespace {

namespace fs = std::filesystem;

template <auto kRead, auto kWrite>
void RoundTrip(const fs::path& path) {
  const auto content = kRead(path);
  fuzz::Succeeding([&] {
    const fs::path copy = path.parent_path() / "copy";
    kWrite(copy, content);
    kRead(copy);
  });
}

void Manifest(const fs::path& path) {
  const fs::path folder = path.parent_path();
  tetrec::PreviousFolder(folder, tetrec::ReadManifest(folder, {"optimize"}));
}

struct File {
  const char* name;
  void (*read)(const fs::path&);
};

// In the order of make_seeds.py. No status lies beside a manifest, nor the other way round.
constexpr std::array kFiles = {
    File{tetrec::kCameraCorrectionsFile,
         RoundTrip<tetrec::ReadCameraCorrections, tetrec::WriteCameraCorrections>},
    File{tetrec::kFieldWorldFile, RoundTrip<tetrec::ReadFieldWorld, tetrec::WriteFieldWorld>},
    File{tetrec::kMeshGrowthFile, RoundTrip<tetrec::ReadMeshGrowth, tetrec::WriteMeshGrowth>},
    File{tetrec::kPhotoExposuresFile,
         RoundTrip<tetrec::ReadPhotoExposures, tetrec::WritePhotoExposures>},
    File{tetrec::kRenderedViewsFile,
         RoundTrip<tetrec::ReadRenderedViews, tetrec::WriteRenderedViews>},
    File{tetrec::kTrainingLogFile, [](const fs::path& path) { tetrec::ReadTrainingLog(path); }},
    File{tetrec::kManifestFile, Manifest},
    File{tetrec::kStatusFile, Manifest},
    File{tetrec::kLeftOutPhotosFile,
         RoundTrip<tetrec::ReadLeftOutPhotos, tetrec::WriteLeftOutPhotos>}};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const fuzz::Folder folder;
  if (size == 0) return 0;
  const size_t number = data[0] % kFiles.size();
  const std::string name = std::to_string(number) + "/" + kFiles[number].name;
  folder.Write(name, {data + 1, size - 1});
  return fuzz::Refusing([&] { kFiles[number].read(folder.path() / name); });
}
