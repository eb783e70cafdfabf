// Numbers in words, rows and pictures of the report.
#include "eval/report_text.h"

#include "core/progress.h"
#include "eval/html.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec::report {

std::string E(const std::string& text) { return EscapeHtml(text); }

std::string Picture(const Image& image, int quality, const std::string& alt) {
  return fmt::format("<img src=\"{}\" width=\"{}\" height=\"{}\" alt=\"{}\">",
                     JpegDataUri(image, quality), image.width, image.height, E(alt));
}

std::string Decibel(double psnr) {
  return std::isfinite(psnr) ? fmt::format("{:.2f} dB", psnr) : "identical (∞ dB)";
}

std::string NumberOr(const nlohmann::json& value, const char* format, const char* otherwise) {
  return value.is_number() ? fmt::format(fmt::runtime(format), value.get<double>()) : otherwise;
}

std::string CountOr(const nlohmann::json& value) {
  return value.is_number_unsigned() || (value.is_number_integer() && value.get<int64_t>() >= 0)
             ? WithThousands(value.get<uint64_t>())
             : "–";
}

std::string Bytes(uint64_t bytes) {
  if (bytes == 0) return "–";
  constexpr double kMiB = 1 << 20;
  if (bytes < (uint64_t{1} << 20)) return fmt::format("{:.1f} KiB", double(bytes) / 1024);
  return bytes < (uint64_t{1} << 30) ? fmt::format("{:.1f} MiB", double(bytes) / kMiB)
                                     : fmt::format("{:.2f} GiB", double(bytes) / kMiB / 1024);
}

std::string Duration(double seconds) {
  if (seconds < 9.5) return fmt::format("{:.1f} s", seconds);
  return AsDuration(seconds) + (seconds + 0.5 >= 3600 ? " h" : " min");
}

std::string Plural(size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", WithThousands(count), noun, count == 1 ? "" : "s");
}

std::string Row(const std::string& name, const std::string& value, const std::string& protocol) {
  return fmt::format("<tr><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>", E(name), E(value),
                     E(protocol));
}

}  // namespace tetrec::report
