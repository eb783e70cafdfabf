// A picture that the viewer's page asks for.
#pragma once

#include "core/words.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "render/renderer.h"
#include "scene/scene.h"

#include <map>
#include <optional>
#include <string>

namespace tetrec {

enum class PictureMode {
  kColor,
  kDepth,    // where half of the light is lost
  kNormals,  // of that depth
  kTets,     // the tets there, coloured by their size
  kSlice,    // a plane across the view
  kPhoto,    // of a view's camera
  kError,    // photo against rendering, of a view's camera
};
template <>
inline constexpr auto kWords<PictureMode> =
    std::to_array<Word<PictureMode>>({{PictureMode::kColor, "color"},
                                      {PictureMode::kDepth, "depth"},
                                      {PictureMode::kNormals, "normals"},
                                      {PictureMode::kTets, "tets"},
                                      {PictureMode::kSlice, "slice"},
                                      {PictureMode::kPhoto, "photo"},
                                      {PictureMode::kError, "error"}});

inline constexpr int kSmallestPicture_px = 8, kLargestPicture_px = 4096;

struct PictureRequest {
  PictureMode mode = PictureMode::kColor;
  // Asked for while the camera moves: it goes before pictures that are not.
  bool is_draft = false;
  std::optional<int> view;  // index of the scene's view whose camera takes the picture
  double slice_depth = 1;   // of the plane of kSlice, along z of the camera [world units]
  RenderView from;          // where the picture is taken
};

// From the query of an address: mode, w and h [px], draft (0 or 1), slice, and either view (the
// picture then has the shape of the view's image and fits into w x h) or eye, forward and up (three
// world coordinates each) with fov (of the height) [degrees]. Throws UsageError naming the
// parameter and its value.
PictureRequest ParsePictureRequest(const std::map<std::string, std::string>& query,
                                   const Scene& scene);

}  // namespace tetrec
