// The plugin that image/codecs.h loads.
#include "image/codecs.h"

#include <opencv2/imgcodecs.hpp>

extern "C" void TetrecOpenCvCodecs(tetrec::ImageCodecs& codecs);
extern "C" void TetrecOpenCvCodecs(tetrec::ImageCodecs& codecs) {
  codecs = {cv::imdecode, cv::imencode};
}
