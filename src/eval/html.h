// Pieces of self-contained HTML: escaped text and inlined pictures.
#pragma once

#include "scene/image.h"

#include <string>

namespace tetrec {

// Text for element content and quoted attributes: & < > " ' are escaped, control characters (but
// newline and tab) become U+FFFD.
std::string EscapeHtml(const std::string& text);

// "data:image/jpeg;base64,..." and the like, for src attributes.
std::string JpegDataUri(const Image& rgb, int quality);
std::string SvgDataUri(const std::string& svg);

// Scaled down so that the longer side is at most `max_size` px; smaller pictures stay as they are.
Image FitInto(const Image& image, int max_size);

}  // namespace tetrec
