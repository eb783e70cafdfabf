// What the pages and tables of the stability test share.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// A self-contained HTML page in the style of the report; `body` is HTML.
std::string HtmlPage(const std::string& title, const std::string& body);

// A row of an HTML table. Cells are HTML; the first `texts` are texts, the others numbers.
std::string HtmlRow(const std::vector<std::string>& cells, size_t texts, const char* tag = "td");

// The number of a table, or a dash where there is none.
std::string Decibel(const std::optional<double>& value);

}  // namespace tetrec
