// Transfer functions and their two formats.
#include "volume/transfer_function.h"

#include "core/checked_json.h"
#include "core/file.h"
#include "image/srgb.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// More points would be slow, and nobody draws a function with so many.
constexpr size_t kMaxPoints = 4096;

// The points around x, and the position of x between them as a fraction.
template <class Point>
struct Between {
  const Point& before;
  const Point& after;
  double fraction;
};

template <class Point>
Between<Point> Find(const std::vector<Point>& points, double x) {
  const auto after = std::upper_bound(points.begin(), points.end(), x,
                                      [](double value, const Point& p) { return value < p.x; });
  if (after == points.begin()) return {points.front(), points.front(), 0};
  if (after == points.end()) return {points.back(), points.back(), 0};
  const Point& before = *(after - 1);
  return {before, *after, (x - before.x) / (after->x - before.x)};
}

template <class Point>
void CheckPosition(const std::vector<Point>& before, double x, const CheckedJson& json) {
  if (!before.empty() && !(before.back().x < x)) {
    json.Fail(
        fmt::format("is {}, not above the previous position, {}; positions must rise strictly", x,
                    before.back().x));
  }
}

void CheckCount(size_t count, const CheckedJson& json) {
  if (count == 0 || count > kMaxPoints) {
    json.Fail(fmt::format("has {} points; expected 1 to {}", count, kMaxPoints));
  }
}

CheckedJson Row(const CheckedJson& list, size_t index, size_t columns, const char* what) {
  const CheckedJson row = list.Item(index);
  if (row.Size() != columns) {
    row.Fail(fmt::format("has {} numbers; expected {}: {}", row.Size(), columns, what));
  }
  return row;
}

TransferFunction ParseOurs(const CheckedJson& json) {
  TransferFunction function;
  const CheckedJson opacity = json.Field("opacity"), color = json.Field("colour");
  CheckCount(opacity.Size(), opacity);
  CheckCount(color.Size(), color);
  for (size_t i = 0; i < opacity.Size(); ++i) {
    const CheckedJson row = Row(opacity, i, 2, "x, opacity");
    const double x = row.Item(0).NumberIn(0, 1);
    CheckPosition(function.opacity, x, row.Item(0));
    function.opacity.push_back({x, row.Item(1).NumberIn(0, 1)});
  }
  for (size_t i = 0; i < color.Size(); ++i) {
    const CheckedJson row = Row(color, i, 4, "x, r, g, b");
    const double x = row.Item(0).NumberIn(0, 1);
    CheckPosition(function.color, x, row.Item(0));
    function.color.push_back(
        {x, {row.Item(1).NumberIn(0, 1), row.Item(2).NumberIn(0, 1), row.Item(3).NumberIn(0, 1)}});
  }
  return function;
}

// The number of points in a flat list with four numbers per point.
size_t CountInFours(const CheckedJson& list, const char* what) {
  if (list.Size() % 4 != 0) {
    list.Fail(fmt::format("has {} numbers; expected four per point: {}", list.Size(), what));
  }
  CheckCount(list.Size() / 4, list);
  return list.Size() / 4;
}

// Moves positions from values of the samples to [0, 1], where `values` are those at 0 and 1. A map
// that spans 0 to 1, like stored presets, has normalised positions already.
TransferFunction MovedToUnitRange(TransferFunction function, const glm::dvec2& values,
                                  const CheckedJson& json) {
  const double min = std::min(function.opacity.front().x, function.color.front().x);
  const double max = std::max(function.opacity.back().x, function.color.back().x);
  if (!(max > min) || !std::isfinite(max - min)) {
    json.Fail(fmt::format("spans {} to {}; expected a range of positions", min, max));
  }
  if (min == 0 && max == 1) return function;
  const auto move = [&](auto& points) {
    for (size_t i = 0; i < points.size(); ++i) {
      points[i].x = (points[i].x - values[0]) / (values[1] - values[0]);
      if (i > 0 && !(points[i - 1].x < points[i].x)) {
        json.Fail(fmt::format("has positions too close for samples of {} to {}; remove some",
                              values[0], values[1]));
      }
    }
  };
  move(function.opacity);
  move(function.color);
  const bool is_opaque = std::any_of(function.opacity.begin(), function.opacity.end(),
                                     [](const auto& point) { return point.opacity > 0; });
  // The part inside [0, 1], with the values at both ends.
  TransferFunction inside{{{0, function.OpacityAt(0)}},
                          {{0, function.SrgbAt(0)}},
                          function.interpolation,
                          /*given_in_values=*/true};
  for (const auto& point : function.opacity) {
    if (point.x > 0 && point.x < 1) inside.opacity.push_back(point);
  }
  for (const auto& point : function.color) {
    if (point.x > 0 && point.x < 1) inside.color.push_back(point);
  }
  inside.opacity.push_back({1, function.OpacityAt(1)});
  inside.color.push_back({1, function.SrgbAt(1)});
  if (is_opaque && inside.OpaqueStretches().empty()) {
    json.Fail(
        fmt::format("has opacity above 0 only at positions outside {} to {}, the range of the "
                    "samples; move its "
                    "positions, or give another value range LOW,HIGH",
                    values[0], values[1]));
  }
  return inside;
}

TransferFunction ParseParaView(const CheckedJson& json, const glm::dvec2& values) {
  if (json.Size() != 1) {
    json.Fail(fmt::format("contains {} colour maps; expected one", json.Size()));
  }
  const CheckedJson map = json.Item(0);
  const CheckedJson space = map.Field("ColorSpace");
  if (space.Text() != "RGB") {
    space.Fail(
        fmt::format("is \"{}\"; only \"RGB\" is supported: choose it in ParaView's colour map "
                    "editor and export "
                    "the map again",
                    space.Text()));
  }
  if (map.Has("UseLogScale") && !map.Field("UseLogScale").IsOff()) {
    map.Field("UseLogScale").Fail("is on; only maps that are linear in the value are supported");
  }
  TransferFunction function;
  function.interpolation = ColorInterpolation::kSrgb;
  constexpr double kFar = 1e100;
  const CheckedJson color = map.Field("RGBPoints"), opacity = map.Field("Points");
  const size_t colors = CountInFours(color, "x, r, g, b");
  for (size_t i = 0; i < colors; ++i) {
    const auto item = [&](size_t k) { return color.Item(4 * i + k); };
    const double x = item(0).NumberIn(-kFar, kFar);
    CheckPosition(function.color, x, item(0));
    function.color.push_back(
        {x, {item(1).NumberIn(0, 1), item(2).NumberIn(0, 1), item(3).NumberIn(0, 1)}});
  }
  const size_t opacities = CountInFours(opacity, "x, opacity, midpoint, sharpness");
  for (size_t i = 0; i < opacities; ++i) {
    const auto item = [&](size_t k) { return opacity.Item(4 * i + k); };
    const double x = item(0).NumberIn(-kFar, kFar);
    CheckPosition(function.opacity, x, item(0));
    if (item(2).Number() != 0.5)
      item(2).Fail("is a midpoint other than 0.5, which is not supported");
    if (item(3).Number() != 0) item(3).Fail("is a sharpness other than 0, which is not supported");
    function.opacity.push_back({x, item(1).NumberIn(0, 1)});
  }
  return MovedToUnitRange(std::move(function), values, map);
}

}  // namespace

double TransferFunction::OpacityAt(double x) const {
  const Between<OpacityPoint> at = Find(opacity, x);
  return at.before.opacity + at.fraction * (at.after.opacity - at.before.opacity);
}

glm::dvec3 TransferFunction::SrgbAt(double x) const {
  const Between<ColorPoint> at = Find(color, x);
  if (interpolation == ColorInterpolation::kSrgb) {
    return glm::mix(at.before.color_srgb, at.after.color_srgb, at.fraction);
  }
  return SrgbFromLinear(glm::mix(LinearFromSrgb(at.before.color_srgb),
                                 LinearFromSrgb(at.after.color_srgb), at.fraction));
}

std::vector<glm::dvec2> TransferFunction::OpaqueStretches() const {
  std::vector<glm::dvec2> stretches;
  const auto add = [&](const OpacityPoint& from, const OpacityPoint& to) {
    if (!(from.x < to.x) || (from.opacity == 0 && to.opacity == 0)) return;
    if (!stretches.empty() && stretches.back()[1] == from.x) {
      stretches.back()[1] = to.x;
    } else {
      stretches.emplace_back(from.x, to.x);
    }
  };
  add({0, opacity.front().opacity}, opacity.front());
  for (size_t i = 1; i < opacity.size(); ++i) add(opacity[i - 1], opacity[i]);
  add(opacity.back(), {1, opacity.back().opacity});
  return stretches;
}

TransferFunction ParseTransferFunction(const nlohmann::json& json,
                                       const std::filesystem::path& file,
                                       const glm::dvec2& values_at_0_and_1) {
  const CheckedJson checked(json, file);
  return json.is_array() ? ParseParaView(checked, values_at_0_and_1) : ParseOurs(checked);
}

TransferFunction ReadTransferFunction(const std::filesystem::path& path,
                                      const glm::dvec2& values_at_0_and_1) {
  return ParseTransferFunction(ReadJson(path), path, values_at_0_and_1);
}

}  // namespace tetrec
