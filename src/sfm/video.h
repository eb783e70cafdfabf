// Photos from a video: the sharpest frames, evenly spaced by how much the picture moves.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

// Indices of at most `count` frames, ascending. The frames are divided into `count` stretches in
// which the picture changes by the same amount, and each gives its sharpest frame: a camera that
// rests gives few frames, one that moves quickly gives many. `sharpness`: of each frame, more is
// sharper; `motion`: the change from the frame before, 0 or more. Both have one number per frame.
std::vector<size_t> ChooseFrames(std::span<const double> sharpness, std::span<const double> motion,
                                 size_t count);

// Sharpness of a grey image (height x width, row by row): the variance of its Laplacian.
double SharpnessOf(std::span<const uint8_t> grey, int width, int height);

// Writes `count` frames of the video, fewer if it is short, as 000001.jpg and so on into `folder`,
// which is made anew; ffmpeg decodes as a child process. `scratch` is a folder for a large
// temporary file. Throws DataError (not a video, fewer than three photos, longer than 20 minutes)
// and EnvironmentError (no ffmpeg).
void WriteVideoFrames(const std::filesystem::path& video, size_t count,
                      const std::filesystem::path& folder, const std::filesystem::path& scratch);

}  // namespace tetrec
