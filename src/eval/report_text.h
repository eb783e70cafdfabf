// What the report's sections are written with: numbers in words, rows, and pictures.
#pragma once

#include "image/image.h"

#include <nlohmann/json.hpp>

#include <cstddef>
#include <cstdint>
#include <string>

namespace tetrec::report {

std::string E(const std::string& text);  // EscapeHtml

// An inlined JPEG.
std::string Picture(const Image& image, int quality, const std::string& alt);

// May be infinite.
std::string Decibel(double psnr);

// A number of metrics.json as text; a dash if it is null.
std::string NumberOr(const nlohmann::json& value, const char* format, const char* otherwise = "–");
std::string CountOr(const nlohmann::json& value);

// "1.5 MiB"; a dash for 0.
std::string Bytes(uint64_t bytes);

// "4.2 s", "4:58 min", "1:02:03 h"
std::string Duration(double seconds);

// "1 view", "5 views"
std::string Plural(size_t count, const std::string& noun);

// A row of a table of measures: name, value, and how it was measured.
std::string Row(const std::string& name, const std::string& value, const std::string& protocol);

}  // namespace tetrec::report
