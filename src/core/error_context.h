// Errors of data gain what the function that threw them did not know.
#pragma once

#include "core/error.h"

#include <string>

namespace tetrec {

// Calls `check`, and puts the name of the file in front of its DataErrors.
template <class Check>
auto NamingFile(const std::string& name, const Check& check) {
  try {
    return check();
  } catch (const DataError& error) {
    throw DataError(name + ": " + error.what());
  }
}

// Calls `read`, and ends its DataErrors with what to do: "run tetrec-optimize again".
template <class Read>
auto Advising(const std::string& remedy, const Read& read) {
  try {
    return read();
  } catch (const DataError& error) {
    throw DataError(error.what() + ("; " + remedy));
  }
}

}  // namespace tetrec
