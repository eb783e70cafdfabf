// The loss that a field is fitted by.
#include "render/loss.h"

#include "core/error.h"

#include <fmt/format.h>

#include <charconv>

namespace tetrec {

LossOptions ParseLoss(const std::string& words) {
  const std::string pixel = words.substr(0, words.find('+')), prefix = "+dssim:";
  const std::string rest = words.substr(pixel.size());
  LossOptions loss{pixel == "l1" ? LossKind::kL1 : LossKind::kL2};
  if ((pixel != "l1" && pixel != "l2") || (!rest.empty() && !rest.starts_with(prefix))) {
    throw UsageError(fmt::format("{}: no such loss; use l2, l1, l2+dssim:W or l1+dssim:W", words));
  }
  if (rest.empty()) return loss;
  const char* end = rest.data() + rest.size();
  const auto [stop, error] = std::from_chars(rest.data() + prefix.size(), end, loss.dssim);
  if (error != std::errc() || stop != end || !(loss.dssim > 0 && loss.dssim <= 1)) {
    throw UsageError(fmt::format(
        "{}: expected a weight above 0 and at most 1 after dssim:, as in dssim:0.2", words));
  }
  return loss;
}

std::string Name(const LossOptions& loss) {
  const std::string pixel = loss.pixel == LossKind::kL1 ? "l1" : "l2";
  return loss.dssim > 0 ? fmt::format("{}+dssim:{}", pixel, loss.dssim) : pixel;
}

}  // namespace tetrec
