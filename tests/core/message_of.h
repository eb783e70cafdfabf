// The message of an exception.
#pragma once

#include <gtest/gtest.h>

#include <exception>
#include <string>

namespace tetrec {

// The message of the exception of type E that `action` throws; a test failure if it throws none.
template <class E, class Action>
std::string MessageOf(Action&& action) {
  try {
    action();
  } catch (const E& error) {
    return error.what();
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another exception: " << error.what();
    return "";
  }
  ADD_FAILURE() << "nothing was thrown";
  return "";
}

}  // namespace tetrec
