// Tokens and host names.
#include "view/access.h"

#include "core/error.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <array>
#include <cstdint>

namespace tetrec {

std::string MakeToken() {
  std::array<uint8_t, 16> bytes;
  if (getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size())) {
    throw EnvironmentError("the system gives no random numbers (getrandom)");
  }
  std::string token;
  for (const uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool IsLoopbackHost(const std::string& host, int port) {
  // Browsers leave out the port of HTTP.
  if (port == 80 && (host == "127.0.0.1" || host == "localhost")) return true;
  return host == fmt::format("127.0.0.1:{}", port) || host == fmt::format("localhost:{}", port);
}

bool HasToken(const std::string& path, const std::string& token) {
  if (token.empty() || path.size() < token.size() + 2) return false;
  int difference = (path.front() ^ '/') | (path[token.size() + 1] ^ '/');
  for (size_t i = 0; i < token.size(); ++i) difference |= path[i + 1] ^ token[i];
  return difference == 0;
}

}  // namespace tetrec
