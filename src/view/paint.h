// Pictures of a field that the viewer shows.
#pragma once

#include "image/image.h"
#include "render/training_renderer.h"
#include "view/newest_field.h"
#include "view/picture_request.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>

namespace tetrec {

// A field and its renderer.
struct ShownField {
  RadianceField field;
  std::unique_ptr<TrainingRenderer> renderer;
  std::vector<PhotoExposure> exposures;  // as of FieldContent
  // The 2nd and 98th percentile of the tets' sizes (the cube root of the volume) [world units].
  double small_tet = 0, large_tet = 1;
};

ShownField MakeShownField(FieldContent content, RendererOptions options);

// What photos are compared with: the scene and its folder.
struct ShownScene {
  std::filesystem::path folder;
  Scene scene;
};

// Returns RGB. The picture is made in bands of rows. After each band, and once a photo is read,
// `give_up` is asked whether something else is more urgent; if so, no picture is returned. A photo
// that is shown larger than it is gets interpolated, and so does its error, which is that of its
// own pixels, between the photo and the field as the photo's exposure shows it. In meshes with many
// tets that are inside out a few pixels of kTets and kSlice may stay grey.
std::optional<Image> Paint(ShownField& shown, const ShownScene& scene,
                           const PictureRequest& request, const std::function<bool()>& give_up);

}  // namespace tetrec
