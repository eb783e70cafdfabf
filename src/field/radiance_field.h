// The radiance field: density and colour on the vertices of a tet mesh, linear inside each tet.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct RadianceField {
  TetMesh mesh;
  std::vector<float> density;         // (V) sigma >= 0 [1 / world unit]
  std::vector<glm::vec3> color_srgb;  // (V) display sRGB, may leave [0, 1] a little
};

// Throws DataError naming the first offence: sizes, negative or non-finite values.
void CheckField(const RadianceField& field);

// Own format, little endian: "TETRECF1", the mesh as in WriteTetMesh, density f32 x V, colour f32 x
// 3 V.
void WriteField(const std::filesystem::path& path, const RadianceField& field);
RadianceField ReadField(const std::filesystem::path& path);
RadianceField ParseField(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
