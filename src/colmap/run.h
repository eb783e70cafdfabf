// COLMAP's steps as child processes. Each is judged by the files that it leaves, because its exit
// code is 0 after many failures.
#pragma once

#include "colmap/pairs.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct ColmapProgram {
  std::filesystem::path path;
  std::string version;        // "3.8"; "unknown" if `colmap help` does not state it
  std::filesystem::path log;  // receives COLMAP's output
};

// Throws EnvironmentError if there is no colmap in PATH; warns if it is not the tested version
// (colmap/version.h). The errors of the steps below name both versions if the version may be the
// cause.
ColmapProgram FindColmap(const std::filesystem::path& log);

struct ExtractOptions {
  std::string camera_model;       // COLMAP's name
  bool camera_per_image = false;  // else one camera per folder
  int max_features = 0;           // per image
  // Folder of masks NAME.png for images NAME, of the same size, which are black where no feature
  // may be; empty: none.
  std::filesystem::path masks = {};
};

// Writes the features of `names` (relative to `photos`) into a new database, with ids in the order
// of the names of their files. One COLMAP process with one thread runs per core, on its own part of
// the names and with its own database in `parts`, since several threads in one process give
// different descriptors each time. A run that was killed continues from these databases. Throws
// DataError, which names an image that was left out, and EnvironmentError for a full disk.
void ExtractFeatures(const ColmapProgram& colmap, const std::filesystem::path& photos,
                     const std::vector<std::string>& names, const ExtractOptions& options,
                     const std::filesystem::path& parts, const std::filesystem::path& database);

struct MatchCounts {
  size_t pairs = 0, matches = 0;  // matches: before geometric verification
};

// Matches and verifies in small blocks; one block is verified while the next is matched. Pairs that
// the database already contains are skipped.
MatchCounts MatchFeatures(const ColmapProgram& colmap, const std::filesystem::path& database,
                          PairChoice choice, const std::filesystem::path& scratch);

// The same for the given pairs.
MatchCounts MatchFeatures(const ColmapProgram& colmap, const std::filesystem::path& database,
                          const std::vector<ImagePair>& pairs,
                          const std::filesystem::path& scratch);

// The least number of inliers with which the mapper starts from a pair of images, and with which it
// registers another image.
struct MapperDemands {
  int pair_inliers, image_inliers;
};
// COLMAP's own.
inline constexpr MapperDemands kUsualDemands{100, 30};
// For few images, taken far from each other: where neighbours are 25 degrees apart, hardly a point
// is seen by three of them.
inline constexpr MapperDemands kMildDemands{50, 12};

// Runs the mapper into the empty folder `models` and returns the folders of its models (0, 1, ...);
// none if the images do not overlap enough.
std::vector<std::filesystem::path> MapScene(const ColmapProgram& colmap,
                                            const std::filesystem::path& photos,
                                            const std::filesystem::path& database,
                                            size_t photo_count, int seed,
                                            const MapperDemands& demands,
                                            const std::filesystem::path& models);

// Triangulates the database's matches with the cameras and poses of the model in `known`, which do
// not change, into the empty folder `found`. Returns false and writes nothing if there are no
// points.
bool TriangulateModel(const ColmapProgram& colmap, const std::filesystem::path& photos,
                      const std::filesystem::path& database, const std::filesystem::path& known,
                      const std::filesystem::path& found);

}  // namespace tetrec
