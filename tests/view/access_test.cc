// Who may talk to the viewer.
#include "view/access.h"

#include <gtest/gtest.h>

#include <set>

namespace tetrec {
namespace {

TEST(Access, TokensAre32HexadecimalDigitsAndNeverTheSame) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) {
    const std::string token = MakeToken();
    EXPECT_EQ(token.size(), 32u);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), token.npos) << token;
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 100u);
}

TEST(Access, OnlyPathsBelowTheTokenHaveIt) {
  EXPECT_TRUE(HasToken("/abcd/", "abcd"));
  EXPECT_TRUE(HasToken("/abcd/picture", "abcd"));
  for (const char* path : {"", "/", "/abcd", "/abce/", "/abcde/", "abcd/", "//abcd/", "/abc/",
                           "/x/abcd/", "/ABCD/", "/?token=abcd"}) {
    EXPECT_FALSE(HasToken(path, "abcd")) << path;
  }
  EXPECT_FALSE(HasToken("//", "")) << "an empty token opens nothing";
}

TEST(Access, OnlyLoopbackHostsWithThePortAreServed) {
  EXPECT_TRUE(IsLoopbackHost("127.0.0.1:8123", 8123));
  EXPECT_TRUE(IsLoopbackHost("localhost:8123", 8123));
  for (const char* host : {"", "127.0.0.1", "localhost", "127.0.0.1:81", "evil.example:8123",
                           "127.0.0.1:8123.evil.example", "127.0.0.1.evil.example:8123",
                           "localhost:8123 ", "0.0.0.0:8123"}) {
    EXPECT_FALSE(IsLoopbackHost(host, 8123)) << host;
  }
}

TEST(Access, ThePortOfHttpMayBeLeftOut) {
  for (const char* host : {"127.0.0.1", "localhost", "127.0.0.1:80", "localhost:80"}) {
    EXPECT_TRUE(IsLoopbackHost(host, 80)) << host;
  }
  for (const char* host : {"", "evil.example", "127.0.0.1:8080", "127.0.0.1:"}) {
    EXPECT_FALSE(IsLoopbackHost(host, 80)) << host;
  }
}

}  // namespace
}  // namespace tetrec
