// Photos from a video: ffmpeg decodes it twice, first small and grey to choose, then as it is.
#include "sfm/video.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/log.h"
#include "sfm/photos.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <map>
#include <numeric>
#include <string>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Candidates: 10 per second, judged at this size whatever the video's shape.
constexpr int kWidth = 480, kHeight = 270;
constexpr size_t kMostCandidates = 20 * 60 * 10;
// Motion is measured on tiles of this many pixels, so that noise and blur do not count.
constexpr int kTile = 15;
// Containers of single video files. Playlists and the like, which name other files, are refused.
constexpr const char* kContainers = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg";

// Runs ffmpeg or ffprobe on the video; `arguments` follow the input. The names in them are relative
// to the working folder, because ffmpeg finds patterns and protocols in paths.
void RunOnVideo(const std::string& program, const fs::path& video,
                const std::vector<std::string>& arguments, const ChildOptions& options) {
  const fs::path path = FindProgram(program);
  if (path.empty()) {
    throw EnvironmentError(
        fmt::format("{}, which reads videos, is not in PATH; install it: "
                    "apt-get install --no-install-recommends ffmpeg",
                    program));
  }
  std::vector<std::string> all = {
      "-hide_banner",        "-loglevel", "error",
      "-protocol_whitelist", "file",      "-format_whitelist",
      kContainers,           "-i",        "file:" + fs::absolute(video).string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  const ChildResult result = RunChild(path, all, options);
  if (result.exit_code != 0) {
    throw DataError(fmt::format(
        "{}: cannot be read as a video ({}); give a folder of photos, or a video such as MP4, MOV, "
        "MKV, WebM or AVI",
        video.string(), result.last_lines.empty() ? "no reason given" : result.last_lines.back()));
  }
}

// Writes `outputs`, whose names are relative to `folder`.
void RunFfmpeg(const fs::path& video, const fs::path& folder, std::vector<std::string> outputs) {
  ChildOptions options;
  options.working_folder = folder;
  // Each frame once. Where sound begins before the picture, ffmpeg would by itself fill the gap
  // with copies of the first frame, in raw files, and an index would mean another frame in each
  // pass.
  const auto common = {"-nostdin", "-an", "-vsync", "passthrough"};
  outputs.insert(outputs.begin(), common.begin(), common.end());
  RunOnVideo("ffmpeg", video, outputs, options);
}

// What a video specifies of its colours, in ffmpeg's words ("unknown": nothing).
struct VideoColors {
  std::string matrix, transfer;
  int width = 0, height = 0;
};

VideoColors ColorsOf(const fs::path& video) {
  std::map<std::string, std::string> fields;
  ChildOptions options;
  options.on_line = [&](const std::string& line) {
    const size_t equals = line.find('=');
    if (equals != std::string::npos) fields[line.substr(0, equals)] = line.substr(equals + 1);
  };
  RunOnVideo(
      "ffprobe", video,
      {"-select_streams", "v:0", "-show_entries", "stream=width,height,color_space,color_transfer",
       "-of", "default=noprint_wrappers=1"},
      options);
  return {fields["color_space"], fields["color_transfer"], std::atoi(fields["width"].c_str()),
          std::atoi(fields["height"].c_str())};
}

// The filter that gives a frame the colours of a JPEG file: BT.601's matrix in the full range. By
// itself ffmpeg changes only the range, and takes the matrix of a video that specifies none for
// BT.601's; players take it for BT.709's if the video is larger than SD.
std::string JpegColors(const VideoColors& colors) {
  const bool is_larger_than_sd = colors.width >= 1280 || colors.height > 576;
  const bool is_bt709 = colors.matrix == "unknown" && is_larger_than_sd;
  return fmt::format("scale={}out_color_matrix=bt601:out_range=pc",
                     is_bt709 ? "in_color_matrix=bt709:" : "");
}

void WarnOfHdr(const fs::path& video, const std::string& transfer) {
  if (transfer != "smpte2084" && transfer != "arib-std-b67") return;
  LogWarning(
      "{}: is an HDR video ({}), whose colours will look flat; record without HDR, or convert it",
      video.filename().string(), transfer == "smpte2084" ? "PQ" : "HLG");
}

std::vector<double> TilesOf(std::span<const uint8_t> grey) {
  std::vector<double> tiles(size_t(kWidth / kTile) * (kHeight / kTile));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      tiles[size_t(y / kTile) * (kWidth / kTile) + x / kTile] +=
          grey[size_t(y) * kWidth + x] / double(kTile * kTile);
    }
  }
  return tiles;
}

double MeanDifference(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += std::abs(a[i] - b[i]);
  return sum / double(a.size());
}

struct Candidates {
  std::vector<double> sharpness, motion;
};

// Of the grey frames in a file, one after another.
Candidates Judge(const fs::path& file) {
  Candidates judged;
  std::ifstream frames(file, std::ios::binary);
  std::vector<uint8_t> grey(size_t(kWidth) * kHeight);
  std::vector<double> before;
  while (frames.read(reinterpret_cast<char*>(grey.data()), std::streamsize(grey.size()))) {
    std::vector<double> tiles = TilesOf(grey);
    judged.sharpness.push_back(SharpnessOf(grey, kWidth, kHeight));
    judged.motion.push_back(before.empty() ? 0 : MeanDifference(tiles, before));
    before = std::move(tiles);
  }
  return judged;
}

}  // namespace

double SharpnessOf(std::span<const uint8_t> grey, int width, int height) {
  TETREC_CHECK(grey.size() == size_t(width) * size_t(height) && width > 2 && height > 2,
               "the image has another size");
  double sum = 0, squares = 0;
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const uint8_t* p = &grey[size_t(y) * size_t(width) + size_t(x)];
      const double laplacian = p[-1] + p[1] + p[-width] + p[width] - 4.0 * p[0];
      sum += laplacian;
      squares += laplacian * laplacian;
    }
  }
  const double count = double(width - 2) * (height - 2), mean = sum / count;
  return squares / count - mean * mean;
}

std::vector<size_t> ChooseFrames(std::span<const double> sharpness, std::span<const double> motion,
                                 size_t count) {
  TETREC_CHECK(sharpness.size() == motion.size() && count > 0, "one number per frame");
  const double total = std::accumulate(motion.begin(), motion.end(), 0.0);
  std::vector<size_t> chosen;
  double way = 0;
  size_t last = 0;  // stretch of the frame chosen last
  for (size_t i = 0; i < motion.size(); ++i) {
    way += motion[i];
    // A picture that never changes is divided evenly.
    const double share = total > 0 ? way / total : double(i) / double(motion.size());
    const size_t stretch = std::min(size_t(share * double(count)), count - 1);
    if (chosen.empty() || stretch != last) {
      chosen.push_back(i);
    } else if (sharpness[i] > sharpness[chosen.back()]) {
      chosen.back() = i;
    }
    last = stretch;
  }
  return chosen;
}

void WriteVideoFrames(const fs::path& video, size_t count, const fs::path& folder,
                      const fs::path& scratch) {
  fs::create_directories(scratch);
  fs::remove_all(folder);
  fs::create_directories(folder);
  RunFfmpeg(video, scratch,
            {"-vf", fmt::format("fps=10,scale={}:{}:flags=area,format=gray", kWidth, kHeight),
             "-frames:v", std::to_string(kMostCandidates + 1), "-f", "rawvideo", "-y",
             "candidates.grey"});
  const Candidates judged = Judge(scratch / "candidates.grey");
  fs::remove(scratch / "candidates.grey");
  const size_t candidates = judged.sharpness.size();
  if (candidates > kMostCandidates) {
    throw DataError(fmt::format("{}: is longer than 20 minutes; cut it", video.string()));
  }
  const std::vector<size_t> chosen = ChooseFrames(judged.sharpness, judged.motion, count);
  if (chosen.size() < kFewestPhotos) {
    throw DataError(
        fmt::format("{}: gives only {} photos, of {} frames at 10 per second; give a longer video, "
                    "in which the camera moves all the time",
                    video.string(), chosen.size(), candidates));
  }
  std::vector<std::string> terms;
  for (const size_t frame : chosen) terms.push_back(fmt::format("eq(n\\,{})", frame));
  const VideoColors colors = ColorsOf(video);
  WarnOfHdr(video, colors.transfer);
  RunFfmpeg(video, folder,
            {"-vf", fmt::format("fps=10,select='{}',{}", fmt::join(terms, "+"), JpegColors(colors)),
             "-q:v", "1", "-qmin", "1", "%06d.jpg"});
  LogInfo("{}: {} of {} frames are taken, the sharpest of stretches with equal motion",
          video.filename().string(), chosen.size(), candidates);
}

}  // namespace tetrec
