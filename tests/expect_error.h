// Checks of the kind and the wording of errors.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace tetrec {

// `body` must throw exactly this kind, with one line that contains each of `parts`.
template <class Kind, class Body>
void ExpectError(const Body& body, std::initializer_list<std::string> parts) {
  try {
    body();
  } catch (const Kind& error) {
    const std::string message = error.what();
    for (const std::string& part : parts) EXPECT_THAT(message, ::testing::HasSubstr(part));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "another kind of error: " << error.what();
    return;
  }
  ADD_FAILURE() << "no error; expected one about " << (parts.size() ? *parts.begin() : "anything");
}

}  // namespace tetrec
