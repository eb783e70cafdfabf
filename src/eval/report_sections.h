// The sections of the report, each as HTML.
#pragma once

#include "eval/report.h"

#include <cstddef>
#include <string>

namespace tetrec::report {

std::string Header(const ReportContent& content);
std::string Cards(const ReportContent& content);
std::string KeyNumbers(const ReportContent& content);

// The best, the median and the worst view.
std::string ComparisonSection(const ReportContent& content);
std::string ViewScores(const ReportContent& content);
// As many views as fit into `most_bytes`; the last one may need some more.
std::string Views(const ReportContent& content, size_t most_bytes);

// Empty if exposures were not estimated, or cameras not corrected.
std::string Exposures(const ReportContent& content);
std::string Cameras(const ReportContent& content);

std::string Surface(const ReportContent& content);

std::string Convergence(const ReportContent& content);
std::string Growth(const ReportContent& content);  // empty if it is unknown
std::string Stages(const RunFacts& run);
std::string Warnings(const ReportContent& content);
std::string Commands(const RunFacts& run);

}  // namespace tetrec::report
