// The lens of a frame of transforms JSON files.
#pragma once

#include "core/checked_json.h"
#include "import/dataset.h"

#include <optional>
#include <string>

namespace tetrec::internal {

// The fields of a frame; those that it lacks are taken from the top level of the file.
struct FrameFields {
  CheckedJson frame, file;

  bool Has(const std::string& name) const { return SourceOf(name).Has(name); }
  CheckedJson operator[](const std::string& name) const { return SourceOf(name).Field(name); }
  // A coefficient of the lens distortion, if specified. A list takes precedence over single
  // coefficients, as in nerfstudio; the file's list does not apply to a frame that has
  // coefficients.
  std::optional<CheckedJson> FindCoefficient(const std::string& name) const;
  double Coefficient(const std::string& name) const;  // 0 if not specified

 private:
  // A frame that specifies its focal length in any way ignores all of the file's.
  const CheckedJson& SourceOf(const std::string& name) const;
};

// Whether this field describes a lens, be it read or refused.
bool IsLensField(const std::string& name);

// Requires w and h. Throws DataError, which names the field.
Lens ReadLens(const FrameFields& fields);
// For files that do not specify the images' size and so nothing in pixels and no distortion. Throws
// DataError like ReadLens.
void ReadFieldOfView(const FrameFields& fields, PosedPicture& picture);

}  // namespace tetrec::internal
