// Pictures of the surface itself from the cameras of the rendered views, against the photos.
#pragma once

#include "image/image.h"
#include "mesh/triangle_mesh.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// PSNR over the pixels that the surface fills (and that count, in scenes with masks) [dB]. The
// surface is drawn with 4 x 4 rays per pixel.
struct SurfaceViewScore {
  std::string name;              // of the view
  double psnr = 0;               // of the surface
  double vertex_color_psnr = 0;  // without the texture
  double field_psnr = 0;         // of the field's rendering, over the same pixels
  double covered = 0;            // share of the pixels that count
};
struct SurfacePictures {
  bool textured = false;
  std::vector<SurfaceViewScore> views;  // those that show any of the surface
  std::vector<std::string> views_without_surface;
};

// Nothing if the mesh has no colours. Throws DataError if an image cannot be read.
std::optional<SurfacePictures> ScoreSurfacePictures(const TriangleMesh& mesh_in_world,
                                                    const Image& texture, const Scene& scene,
                                                    const RenderedViews& rendered);

// {"textured", "psnr", "vertex_color_psnr", "field_psnr", "covered": means over the views, or null
// if none shows the surface, "views": [{"name", ...}], "views_without_surface": [names]}
nlohmann::json SurfacePicturesJson(const SurfacePictures& pictures);

}  // namespace tetrec
