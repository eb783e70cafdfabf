// The photos that a texture is made from, and how much each of their pixels is worth.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "image/image.h"
#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr int kFullTrust = 3;  // steps of a pixel from what is not trusted at all

// A photo, and what it shows of the surface.
struct TexturePhoto {
  Camera camera;
  Rigid3 cam_from_world;
  Image image;                        // RGB, or RGBA with straight alpha
  glm::dvec3 gain{1.0}, offset{0.0};  // photo = gain color + offset [display sRGB]
  bool alpha_is_opacity = false;      // as of the scene: otherwise alpha marks pixels that count
  std::vector<float> depth;           // (height x width) of the surface, infinite where none is
  std::vector<uint8_t> trust;         // (height x width) from 0 to kFullTrust, see FindTrust
  std::vector<bool> hidden;           // empty, or (height x width) what hides the surface
  std::vector<bool> shows;            // for each vertex, whether it or a triangle of it is seen

  size_t Index(int x, int y) const { return size_t(y) * size_t(camera.width) + size_t(x); }
  // The colour [display sRGB, 0 to 1] of 8-bit channels, without the exposure of this photo.
  glm::dvec3 WithoutExposure(const glm::dvec3& rgb) const { return (rgb / 255.0 - offset) / gain; }
  glm::dvec3 ColorOf(int x, int y) const {
    const uint8_t* rgb = image.At(x, y);
    return WithoutExposure({rgb[0], rgb[1], rgb[2]});
  }
  // True if a point is in the frame and at most 3 footprints farther away than the surface that the
  // pixels around it show.
  bool ShowsPoint(const glm::dvec3& in_cam) const;
  // Returns true if a pixel shows nothing but the scene, and nothing that hides the surface.
  bool Counts(int x, int y) const;
  // True if a pixel shows what hides the surface.
  bool Hides(int x, int y) const { return !hidden.empty() && hidden[Index(x, y)]; }
  // Length on a surface facing the camera that one pixel covers at this depth.
  double Footprint(double depth_in_cam) const { return depth_in_cam / camera.fx; }
};

// Fills in what a photo shows of the surface: depth, trust and vertices. Trust rises from 0 at the
// photo's border, at pixels that do not count, and where the surface's depth jumps, by 1 with each
// pixel, because near an outline the surface and the photo rarely agree on what is in front.
void FindTrust(const TriangleMesh& mesh_in_world, TexturePhoto& photo);
// The same for several photos, in parallel. `hiding_in_world` is not part of the surface, but in
// front of some of it.
void FindTrust(const TriangleMesh& mesh_in_world, std::span<TexturePhoto> photos,
               const TriangleMesh& hiding_in_world = {});

// The training photos of the scene, seen from the cameras that the run corrected and with the
// exposures that it estimated, if the field's folder has them; without what they show of a surface.
// Throws DataError.
std::vector<TexturePhoto> ReadTexturePhotos(const std::filesystem::path& scene_folder,
                                            const std::filesystem::path& field_folder);

}  // namespace tetrec
