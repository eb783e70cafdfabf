// Triangle meshes as binary glTF (Khronos, glTF 2.0 Specification, sections 3 and 4).
#include "surface/glb.h"

#include "core/error.h"
#include "core/file.h"
#include "image/srgb.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <span>
#include <string>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;      // component types
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;  // targets of buffer views

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

// The length is a multiple of 4, filled up with `padding`.
void AppendChunk(ByteWriter& file, const char (&type)[5], std::string_view content, char padding) {
  const std::string fill((4 - content.size() % 4) % 4, padding);
  file.Write(uint32_t(content.size() + fill.size()));
  file.WriteArray(std::span<const char>(type, 4));
  file.WriteArray(std::span<const char>(content));
  file.WriteArray(std::span<const char>(fill));
}

}  // namespace

void WriteTriangleMeshGlb(const std::filesystem::path& path, const TriangleMesh& mesh) {
  TETREC_CHECK(!mesh.triangles.empty(), "glTF has no accessors of no elements");
  Buffer buffer;
  json attributes = {{"POSITION", AddPositions(buffer, mesh.positions)}};
  if (!mesh.colors_srgb.empty()) attributes["COLOR_0"] = AddColors(buffer, mesh.colors_srgb);
  const int indices = buffer.Add<glm::uvec3>(
      mesh.triangles, kElementArrayBuffer,
      {{"componentType", kUint32}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
  const auto& binary = buffer.bytes.bytes();
  // Lit, for viewers that do not know the extension, the material is matt.
  const json material = {
      {"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 1.0}}},
      {"extensions", {{"KHR_materials_unlit", json::object()}}}};
  const json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
  const json scene = {{"nodes", json::array({0})}}, node = {{"mesh", 0}},
             shape = {{"primitives", json::array({primitive})}};
  const json document = {{"asset", {{"version", "2.0"}, {"generator", "Tetrec"}}},
                         {"extensionsUsed", json::array({"KHR_materials_unlit"})},
                         {"scene", 0},
                         {"scenes", json::array({scene})},
                         {"nodes", json::array({node})},
                         {"meshes", json::array({shape})},
                         {"materials", json::array({material})},
                         {"buffers", json::array({{{"byteLength", binary.size()}}})},
                         {"bufferViews", buffer.views},
                         {"accessors", buffer.accessors}};
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
