// HTML and CSV for the stability test.
#include "stability/page.h"

#include "eval/html.h"
#include "eval/report_style.h"

#include <fmt/format.h>

namespace tetrec {

std::string HtmlPage(const std::string& title, const std::string& body) {
  constexpr const char* kOwnStyle =
      ":root{--breaks:#c00000}"
      "@media screen and (prefers-color-scheme:dark){:root{--breaks:#ff8a80}}"
      ".bar-of-loss{display:inline-block;height:.7em;border-radius:2px;background:var(--accent)}"
      ".breaks{color:var(--breaks);font-weight:600}.faint{color:var(--soft)}"
      ".plots{display:grid;grid-template-columns:repeat(3,1fr);gap:8px}";
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">"
      "<title>{0}</title><style>{1}{2}</style></head><body><main>"
      "<p class=\"eyebrow\">Tetrec stability</p><h1>{0}</h1>{3}"
      "<footer>Written by tetrec-stability.</footer></main></body></html>\n",
      EscapeHtml(title), kReportStyle, kOwnStyle, body);
}

std::string HtmlRow(const std::vector<std::string>& cells, size_t texts, const char* tag) {
  std::string row = "<tr>";
  for (size_t i = 0; i < cells.size(); ++i) {
    row += fmt::format("<{0}{1}>{2}</{0}>", tag, i < texts ? "" : " class=\"n\"", cells[i]);
  }
  return row + "</tr>\n";
}

std::string Decibel(const std::optional<double>& value) {
  return value ? fmt::format("{:.2f}", *value) : "–";
}

}  // namespace tetrec
