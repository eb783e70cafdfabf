// Escaping, data URIs and JPEG.
#include "eval/html.h"

#include "core/base64.h"
#include "core/error.h"
#include "core/file.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

std::string EscapeHtml(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        const bool control = static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t';
        escaped += control || c == 0x7f ? std::string("&#xFFFD;") : std::string(1, c);
    }
  }
  return escaped;
}

std::string JpegDataUri(const Image& rgb, int quality) {
  return "data:image/jpeg;base64," + Base64(EncodeJpeg(rgb, quality));
}

std::string SvgDataUri(const std::string& svg) {
  return "data:image/svg+xml;base64," +
         Base64({reinterpret_cast<const uint8_t*>(svg.data()), svg.size()});
}

std::string ScriptSource(const std::string& script) {
  const std::string digits =
      Sha256({reinterpret_cast<const uint8_t*>(script.data()), script.size()});
  std::vector<uint8_t> hash;
  for (size_t i = 0; i + 1 < digits.size(); i += 2) {
    hash.push_back(uint8_t(std::stoi(digits.substr(i, 2), nullptr, 16)));
  }
  return "'sha256-" + Base64(hash) + "'";
}

Image FitInto(const Image& image, int max_size) {
  const int longer = std::max(image.width, image.height);
  if (longer <= max_size) return image;
  const double scale = double(max_size) / longer;
  return ResizeByArea(image, std::max(1, int(std::lround(image.width * scale))),
                      std::max(1, int(std::lround(image.height * scale))));
}

}  // namespace tetrec
