// The lens of a frame of transforms JSON files.
#pragma once

#include "scene/checked_json.h"
#include "scene/dataset.h"

#include <optional>
#include <string>

namespace tetrec::internal {

// A frame, with the fields that it does not have itself taken from the file.
struct FrameFields {
  CheckedJson frame, file;

  bool Has(const std::string& name) const { return TellerOf(name).Has(name); }
  CheckedJson operator[](const std::string& name) const { return TellerOf(name).Field(name); }
  // Of the lens distortion; none where it is not told. A list comes before single ones, as in
  // nerfstudio; the file's list does not count for a frame with words of its own.
  std::optional<CheckedJson> FindCoefficient(const std::string& name) const;
  double Coefficient(const std::string& name) const;  // 0 where it is not told

 private:
  // A frame that tells its focal length in any way goes by its own words alone.
  const CheckedJson& TellerOf(const std::string& name) const;
};

// Whether lenses are told by this field, be it read or refused.
bool IsLensField(const std::string& name);

// Of fields with w and h. Throws DataError, which names the field.
ColmapCamera ReadLens(const FrameFields& fields);
// Of a file that does not tell the pictures' size: nothing in pixels, no distortion.
void ReadFieldOfView(const FrameFields& fields, PosedPicture& picture);

}  // namespace tetrec::internal
