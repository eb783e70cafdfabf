// COLMAP's steps as child processes, each judged by what it left behind: its exit code lies.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct ColmapProgram {
  std::filesystem::path path;
  std::string version;        // "3.8"; "unknown" where `colmap help` does not tell
  std::filesystem::path log;  // receives its output
};

// Throws EnvironmentError where there is no colmap in PATH; warns where it is not the tested
// version (colmap_version.h). Failures of the steps below that another version may be the cause of
// name both.
ColmapProgram FindColmap(const std::filesystem::path& log);

struct ExtractOptions {
  std::string camera_model;       // COLMAP's name
  bool camera_per_image = false;  // else one a folder
  int max_features = 3072;        // a picture
};

// Features of `names` (relative to `photos`) into a new database with ids in the order of the
// names. One COLMAP with one thread works on each core, on its own part of the names and its own
// database in `parts`, which is gone on from after a kill: COLMAP's threads together give other
// descriptors each time. Throws DataError naming a picture that was left out, EnvironmentError for
// a full disk.
void ExtractFeatures(const ColmapProgram& colmap, const std::filesystem::path& photos,
                     const std::vector<std::string>& names, const ExtractOptions& options,
                     const std::filesystem::path& parts, const std::filesystem::path& database);

// Which pairs of pictures are matched. kAuto: all for few pictures; else the pairs whose coarsest
// features match best (Wu, "Towards linear-time incremental structure from motion", 2013) and
// neighbours in the order of names.
enum class PairChoice { kAuto, kExhaustive, kSequential };

struct MatchCounts {
  size_t pairs = 0, matches = 0;  // matches before geometric verification
};

// Matches and verifies in small blocks, the one while the other; what the database holds already is
// not done again.
MatchCounts MatchFeatures(const ColmapProgram& colmap, const std::filesystem::path& database,
                          PairChoice choice, const std::filesystem::path& scratch);

// Runs the mapper into the empty folder `models` and returns the folders of its models (0, 1, ...);
// none where the pictures do not hang together.
std::vector<std::filesystem::path> MapScene(const ColmapProgram& colmap,
                                            const std::filesystem::path& photos,
                                            const std::filesystem::path& database,
                                            size_t photo_count, int seed,
                                            const std::filesystem::path& models);

// Triangulates the database's matches with the cameras and poses of the model in `known`, which
// stay as they are, into the empty folder `found`. False, and nothing there, where there are no
// points.
bool TriangulateModel(const ColmapProgram& colmap, const std::filesystem::path& photos,
                      const std::filesystem::path& database, const std::filesystem::path& known,
                      const std::filesystem::path& found);

}  // namespace tetrec
