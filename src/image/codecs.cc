// Loads the plugin that links OpenCV's codecs.
#include "image/codecs.h"

#include "core/error.h"

#include <dlfcn.h>
#include <fmt/format.h>

namespace tetrec {
namespace {

ImageCodecs LoadCodecs() {
  void* plugin = dlopen("libtetrec_opencv_codecs.so", RTLD_NOW | RTLD_LOCAL);
  void* get = plugin == nullptr ? nullptr : dlsym(plugin, "TetrecOpenCvCodecs");
  if (get == nullptr) {
    throw EnvironmentError(fmt::format(
        "the readers of image files cannot be loaded ({}); they must be in ../lib beside "
        "the program, and need free memory",
        dlerror()));
  }
  ImageCodecs codecs;
  reinterpret_cast<void (*)(ImageCodecs&)>(get)(codecs);
  return codecs;
}

}  // namespace

const ImageCodecs& OpenCvCodecs() {
  static const ImageCodecs codecs = LoadCodecs();
  return codecs;
}

}  // namespace tetrec
