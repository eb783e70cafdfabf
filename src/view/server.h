// The viewer: serves a page, and the pictures it asks for, to browsers on this machine.
#pragma once

#include "render/renderer.h"

#include <filesystem>

namespace tetrec {

struct ViewOptions {
  int port = 0;  // of the loopback address; 0: any that is free
  RendererOptions renderer;

  void Check() const;  // throws UsageError naming the option and its value
};

// Prints the address, which contains a random token, and serves until the user stops it: then it
// throws Interrupted. Only 127.0.0.1 is listened on. Requests without the token, and those for
// another host, are answered 403. Throws as ViewSession does, and EnvironmentError if the port is
// taken.
void RunViewer(const ViewOptions& options, const std::filesystem::path& run);

}  // namespace tetrec
