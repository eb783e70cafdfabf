// Who may talk to the viewer: whoever knows the address with its token, on this machine.
#pragma once

#include <string>

namespace tetrec {

// 128 random bits of the system as 32 hexadecimal digits. Throws EnvironmentError.
std::string MakeToken();

// True for the names under which a browser on this machine reaches the server: 127.0.0.1 and
// localhost, with the port, which may be left out if it is 80. Any other Host header is that of a
// foreign page whose name has been pointed at this machine (DNS rebinding).
bool IsLoopbackHost(const std::string& host, int port);

// True if the path of a request is "/TOKEN/" or is below it. The time taken does not depend on how
// much of the token is right.
bool HasToken(const std::string& path, const std::string& token);

}  // namespace tetrec
