// The texture of a surface, baked from the training photos.
#pragma once

#include "core/stage.h"
#include "image/image.h"
#include "mesh/triangle_mesh.h"
#include "surface/texture_photos.h"

#include <span>
#include <string>

namespace tetrec {

inline constexpr int kMinTextureSize = 64, kMaxTextureSize = 8192;

struct TextureChoice {
  bool wanted = true;
  int size = 0;  // side of the square texture [texels]; 0: as the photos' pixels demand
};
// "auto", "off" or a size. Throws UsageError.
TextureChoice ParseTextureChoice(const std::string& text);

// The mesh with texture coordinates, and its texture.
struct TexturedMesh {
  TriangleMesh mesh;
  Image texture;  // RGB; empty without a texture
};
// Counts and logs by `stage`. `mesh_in_world` has vertex colours, and at least one triangle;
// `hiding_in_world` is not textured, but hides what is behind it from photos. `moves` has the
// meaning that it has in FitTexture, and must be 0 if something hides the mesh. Throws UsageError
// if there are more charts than a texture has room for.
TexturedMesh MakeTexture(TriangleMesh mesh_in_world, const TriangleMesh& hiding_in_world,
                         std::span<TexturePhoto> photos, const TextureChoice& choice, int moves,
                         Stage& stage);

// Returns the mesh as MakeTexture moves it, without the texture.
TriangleMesh AlignByTexture(TriangleMesh mesh_in_world, std::span<TexturePhoto> photos,
                            const TextureChoice& choice, int moves, Stage& stage);

}  // namespace tetrec
