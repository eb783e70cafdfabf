// Pieces of self-contained HTML: escaped text and inlined images.
#pragma once

#include "image/image.h"

#include <string>

namespace tetrec {

// Text for element content and quoted attributes: & < > " ' are escaped, control characters other
// than newline and tab become U+FFFD.
std::string EscapeHtml(const std::string& text);

// Data URIs for src attributes, e.g. "data:image/jpeg;base64,...".
std::string JpegDataUri(const Image& rgb, int quality);
std::string SvgDataUri(const std::string& svg);

// The source by which a content security policy allows exactly this inline script:
// "'sha256-...'" (W3C, Content Security Policy Level 3, section 8.3).
std::string ScriptSource(const std::string& script);

// Scales down until the longer side is at most `max_size` px; smaller images remain unchanged.
Image FitInto(const Image& image, int max_size);

}  // namespace tetrec
