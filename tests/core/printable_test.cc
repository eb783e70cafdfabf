// Names from outside, as they are shown and stored.
#include "core/printable.h"

#include "core/checked_json.h"

#include <gtest/gtest.h>

#include <map>

namespace tetrec {
namespace {

TEST(Printable, LeavesTextAloneAndEscapesTheRest) {
  for (const char* text :
       {"", "a b.jpg", "Größe.png", "写真/日.jpg", "\xf0\x9f\x8c\xb3", "back\\slash"}) {
    EXPECT_EQ(Printable(text), text);
    EXPECT_EQ(StaysInside(text), *text != 0) << text;
  }
  const std::map<std::string, std::string> escaped = {
      {"a\nb", "a\\x0ab"},
      {"\x1b[2J", "\\x1b[2J"},
      {"a\x7f", "a\\x7f"},
      {"Gr\xf6\xdf"
       "e",
       "Gr\\xf6\\xdfe"},  // Latin-1
      {"\xc2\x9b"
       "2J",
       "\\xc2\\x9b2J"},                              // a control character beyond ASCII
      {"\xc0\xaf", "\\xc0\\xaf"},                    // "/" in two bytes
      {"\xe0\x80\xaf", "\\xe0\\x80\\xaf"},           // and in three
      {"\xed\xa0\x80", "\\xed\\xa0\\x80"},           // half of a pair of UTF-16
      {"\xf4\x90\x80\x80", "\\xf4\\x90\\x80\\x80"},  // beyond Unicode
      {"a\xe5\x86", "a\\xe5\\x86"}};                 // cut off
  for (const auto& [text, shown] : escaped) {
    EXPECT_EQ(Printable(text), shown);
    EXPECT_FALSE(StaysInside(text)) << shown;
  }
}

}  // namespace
}  // namespace tetrec
