// How long the device spends in each kernel, by timestamps between commands.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace tetrec {

struct KernelTimes {
  struct Entry {
    uint64_t calls = 0;
    double seconds = 0;
  };
  std::map<std::string, Entry> by_name;
  uint64_t untimed_calls = 0;  // that found no room in the query pool
};

}  // namespace tetrec
