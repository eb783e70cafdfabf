// OpenCV's readers and writers of image files, loaded when they are first needed.
#pragma once

#include <opencv2/core.hpp>

#include <string>
#include <vector>

namespace tetrec {

// cv::imdecode and cv::imencode. Their library needs more than a hundred others (GDAL and its own),
// which take 0.13 s to load, several times as long as all else that a stage needs. So no program
// links it, but a plugin does (codecs/opencv_codecs.cc).
struct ImageCodecs {
  cv::Mat (*decode)(cv::InputArray encoded, int flags) = nullptr;
  bool (*encode)(const std::string& extension, cv::InputArray pixels, std::vector<uchar>& bytes,
                 const std::vector<int>& parameters) = nullptr;
};

// The first call loads the plugin from ../lib beside the program. Throws EnvironmentError.
const ImageCodecs& OpenCvCodecs();

}  // namespace tetrec
