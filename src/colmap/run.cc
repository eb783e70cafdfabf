// COLMAP's steps as child processes.
#include "colmap/run.h"

#include "colmap/database.h"
#include "colmap/version.h"
#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <regex>
#include <set>
#include <thread>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPhotosLink = "photos";
constexpr const char* kMasksLink = "masks";
// COLMAP chooses the coarsest features before it applies the masks. It is asked for more, so that
// enough are left; those in excess are dropped.
constexpr int kFeaturesBeforeMasks = 4;
constexpr size_t kPairsPerBlock = 200;  // about 5 s of work
constexpr int kSiftMaxImageSize_px =
    1600;  // larger photos are reduced before features are searched

// COLMAP's messages when it fails. For the first three its exit code is 0.
struct KnownFailure {
  const char* text;
  const char* message;
  bool of_version = false;  // another version of COLMAP may be the cause
};
constexpr KnownFailure kKnownFailures[] = {
    {"database or disk is full", "the disk is full; free some space and run it again"},
    {"disk I/O error", "the disk cannot be written; check its free space and its health"},
    {"attempt to write a readonly database", "its database cannot be written"},
    {"Failed to parse options", "it does not accept our options", true},
    {"` not recognized. To list", "it does not know this command", true},
};

// For failures of unknown cause: the version found, if it is not the tested one.
std::string VersionNote(const ColmapProgram& colmap) {
  return IsTestedColmap(colmap.version) ? "" : "; " + ColmapVersions(colmap.version);
}

// Runs one step; throws if its output or exit code indicates a failure.
ChildResult RunStep(const ColmapProgram& colmap, const std::string& step,
                    std::vector<std::string> arguments,
                    const std::function<void(const std::string&)>& on_line = {},
                    const fs::path& folder = {}) {
  arguments.insert(arguments.begin(), step);
  std::string complaint, known_line;
  const KnownFailure* known = nullptr;
  ChildOptions options;
  options.log = colmap.log;
  // Debian's COLMAP is linked with Qt, which must not search for a display.
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  options.working_folder = folder;
  // COLMAP 3.8 reads uninitialised memory: at random addresses some descriptors differ from run to
  // run.
  options.fixed_addresses = true;
  options.on_line = [&](const std::string& line) {
    for (const KnownFailure& failure : kKnownFailures) {
      if (known != nullptr || line.find(failure.text) == std::string::npos) continue;
      known = &failure;
      known_line = line;
    }
    const bool complains =
        line.find("ERROR") != std::string::npos || line.find("Check failed") != std::string::npos;
    if (complaint.empty() && complains) complaint = line;
    if (on_line) on_line(line);
  };
  ChildResult result = RunChild(colmap.path, arguments, options);
  const std::string name = "colmap " + step;
  if (known != nullptr && known->of_version) {
    throw EnvironmentError(fmt::format("{}: {} ({}); {}", name, known->message, known_line,
                                       ColmapVersions(colmap.version)));
  }
  if (known != nullptr) throw EnvironmentError(fmt::format("{}: {}", name, known->message));
  if (result.exit_code > 128) {
    const int signal = result.exit_code - 128;
    const char* advice = signal == 9 ? ", perhaps because memory ran out" : "";
    throw EnvironmentError(fmt::format(
        "{} was ended by signal {}{}{}; its output is in {}{}", name, signal, advice,
        complaint.empty() ? "" : " (" + complaint + ")", colmap.log.string(), VersionNote(colmap)));
  }
  return result;
}

// "... [12/50]" -> 12
std::optional<size_t> CounterOf(const std::string& line, const char* start) {
  if (!line.starts_with(start)) return {};
  const size_t bracket = line.find('[');
  size_t value = 0;
  if (bracket == std::string::npos) return {};
  const auto [end, error] =
      std::from_chars(line.data() + bracket + 1, line.data() + line.size(), value);
  return error == std::errc() ? std::optional<size_t>(value) : std::nullopt;
}

std::string JoinedLines(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

using PairMatches = std::vector<std::pair<ImagePair, std::vector<FeatureMatch>>>;

PairMatches MatchBlock(const std::map<uint32_t, Descriptors>& descriptors,
                       const std::vector<ImagePair>& block) {
  PairMatches matches(block.size());
  ParallelForEach(
      block.size(), "", "finished blocks of pairs are kept in the database", [&](size_t i) {
        const auto [first, second] = block[i];
        matches[i] = {block[i], MatchDescriptors(descriptors.at(first), descriptors.at(second))};
      });
  return matches;
}

// Verifies the geometry of matched pairs; `lines` contains their names.
void VerifyPairs(const ColmapProgram& colmap, const fs::path& database, const fs::path& scratch,
                 const std::vector<ImagePair>& pairs, const std::string& lines) {
  const fs::path list = scratch / "pairs.txt";
  WriteText(list, lines);
  // If the database contains raw matches, this command only verifies their geometry.
  RunStep(colmap, "matches_importer",
          {"--database_path", database, "--match_list_path", list, "--match_type", "pairs",
           "--SiftMatching.use_gpu", "0",
           // Its random numbers depend on which thread gets which pair.
           "--SiftMatching.num_threads", "1"});
  const std::set<ImagePair> verified = ColmapDatabase(database, colmap.version).VerifiedPairs();
  const bool complete = std::all_of(pairs.begin(), pairs.end(),
                                    [&](const ImagePair& p) { return verified.contains(p); });
  if (!complete) {
    throw EnvironmentError(
        fmt::format("colmap matches_importer did not verify all pairs; its output is in {}{}",
                    colmap.log.string(), VersionNote(colmap)));
  }
}

// Paths are relative to the database's folder, where "photos" and "masks" are links to these: the
// names of the user's folders must not change the layout of memory.
void ExtractPart(const ColmapProgram& colmap, const std::vector<std::string>& names,
                 const ExtractOptions& options, const fs::path& database,
                 const std::function<void()>& on_image) {
  const std::string file = database.filename().string(), list = file + ".txt";
  WriteText(database.parent_path() / list, JoinedLines(names));
  const bool is_masked = !options.masks.empty();
  const int features = options.max_features * (is_masked ? kFeaturesBeforeMasks : 1);
  std::vector<std::string> arguments = {"--database_path",
                                        file,
                                        "--image_path",
                                        kPhotosLink,
                                        "--image_list_path",
                                        list,
                                        "--ImageReader.camera_model",
                                        options.camera_model,
                                        options.camera_per_image
                                            ? "--ImageReader.single_camera_per_image"
                                            : "--ImageReader.single_camera_per_folder",
                                        "1",
                                        "--SiftExtraction.use_gpu",
                                        "0",
                                        "--SiftExtraction.num_threads",
                                        "1",
                                        "--SiftExtraction.max_image_size",
                                        std::to_string(kSiftMaxImageSize_px),
                                        "--SiftExtraction.max_num_features",
                                        std::to_string(features)};
  if (is_masked) arguments.insert(arguments.end(), {"--ImageReader.mask_path", kMasksLink});
  RunStep(
      colmap, "feature_extractor", arguments,
      [&](const std::string& line) {
        if (CounterOf(line, "Processed file")) on_image();
      },
      database.parent_path());
  if (!fs::exists(database)) {
    throw EnvironmentError(
        fmt::format("colmap feature_extractor wrote no database; its output is in {}{}",
                    colmap.log.string(), VersionNote(colmap)));
  }
}

}  // namespace

ColmapProgram FindColmap(const fs::path& log) {
  ColmapProgram colmap{FindProgram("colmap"), "unknown", log};
  if (colmap.path.empty()) {
    throw EnvironmentError(
        "there is no colmap in PATH; install it, on Debian with: apt-get install colmap");
  }
  ChildOptions options;
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  options.time_limit_s = 60;
  const std::regex first_line("^COLMAP ([0-9][0-9.]*)");
  options.on_line = [&](const std::string& line) {
    std::smatch match;
    if (colmap.version == "unknown" && std::regex_search(line, match, first_line))
      colmap.version = match[1];
  };
  RunChild(colmap.path, {"help"}, options);
  if (!IsTestedColmap(colmap.version)) {
    LogWarning("COLMAP {} was not tested with Tetrec; {} was", colmap.version, kTestedColmap);
  }
  return colmap;
}

void ExtractFeatures(const ColmapProgram& colmap, const fs::path& photos,
                     const std::vector<std::string>& names, const ExtractOptions& options,
                     const fs::path& parts, const fs::path& database) {
  fs::create_directories(parts);
  fs::remove(parts / kPhotosLink);
  fs::create_directory_symlink(fs::absolute(photos), parts / kPhotosLink);
  fs::remove(parts / kMasksLink);
  if (!options.masks.empty()) {
    fs::create_directory_symlink(fs::absolute(options.masks), parts / kMasksLink);
  }
  const size_t part_count =
      std::min<size_t>(names.size(), std::max(1u, std::thread::hardware_concurrency()));
  std::vector<fs::path> part_files;
  for (size_t part = 0; part < part_count; ++part) {
    part_files.push_back(parts / fmt::format("part-{}-of-{}.db", part + 1, part_count));
  }
  Progress progress("features: photo", double(names.size()));
  std::mutex mutex;
  size_t done = 0;
  ParallelFor(part_count, 1, [&](size_t part, size_t) {
    std::vector<std::string> own;
    for (size_t i = part; i < names.size(); i += part_count) own.push_back(names[i]);
    ExtractPart(colmap, own, options, part_files[part], [&] {
      const std::scoped_lock lock(mutex);
      progress.Update(double(++done));
    });
  });

  const fs::path half = database.string() + ".tmp";
  for (const char* rest : {"-wal", "-shm"})
    fs::remove(half.string() + rest);  // left by a killed run
  std::error_code error;
  fs::copy_file(part_files[0], half, fs::copy_options::overwrite_existing, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({})", half.string(), error.message()));
  }
  std::set<std::string> found;
  {
    // The database is closed before the file gets its name: only then is it complete.
    ColmapDatabase merged(half, colmap.version);
    for (size_t part = 1; part < part_count; ++part) merged.Append(part_files[part]);
    merged.NumberByFileName(!options.camera_per_image);
    merged.KeepCoarsest(size_t(options.max_features));
    for (const DatabaseImage& image : merged.Images()) found.insert(image.name);
  }
  for (const std::string& name : names) {
    if (!found.contains(name)) {
      const fs::path photo = photos / name;
      throw DataError(fmt::format(
          "colmap feature_extractor left out {}; its output is in {}",
          (fs::is_symlink(photo) ? fs::read_symlink(photo) : photo).string(), colmap.log.string()));
    }
  }
  fs::rename(half, database);
}

MatchCounts MatchFeatures(const ColmapProgram& colmap, const fs::path& database_path,
                          PairChoice choice, const fs::path& scratch) {
  std::vector<ImagePair> pairs;
  {
    const ColmapDatabase database(database_path, colmap.version);
    pairs = ChoosePairs(database, database.Images(), choice);
  }
  return MatchFeatures(colmap, database_path, pairs, scratch);
}

MatchCounts MatchFeatures(const ColmapProgram& colmap, const fs::path& database_path,
                          const std::vector<ImagePair>& pairs, const fs::path& scratch) {
  MatchCounts counts;
  std::map<uint32_t, Descriptors> descriptors;
  std::map<uint32_t, std::string> names;
  std::set<ImagePair> matched, verified;  // in an earlier run
  {
    const ColmapDatabase database(database_path, colmap.version);
    matched = database.MatchedPairs();
    verified = database.VerifiedPairs();
    for (const DatabaseImage& image : database.Images()) {
      names[image.id] = image.name;
      descriptors[image.id] = database.ReadDescriptors(image.id);
    }
  }
  counts.pairs = pairs.size();
  Progress progress("matching: pair", double(pairs.size()));
  std::future<void> verification;  // of the previous block, while this one is matched
  for (size_t start = 0; start < pairs.size(); start += kPairsPerBlock) {
    const std::vector<ImagePair> block(
        pairs.begin() + std::ptrdiff_t(start),
        pairs.begin() + std::ptrdiff_t(std::min(pairs.size(), start + kPairsPerBlock)));
    std::vector<ImagePair> unmatched, unverified;
    std::string lines;
    for (const ImagePair& pair : block) {
      if (!matched.contains(pair)) unmatched.push_back(pair);
      if (matched.contains(pair) && verified.contains(pair)) continue;
      unverified.push_back(pair);
      lines += names.at(pair.first) + " " + names.at(pair.second) + "\n";
    }
    const PairMatches matches = MatchBlock(descriptors, unmatched);
    if (verification.valid()) verification.get();
    if (!unmatched.empty()) ColmapDatabase(database_path, colmap.version).WriteMatches(matches);
    if (!unverified.empty()) {
      verification = std::async(std::launch::async, VerifyPairs, std::cref(colmap), database_path,
                                scratch, std::move(unverified), std::move(lines));
    }
    progress.Update(double(start + block.size()));
  }
  if (verification.valid()) verification.get();
  counts.matches = ColmapDatabase(database_path, colmap.version).MatchCount();
  return counts;
}

std::vector<fs::path> MapScene(const ColmapProgram& colmap, const fs::path& photos,
                               const fs::path& database, size_t photo_count, int seed,
                               const MapperDemands& demands, const fs::path& models) {
  Progress progress("mapping: photo", double(photo_count));
  const std::regex registering("^Registering image #[0-9]+ \\(([0-9]+)\\)");
  RunStep(
      colmap, "mapper",
      {"--database_path", database, "--image_path", photos, "--output_path", models,
       "--random_seed", std::to_string(seed), "--Mapper.init_min_num_inliers",
       std::to_string(demands.pair_inliers), "--Mapper.abs_pose_min_num_inliers",
       std::to_string(demands.image_inliers),
       // More threads are hardly faster and sum in a different order each time.
       "--Mapper.num_threads", "1",
       // All cameras are adjusted each time the model has grown by 40 % (COLMAP: 10 %), in fewer
       // rounds. This saves a quarter of the time; the final adjustment determines the result.
       "--Mapper.ba_global_images_ratio", "1.4", "--Mapper.ba_global_points_ratio", "1.4",
       "--Mapper.ba_global_max_refinements", "2", "--Mapper.ba_local_max_num_iterations", "16",
       "--Mapper.ba_local_max_refinements", "1",
       // COLMAP continues as long as anything improves at all. This saves a third of the time.
       "--Mapper.ba_global_function_tolerance", "1e-5", "--Mapper.ba_local_function_tolerance",
       "1e-3"},
      [&](const std::string& line) {
        std::smatch match;
        if (std::regex_search(line, match, registering)) progress.Update(std::stod(match[1]));
      });
  std::vector<fs::path> folders;
  while (fs::is_directory(models / std::to_string(folders.size()))) {
    folders.push_back(models / std::to_string(folders.size()));
  }
  return folders;
}

bool TriangulateModel(const ColmapProgram& colmap, const fs::path& photos, const fs::path& database,
                      const fs::path& known, const fs::path& found) {
  bool nothing_to_adjust = false;  // COLMAP aborts then
  try {
    RunStep(colmap, "point_triangulator",
            {"--database_path", database, "--image_path", photos, "--input_path", known,
             "--output_path", found, "--Mapper.ba_refine_focal_length", "0",
             "--Mapper.ba_refine_principal_point", "0", "--Mapper.ba_refine_extra_params", "0",
             // As in the mapper, threads sum in a different order each time.
             "--Mapper.num_threads", "1"},
            [&](const std::string& line) {
              nothing_to_adjust |= line.find("bundle_adjuster.Solve") != std::string::npos;
            });
  } catch (const EnvironmentError&) {
    if (nothing_to_adjust) return false;
    throw;
  }
  if (!fs::exists(found / "points3D.bin")) {
    throw EnvironmentError(
        fmt::format("colmap point_triangulator wrote no model; its output is in {}{}",
                    colmap.log.string(), VersionNote(colmap)));
  }
  return true;
}

}  // namespace tetrec
