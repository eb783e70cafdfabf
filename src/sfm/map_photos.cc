// From photos to the model that COLMAP finds of them.
#include "sfm/map_photos.h"

#include "colmap/database.h"
#include "colmap/run.h"
#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/timer.h"
#include "sfm/lens_doubt.h"
#include "sfm/linked_photos.h"
#include "sfm/model_quality.h"
#include "sfm/retry.h"
#include "sfm/work_key.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Photos of a camera; fewer do not determine the four OPENCV distortion parameters well.
constexpr size_t kPhotosForOpenCvModel = 8;
constexpr int kMostFeatures = 100000;  // as SfmOptions::Check allows

// The cameras that took too few photos for the lens OPENCV.
size_t CamerasOfFewPhotos(const LinkedPhotos& linked) {
  return size_t(std::ranges::count_if(
      linked.photos_of_camera, [](size_t photos) { return photos < kPhotosForOpenCvModel; }));
}

// The lens model that the mapping starts with; with kAuto, cameras that took few photos get a
// simpler one (FindMatches).
SfmLens LensFor(const SfmOptions& options, const LinkedPhotos& linked) {
  if (options.camera_model != SfmLens::kAuto) return options.camera_model;
  const bool all_took_few = CamerasOfFewPhotos(linked) == linked.photos_of_camera.size();
  return all_took_few ? SfmLens::kSimpleRadial : SfmLens::kOpenCv;
}

std::string FeaturesKey(const SfmOptions& options, const std::vector<Photo>& photos,
                        const LinkedPhotos& linked, const ExtractOptions& extract,
                        const std::string& colmap_version) {
  nlohmann::json key = {{"colmap", colmap_version},
                        {"model", extract.camera_model},
                        // Cameras that took few photos then have another one.
                        {"auto", options.camera_model == SfmLens::kAuto},
                        {"per_image", extract.camera_per_image},
                        {"features", extract.max_features},
                        {"format", 3}};  // 2: numbered by camera first, one lens model for all
  for (size_t i = 0; i < photos.size(); ++i)
    key["photos"].push_back({linked.names[i], photos[i].sha256});
  if (!linked.masks.empty()) {
    for (const Photo& photo : photos) key["masks"].push_back(photo.mask_sha256);
  }
  return WorkKey(key);
}

void CopyDatabase(const fs::path& from, const fs::path& to) {
  const fs::path half = to.string() + ".tmp";
  std::error_code error;
  fs::copy_file(from, half, fs::copy_options::overwrite_existing, error);
  if (error)
    throw EnvironmentError(
        fmt::format("{}: cannot be written ({})", half.string(), error.message()));
  fs::rename(half, to);
}

fs::path ModelWithMostImages(const std::vector<fs::path>& folders, ColmapModel& best) {
  fs::path chosen;
  for (const fs::path& folder : folders) {
    ColmapModel model = ReadColmapModel(folder);
    LogInfo("model {}: {} photos, {} points", folder.filename().string(), model.images.size(),
            model.points.size());
    const auto rank = [](const ColmapModel& m) {
      return std::pair(m.images.size(), m.points.size());
    };
    if (chosen.empty() || rank(model) > rank(best)) {
      chosen = folder;
      best = std::move(model);
    }
  }
  return chosen;
}

// Gives the model's images the photos' own names.
void Rename(ColmapModel& model, const LinkedPhotos& linked, const std::vector<Photo>& photos) {
  for (auto& [id, image] : model.images) {
    const auto found = linked.photo_of_name.find(image.name);
    if (found == linked.photo_of_name.end()) {
      throw DataError(fmt::format("COLMAP's model contains the image {}, which is not one of ours",
                                  image.name));
    }
    image.name = photos[found->second].name;
  }
}

// The model with the most images of a database, from the cache if it is there; without images if
// COLMAP found none.
struct Mapping {
  ColmapModel model;
  size_t models = 0;                                 // found now; 0: from the cache, or none
  nlohmann::json retries = nlohmann::json::array();  // notes of further tries
};

Mapping Map(const ColmapProgram& colmap, const fs::path& photos, const fs::path& database,
            size_t photo_count, int seed, const MapperDemands& demands, const fs::path& scratch,
            const fs::path& finished) {
  Mapping mapping;
  if (!fs::exists(finished)) {
    const fs::path models = scratch / "models";
    fs::remove_all(models);
    fs::create_directories(models);
    const std::vector<fs::path> folders =
        MapScene(colmap, photos, database, photo_count, seed, demands, models);
    if (folders.empty()) return mapping;
    mapping.models = folders.size();
    fs::rename(ModelWithMostImages(folders, mapping.model), finished);
  }
  mapping.model = ReadColmapModel(finished);
  return mapping;
}

// What all tries of one run share.
struct SfmWork {
  const SfmOptions& options;
  const ColmapProgram& colmap;
  const LinkedPhotos& linked;
  const ExtractOptions& extract;
  SfmLens first_lens;  // of the database `matches`
  fs::path scratch, cache, matches;
};

// The database, or a copy of it in which all cameras have another lens than the first one. No match
// depends on the lens: all begin without distortion and with the same focal length.
fs::path WithLens(const SfmWork& work, const fs::path& database, SfmLens lens) {
  if (lens == work.first_lens) return database;
  const fs::path other = fmt::format("{}-{}", database.string(), Name(lens));
  if (!fs::exists(other)) {
    const fs::path half = other.string() + ".half";
    CopyDatabase(database, half);
    ColmapDatabase(half, work.colmap.version).UseLens(*FromName<LensModel>(Name(lens)));
    fs::rename(half, other);
  }
  return other;
}

// The ids of the photos in the database that the model lacks.
std::set<uint32_t> MissingPhotos(const ColmapDatabase& database, const ColmapModel& model) {
  std::set<std::string> registered;
  for (const auto& [id, image] : model.images) registered.insert(image.name);
  std::set<uint32_t> missing;
  for (const DatabaseImage& image : database.Images()) {
    if (!registered.contains(image.name)) missing.insert(image.id);
  }
  return missing;
}

// Makes a database with more features of the photos that the missing ones concern, and matches
// them.
void WriteRicherDatabase(const SfmWork& work, const std::set<uint32_t>& missing, int max_features,
                         const fs::path& before, const fs::path& richer) {
  std::vector<std::string> names;
  std::vector<ImagePair> pairs;
  {
    const ColmapDatabase database(before, work.colmap.version);
    const std::vector<DatabaseImage> images = database.Images();
    std::vector<uint32_t> ids;
    for (const DatabaseImage& image : images) ids.push_back(image.id);
    const std::map<ImagePair, uint64_t> matches = database.MatchCounts();
    const std::vector<uint32_t> concerned = ConcernedPhotos(ids, missing, matches);
    // Where not all pairs were matched, all pairs of many photos are many times as many.
    const bool are_few =
        ids.size() <= kExhaustivePhotos || work.options.matcher == PairChoice::kExhaustive;
    pairs = are_few
                ? PairsOfRetry(ids, concerned, missing)
                : LikelyPairsOfRetry(ids, concerned, missing, matches, database.PairsWithInliers());
    for (const DatabaseImage& image : images) {
      if (std::binary_search(concerned.begin(), concerned.end(), image.id)) {
        names.push_back(image.name);
      }
    }
    LogInfo(
        "{} photos are not registered; trying again with up to {} features of {} photos, in {} "
        "pairs",
        missing.size(), WithThousands(size_t(max_features)), names.size(), pairs.size());
  }
  const fs::path features = richer.string() + ".features", parts = richer.string() + ".parts";
  ExtractOptions extract = work.extract;
  extract.max_features = max_features;
  if (!fs::exists(features)) {
    ExtractFeatures(work.colmap, work.linked.folder, names, extract, parts, features);
    fs::remove_all(parts);
  }
  if (!fs::exists(richer)) {
    const fs::path half = richer.string() + ".half";
    CopyDatabase(before, half);
    {
      ColmapDatabase database(half, work.colmap.version);
      const uint64_t added = database.AppendFiner(ColmapDatabase(features, work.colmap.version));
      LogInfo("{} features more", WithThousands(added));
      database.ForgetPairs(pairs);
    }
    fs::rename(half, richer);
  }
  MatchFeatures(work.colmap, richer, pairs, work.scratch);
}

// Maps once more, and keeps the better model. `how`: notes what differs in this try, which began
// with `timer`.
void MapAgain(const SfmWork& work, const fs::path& database, const MapperDemands& demands,
              const fs::path& finished, nlohmann::json how, const Timer& timer, ColmapModel& model,
              nlohmann::json& notes) {
  const Mapping mapping = Map(work.colmap, work.linked.folder, database, work.linked.names.size(),
                              work.options.seed, demands, work.scratch, finished);
  const bool better = IsBetterModel(model, mapping.model);
  LogInfo(
      "{} photos registered instead of {}, mean reprojection error {:.3f} px instead of "
      "{:.3f}: {}",
      mapping.model.images.size(), model.images.size(), MeanReprojectionError_px(mapping.model),
      MeanReprojectionError_px(model), better ? "kept" : "not kept");
  how.update({{"registered_before", model.images.size()},
              {"registered", mapping.model.images.size()},
              {"mean_reprojection_error_px", MeanReprojectionError_px(mapping.model)},
              {"kept", better},
              {"seconds", timer.seconds()}});
  notes.push_back(std::move(how));
  if (better) model = mapping.model;
}

// Tries again where photos stayed out: with more features of them; and at last, if the model would
// be refused, with milder demands of the mapper. Where only some photos stay out, those may well
// show something else. Returns a note of each try.
nlohmann::json Retry(const SfmWork& work, SfmLens lens, const std::string& model_name,
                     ColmapModel& model) {
  nlohmann::json notes = nlohmann::json::array();
  int max_features = work.options.max_features;
  fs::path richest = work.matches;
  std::string suffix;
  const size_t photos = work.linked.names.size();
  for (int i = 1; i <= work.options.retries && model.images.size() < photos; ++i) {
    const Timer timer;
    max_features = std::min(max_features * 8 / 3, kMostFeatures);
    const std::set<uint32_t> missing =
        MissingPhotos(ColmapDatabase(richest, work.colmap.version), model);
    suffix +=
        "-retry-" + WorkKey(missing);  // other lenses that leave out the same photos use it, too
    const fs::path richer = work.matches.string() + suffix;
    WriteRicherDatabase(work, missing, max_features, richest, richer);
    MapAgain(work, WithLens(work, richer, lens), kUsualDemands, work.cache / (model_name + suffix),
             {{"max_features", max_features}}, timer, model, notes);
    richest = richer;
  }
  if (!HasEnoughPhotos(model, photos)) {
    LogInfo(
        "{} of {} photos are registered; trying again with at least {} instead of {} inliers "
        "for the first pair, and {} instead of {} for each further photo",
        model.images.size(), photos, kMildDemands.pair_inliers, kUsualDemands.pair_inliers,
        kMildDemands.image_inliers, kUsualDemands.image_inliers);
    MapAgain(work, WithLens(work, richest, lens), kMildDemands,
             work.cache / (model_name + suffix + "-mild"),
             {{"pair_inliers", kMildDemands.pair_inliers},
              {"image_inliers", kMildDemands.image_inliers}},
             Timer(), model, notes);
  }
  return notes;
}

// Features and matches of the photos, and a model of them by one lens after another.
class PhotoMapper {
 public:
  PhotoMapper(const SfmOptions& options, const std::vector<Photo>& photos, Stage& stage)
      : options_(options),
        photos_(photos),
        stage_(stage),
        colmap_(FindColmap(stage.folder() / "log.txt")),
        scratch_(stage.Scratch("work")),
        linked_(LinkPhotos(photos, options.camera_sharing, scratch_ / "photos")),
        first_lens_(LensFor(options, linked_)) {
    const size_t cameras = linked_.photos_of_camera.size();
    LogInfo("COLMAP {}: {} photos of {} camera{}", colmap_.version, photos.size(), cameras,
            cameras == 1 ? "" : "s");
    stage.Note("colmap", colmap_.version);
    WriteColmapMasks(photos, scratch_ / "masks", linked_);
    extract_ = {Name(first_lens_), options_.camera_sharing == CameraSharing::kPerImage,
                options_.max_features, linked_.masks};
    cache_ =
        stage_.Cache("colmap") / FeaturesKey(options_, photos_, linked_, extract_, colmap_.version);
    fs::create_directories(cache_);
    FindMatches();
  }

  SfmLens first_lens() const { return first_lens_; }

  // The lens models of all cameras, for the manifest.
  std::string LensNote(SfmLens lens) const {
    const size_t few = CamerasOfFewPhotos(linked_);
    if (options_.camera_model != SfmLens::kAuto || lens != SfmLens::kOpenCv || few == 0)
      return Name(lens);
    return fmt::format("{}, of cameras with fewer than {} photos {}: {}", Name(lens),
                       kPhotosForOpenCvModel, Name(SfmLens::kSimpleRadial), few);
  }

  // From the cache as far as it has them.
  Mapping MapWith(SfmLens lens) {
    const SfmWork work{options_,    colmap_,  linked_, extract_,
                       first_lens_, scratch_, cache_,  matches_};
    const std::string suffix = lens == first_lens_ ? "" : fmt::format("-{}", Name(lens));
    const std::string model_name =
        fmt::format("mapped-{}-{}{}", Name(options_.matcher), options_.seed, suffix);
    Timer timer;
    Mapping mapping = Map(colmap_, linked_.folder, WithLens(work, matches_, lens), photos_.size(),
                          options_.seed, kUsualDemands, scratch_, cache_ / model_name);
    CountSeconds("mapping", timer);
    if (options_.retries > 0 && mapping.model.images.size() < photos_.size()) {
      timer = {};
      mapping.retries = Retry(work, lens, model_name, mapping.model);
      CountSeconds("retries", timer);
    }
    Rename(mapping.model, linked_, photos_);
    return mapping;
  }

 private:
  // The database with features and matches, by the first lens; cameras of few photos only have it
  // if it was asked for.
  void FindMatches() {
    const fs::path features = cache_ / "features.db";
    matches_ = cache_ / fmt::format("{}.db", Name(options_.matcher));
    Timer timer;
    if (!fs::exists(features)) {
      ExtractFeatures(colmap_, linked_.folder, linked_.names, extract_, cache_ / "parts", features);
      fs::remove_all(cache_ / "parts");
    }
    if (!fs::exists(matches_)) {
      const fs::path half = matches_.string() + ".half";
      CopyDatabase(features, half);
      if (options_.camera_model == SfmLens::kAuto) {
        ColmapDatabase(half, colmap_.version)
            .UseLens(LensModel::kSimpleRadial, kPhotosForOpenCvModel);
      }
      fs::rename(half, matches_);
    }
    CountSeconds("features", timer);
    timer = {};
    const MatchCounts matches = MatchFeatures(colmap_, matches_, options_.matcher, scratch_);
    LogInfo("{} matches in {} pairs", WithThousands(matches.matches), WithThousands(matches.pairs));
    stage_.Count("pairs", matches.pairs);
    stage_.Count("matches", matches.matches);
    CountSeconds("matching", timer);
  }

  // By all lenses together.
  void CountSeconds(const std::string& what, const Timer& timer) {
    stage_.Seconds(what, seconds_[what] += timer.seconds());
  }

  const SfmOptions& options_;
  const std::vector<Photo>& photos_;
  Stage& stage_;
  ColmapProgram colmap_;
  fs::path scratch_;
  LinkedPhotos linked_;
  SfmLens first_lens_;
  ExtractOptions extract_;
  fs::path cache_, matches_;
  std::map<std::string, double> seconds_;
};

}  // namespace

ColmapModel MapPhotos(const SfmOptions& options, const std::vector<Photo>& photos, Stage& stage) {
  PhotoMapper mapper(options, photos, stage);
  SfmLens lens = mapper.first_lens();
  Mapping mapping = mapper.MapWith(lens);
  while (options.camera_model == SfmLens::kAuto && lens != SfmLens::kSimplePinhole) {
    const std::optional<LensDoubt> doubt = DoubtOf(mapping.model, photos.size(), options.max_size);
    if (!doubt) break;
    const SfmLens simpler =
        lens == SfmLens::kOpenCv ? SfmLens::kSimpleRadial : SfmLens::kSimplePinhole;
    LogInfo("lens {}: {}; trying again with {}", Name(lens), doubt->reason, Name(simpler));
    Mapping other = mapper.MapWith(simpler);
    const bool is_taken =
        Replaces(other.model, mapping.model, *doubt, photos.size(), options.max_size);
    LogInfo(
        "lens {}: {} photos, {} points, mean reprojection error {:.3f} px ({}: {}, {}, {:.3f}): {}",
        Name(simpler), other.model.images.size(), WithThousands(other.model.points.size()),
        MeanReprojectionError_px(other.model), Name(lens), mapping.model.images.size(),
        WithThousands(mapping.model.points.size()), MeanReprojectionError_px(mapping.model),
        is_taken ? "taken" : "not taken");
    if (!is_taken) break;
    lens = simpler;
    mapping = std::move(other);
  }
  if (mapping.model.images.empty()) {
    throw DataError(fmt::format(
        "COLMAP found no model: the {} photos do not overlap enough, or were taken from almost one "
        "place; take photos of one scene from many places, each sharing most of what it shows with "
        "the next",
        photos.size()));
  }
  if (mapping.models > 0) stage.Count("models", mapping.models);
  stage.Count("retries", mapping.retries.size());
  stage.Note("retries", mapping.retries);
  stage.Note("lens", mapper.LensNote(lens));
  return std::move(mapping.model);
}

}  // namespace tetrec
