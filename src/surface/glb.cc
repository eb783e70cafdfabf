// Triangle meshes as binary glTF (Khronos, glTF 2.0 Specification, sections 3 and 4).
#include "surface/glb.h"

#include "core/error.h"
#include "core/file.h"
#include "image/srgb.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <tuple>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;          // component types
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;      // targets of buffer views
constexpr int kLinear = 9729, kLinearMipmaps = 9987, kClamp = 33071;  // samplers
constexpr int kJpegQuality = 92;

struct Buffer {
  ByteWriter bytes;
  json views = json::array(), accessors = json::array();

  // Appends values, whose size is a multiple of 4 bytes, and describes them; returns the index of
  // the accessor.
  template <class T>
  int Add(std::span<const T> values, int target, json accessor) {
    static_assert(sizeof(T) % 4 == 0);
    const int index = int(views.size());
    views.push_back({{"buffer", 0},
                     {"byteOffset", bytes.bytes().size()},
                     {"byteLength", values.size_bytes()},
                     {"target", target}});
    accessor["bufferView"] = index;
    accessors.push_back(std::move(accessor));
    bytes.WriteArray(values);
    return index;
  }
};

// Appends an image file; returns the index of its view.
int AddImage(Buffer& buffer, const std::vector<uint8_t>& file) {
  buffer.views.push_back(
      {{"buffer", 0}, {"byteOffset", buffer.bytes.bytes().size()}, {"byteLength", file.size()}});
  buffer.bytes.WriteArray(std::span<const uint8_t>(file));
  while (buffer.bytes.bytes().size() % 4 != 0) buffer.bytes.Write(uint8_t{0});
  return int(buffer.views.size()) - 1;
}

// A vertex of glTF has one texture coordinate: vertices at the borders of charts are doubled.
struct SplitMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec2> coordinates;  // to the right and down, as in glTF
  std::vector<glm::uvec3> triangles;
};
SplitMesh SplitByCoordinates(const TriangleMesh& mesh) {
  SplitMesh split;
  std::map<std::tuple<uint32_t, float, float>, uint32_t> known;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    glm::uvec3& triangle = split.triangles.emplace_back();
    for (int k = 0; k < 3; ++k) {
      const uint32_t vertex = mesh.triangles[i][k];
      const glm::vec2 p = mesh.corner_coordinates[i][size_t(k)];
      const auto [found, is_new] =
          known.emplace(std::tuple(vertex, p.x, p.y), uint32_t(split.positions.size()));
      if (is_new) {
        split.positions.push_back(mesh.positions[vertex]);
        split.coordinates.emplace_back(p.x, 1 - p.y);
      }
      triangle[k] = found->second;
    }
  }
  return split;
}

json Vector(const glm::vec3& v) { return {v.x, v.y, v.z}; }

int AddPositions(Buffer& buffer, const std::vector<glm::vec3>& positions) {
  glm::vec3 min(std::numeric_limits<float>::infinity()), max = -min;
  for (const glm::vec3& p : positions) {
    min = glm::min(min, p);
    max = glm::max(max, p);
  }
  return buffer.Add<glm::vec3>(positions, kArrayBuffer,
                               {{"componentType", kFloat},
                                {"count", positions.size()},
                                {"type", "VEC3"},
                                {"min", Vector(min)},
                                {"max", Vector(max)}});
}

// glTF's colours are linear: 8 bits would show steps in the dark, so there are 16.
int AddColors(Buffer& buffer, const std::vector<std::array<uint8_t, 3>>& colors_srgb) {
  std::vector<std::array<uint16_t, 4>> linear;
  linear.reserve(colors_srgb.size());
  for (const auto& color : colors_srgb) {
    auto& row = linear.emplace_back();
    for (size_t c = 0; c < 3; ++c) {
      row[c] = uint16_t(std::lround(65535 * LinearFromSrgb(color[c] / 255.0)));
    }
    row[3] = 65535;
  }
  return buffer.Add<std::array<uint16_t, 4>>(linear, kArrayBuffer,
                                             {{"componentType", kUint16},
                                              {"normalized", true},
                                              {"count", linear.size()},
                                              {"type", "VEC4"}});
}

// Lit, for viewers that do not know the extension, the material is matt. The surface is open where
// no camera saw it, so that its back shows.
json MattMaterial() {
  return {{"doubleSided", true},
          {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
          {"extensions", {{"KHR_materials_unlit", json::object()}}}};
}

int AddTriangles(Buffer& buffer, const std::vector<glm::uvec3>& triangles) {
  return buffer.Add<glm::uvec3>(
      triangles, kElementArrayBuffer,
      {{"componentType", kUint32}, {"count", 3 * triangles.size()}, {"type", "SCALAR"}});
}

// The primitive of a mesh with vertex colours.
json AddColored(Buffer& buffer, const TriangleMesh& mesh) {
  json attributes = {{"POSITION", AddPositions(buffer, mesh.positions)}};
  if (!mesh.colors_srgb.empty()) attributes["COLOR_0"] = AddColors(buffer, mesh.colors_srgb);
  return {{"attributes", attributes},
          {"indices", AddTriangles(buffer, mesh.triangles)},
          {"material", 0}};
}

// The primitive of a mesh with a texture, which viewers would multiply by vertex colours. Adds the
// texture and the material to `document`.
json AddTextured(Buffer& buffer, const TriangleMesh& mesh, const Image& texture, json& document) {
  const SplitMesh split = SplitByCoordinates(mesh);
  const json attributes = {
      {"POSITION", AddPositions(buffer, split.positions)},
      {"TEXCOORD_0",
       buffer.Add<glm::vec2>(
           split.coordinates, kArrayBuffer,
           {{"componentType", kFloat}, {"count", split.coordinates.size()}, {"type", "VEC2"}})}};
  const int indices = AddTriangles(buffer, split.triangles);
  document["images"] =
      json::array({{{"bufferView", AddImage(buffer, EncodeJpeg(texture, kJpegQuality))},
                    {"mimeType", "image/jpeg"}}});
  document["samplers"] = json::array({{{"magFilter", kLinear},
                                       {"minFilter", kLinearMipmaps},
                                       {"wrapS", kClamp},
                                       {"wrapT", kClamp}}});
  document["textures"] = json::array({{{"source", 0}, {"sampler", 0}}});
  document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  return {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
}

// The length is a multiple of 4, filled up with `padding`.
void AppendChunk(ByteWriter& file, const char (&type)[5], std::string_view content, char padding) {
  const std::string fill((4 - content.size() % 4) % 4, padding);
  file.Write(uint32_t(content.size() + fill.size()));
  file.WriteArray(std::span<const char>(type, 4));
  file.WriteArray(std::span<const char>(content));
  file.WriteArray(std::span<const char>(fill));
}

}  // namespace

void WriteTriangleMeshGlb(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const Image& texture) {
  TETREC_CHECK(!mesh.triangles.empty(), "glTF has no accessors of no elements");
  TETREC_CHECK(texture.pixels.empty() || !mesh.corner_coordinates.empty(), "texture of a mesh");
  Buffer buffer;
  const json scene = {{"nodes", json::array({0})}}, node = {{"mesh", 0}};
  json document = {{"asset", {{"version", "2.0"}, {"generator", "Tetrec"}}},
                   {"extensionsUsed", json::array({"KHR_materials_unlit"})},
                   {"scene", 0},
                   {"scenes", json::array({scene})},
                   {"nodes", json::array({node})},
                   {"materials", json::array({MattMaterial()})}};
  const json primitive = texture.pixels.empty() ? AddColored(buffer, mesh)
                                                : AddTextured(buffer, mesh, texture, document);
  const json shape = {{"primitives", json::array({primitive})}};
  const auto& binary = buffer.bytes.bytes();
  document["meshes"] = json::array({shape});
  document["buffers"] = json::array({{{"byteLength", binary.size()}}});
  document["bufferViews"] = buffer.views;
  document["accessors"] = buffer.accessors;
  const std::string text = document.dump();
  constexpr size_t kHeader = 12, kChunkHeaders = 16;
  const size_t length = kHeader + kChunkHeaders + (text.size() + 3) / 4 * 4 + binary.size();
  if (length > std::numeric_limits<uint32_t>::max()) {
    throw DataError(
        fmt::format("a GLB file ends at 4 GiB, and {} would have {} bytes; simplify "
                    "the surface, or leave this format out",
                    path.filename().string(), length));
  }
  ByteWriter file;
  file.WriteArray(std::span<const char>("glTF", 4));
  file.Write(uint32_t{2});
  file.Write(uint32_t(length));
  AppendChunk(file, "JSON", text, ' ');
  AppendChunk(file, "BIN\0", {reinterpret_cast<const char*>(binary.data()), binary.size()}, '\0');
  WriteBytes(path, file.bytes());
}

}  // namespace tetrec
