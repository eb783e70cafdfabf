// Cells of CSV files that spreadsheets read.
#pragma once

#include <string>

namespace tetrec {

// The text as a cell, quoted if it must be. Spreadsheets take a text that starts with one of =+-@
// for a formula, unless an apostrophe precedes it.
inline std::string CsvCell(std::string text) {
  if (text.find_first_of("=+-@") == 0) text.insert(0, 1, '\'');
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace tetrec
