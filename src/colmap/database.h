// The parts of COLMAP's SQLite database that Tetrec reads and writes (format: COLMAP documentation,
// "Database Format").
#pragma once

#include "colmap/matching.h"
#include "geometry/lens.h"

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

struct sqlite3;

namespace tetrec {

struct DatabaseImage {
  uint32_t id = 0;
  std::string name;
  uint64_t features = 0;
};

inline constexpr size_t kMaxImages = 2147483647;  // of a database
using ImagePair = std::pair<uint32_t, uint32_t>;  // image ids, the lower first

// A database and the version of COLMAP that wrote it, for messages.
struct DatabaseFile {
  std::filesystem::path path;
  std::string colmap;
};

// Every call may throw EnvironmentError (disk full, not writable, the tables of another version of
// COLMAP) or DataError (not a database that COLMAP writes).
class ColmapDatabase {
 public:
  // Opens an existing database.
  explicit ColmapDatabase(const std::filesystem::path& path,
                          const std::string& colmap_version = "unknown");

  std::vector<DatabaseImage> Images() const;  // by id
  Descriptors ReadDescriptors(uint32_t image_id) const;
  // The descriptors of the `count` features with the largest scales.
  Descriptors ReadCoarsestDescriptors(uint32_t image_id, size_t count) const;
  std::set<ImagePair> MatchedPairs() const;           // with raw matches
  std::set<ImagePair> VerifiedPairs() const;          // with two-view geometries
  std::set<ImagePair> PairsWithInliers() const;       // whose geometry has any
  uint64_t MatchCount() const;                        // raw matches of all pairs
  std::map<ImagePair, uint64_t> MatchCounts() const;  // raw matches of each matched pair

  // Adds the images, cameras and features of another database under new ids. Only columns that both
  // have are copied, because versions after the tested one dropped some.
  void Append(const std::filesystem::path& other);

  // Gives images and cameras ids in the order of the images' file names, whatever their folders:
  // the mapper's result depends on the ids, and images with successive ids count as neighbours.
  // With `camera_per_folder` the images of one folder share the camera of the first by name.
  // Requires that nothing is matched yet.
  void NumberByFileName(bool camera_per_folder);

  // Keeps the `count` features with the largest scales of every image, in their order, because
  // COLMAP's own limit is loose. Requires that nothing is matched yet.
  void KeepCoarsest(size_t count);

  // Adds to the images that `richer` has by the same names those of its features that they lack,
  // behind their own, so that matches stay valid. Returns the number of features added.
  uint64_t AppendFiner(const ColmapDatabase& richer);

  // Gives every camera of fewer than `images` images a lens of another model with its focal length
  // and centre, and without distortion: what COLMAP starts from if features are extracted with that
  // model. Matches stay. `model` is one of PINHOLE, RADIAL and OPENCV, or simpler.
  void UseLens(LensModel model, size_t images = kMaxImages);

  // Removes matches and geometries of pairs, so that they are matched again.
  void ForgetPairs(const std::vector<ImagePair>& pairs);

  // Writes raw matches of several pairs in one transaction; `second` contains the matches from the
  // lower to the higher id.
  void WriteMatches(const std::vector<std::pair<ImagePair, std::vector<FeatureMatch>>>& pairs);

 private:
  void Execute(const std::string& sql);
  std::vector<std::string> Columns(const char* schema, const char* table) const;
  std::string CopySql(const char* table, const std::vector<std::string>& needed,
                      const std::filesystem::path& other) const;
  void RefuseFrames(const char* schema, const std::filesystem::path& path) const;
  std::vector<float> ReadScales(uint32_t image_id) const;
  std::vector<size_t> CoarsestRows(uint32_t image_id, size_t count) const;
  // The rows of a table of features ("keypoints", "descriptors") of an image; nothing if it has
  // none.
  struct FeatureRows {
    size_t row_bytes = 0;
    std::vector<uint8_t> bytes;
    size_t count() const { return row_bytes == 0 ? 0 : bytes.size() / row_bytes; }
  };
  FeatureRows ReadRows(const char* table, uint32_t image_id) const;
  void WriteRows(const char* table, uint32_t image_id, const FeatureRows& rows);
  void KeepRows(const char* table, uint32_t image_id, std::span<const size_t> rows);
  std::set<ImagePair> PairsOf(const char* table) const;

  DatabaseFile file_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> database_;
};

}  // namespace tetrec
