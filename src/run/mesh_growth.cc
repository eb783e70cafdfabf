// Writes and reads growth.json (schema 1).
#include "run/mesh_growth.h"

#include "core/checked_json.h"
#include "core/error_context.h"
#include "core/file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 10> kDecisions = {
    "refine",  "return",  "fine-enough", "end",      "budget",
    "matched", "coarsen", "too-coarse",  "too-fine", "too-late"};
constexpr double kLargest = 1e18;

GrowthDecision ReadDecision(const CheckedJson& field) {
  const auto found = std::find(kDecisions.begin(), kDecisions.end(), field.Text());
  if (found == kDecisions.end()) {
    field.Fail(fmt::format("is none of {}", fmt::join(kDecisions, ", ")));
  }
  return GrowthDecision(found - kDecisions.begin());
}

uint64_t ReadCount(const CheckedJson& field) {
  return uint64_t(field.IntegerIn(0, int64_t(kLargest)));
}

uint64_t CountOrNone(const CheckedJson& field) {
  return field.IsNull() ? kNotCounted : ReadCount(field);
}

double NumberOrZero(const CheckedJson& field) { return field.IsNull() ? 0.0 : field.Number(); }

json ToJson(const GrowthStep& step) {
  const auto judged = [&](double value) { return step.psnr > 0 ? json(value) : json(); };
  return {{"iteration", step.iteration},
          {"seconds", step.seconds},
          {"vertices", step.vertices},
          {"tets", step.tets},
          {"empty_tets", step.empty_tets != kNotCounted ? json(step.empty_tets) : json()},
          {"peak_rss_bytes", step.peak_rss_bytes},
          {"psnr", judged(step.psnr)},
          {"gain", judged(step.gain)},
          {"gain_standard_error", judged(step.gain_standard_error)},
          {"degenerate_tets", step.degenerate_tets},
          {"decision", kDecisions[size_t(step.decision)]},
          {"reason", ReasonOf(step)}};
}

}  // namespace

std::string ReasonOf(const GrowthStep& step) {
  switch (step.decision) {
    case GrowthDecision::kRefine:
      return step.psnr > 0 ? "refined" : "refined: no pictures were kept that could judge";
    case GrowthDecision::kReturn:
      return "returned to the mesh before, because the judging pictures lost";
    case GrowthDecision::kFineEnough:
      return "fine enough: the judging pictures gained no more than the standard error";
    case GrowthDecision::kEnd:
      return "the mesh of the result";
    case GrowthDecision::kBudget:
      return "stayed: a refined mesh would exceed the budget";
    case GrowthDecision::kMatched:
      return "fine enough: the judging pictures are matched";
    case GrowthDecision::kCoarsen:
      return "coarsened to this mesh: the judging pictures are matched, or lost no more than the "
             "standard error";
    case GrowthDecision::kTooCoarse:
      return "tried and taken back: this coarser mesh lost more than the standard error";
    case GrowthDecision::kTooFine:
      return "tried and taken back: this finer mesh gained no more than the standard error";
    case GrowthDecision::kTooLate:
      return "stayed: too little of the run was left to learn a finer mesh";
  }
  return "";
}

void WriteMeshGrowth(const std::filesystem::path& path, const std::vector<GrowthStep>& steps) {
  json rows = json::array();
  for (const GrowthStep& step : steps) rows.push_back(ToJson(step));
  WriteJson(path, {{"schema", 1}, {"steps", std::move(rows)}});
}

std::vector<GrowthStep> ParseMeshGrowth(const json& value, const std::string& name) {
  const CheckedJson file(value, name);
  file.Field("schema").IntegerIn(1, 1);
  const CheckedJson rows = file.Field("steps");
  std::vector<GrowthStep> steps;
  for (size_t i = 0; i < rows.Size(); ++i) {
    const CheckedJson row = rows.Item(i);
    steps.push_back({ReadCount(row.Field("iteration")), row.Field("seconds").NumberIn(0, kLargest),
                     ReadCount(row.Field("vertices")), ReadCount(row.Field("tets")),
                     row.Has("empty_tets") ? CountOrNone(row.Field("empty_tets")) : kNotCounted,
                     ReadCount(row.Field("peak_rss_bytes")), NumberOrZero(row.Field("psnr")),
                     NumberOrZero(row.Field("gain")),
                     NumberOrZero(row.Field("gain_standard_error")),
                     ReadDecision(row.Field("decision")),
                     row.Has("degenerate_tets") ? ReadCount(row.Field("degenerate_tets")) : 0});
  }
  return steps;
}

std::vector<GrowthStep> ReadMeshGrowth(const std::filesystem::path& path) {
  return Advising("run tetrec-optimize again",
                  [&] { return ParseMeshGrowth(ReadJson(path), path.string()); });
}

}  // namespace tetrec
