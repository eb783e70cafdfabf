// Files of triangle meshes: reads and writes PLY, writes OBJ and STL.
#include "core/error.h"
#include "core/file.h"
#include "core/ply.h"
#include "geometry/bounds3.h"
#include "mesh/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <span>

namespace tetrec {
namespace {

constexpr const char* kMaterialName = "surface";

const std::vector<double>& Scalars(const PlyElement& element, const char* property,
                                   const std::string& name) {
  const PlyProperty* found = element.Find(property);
  if (found == nullptr || found->is_list) {
    throw DataError(
        fmt::format("{}: element '{}' has no number '{}'", name, element.name, property));
  }
  return found->values;
}

void ReadPositions(const PlyElement& vertices, const std::string& name, TriangleMesh& mesh) {
  const auto &x = Scalars(vertices, "x", name), &y = Scalars(vertices, "y", name),
             &z = Scalars(vertices, "z", name);
  Bounds3 bounds;
  for (size_t v = 0; v < x.size(); ++v) bounds.Add({x[v], y[v], z[v]});
  if (bounds.Diagonal() > 0 && StepOfFloats(bounds) > kLargestStepOfFloats &&
      vertices.Find("x")->type == PlyType::kDouble) {
    throw DataError(fmt::format(
        "{}: a mesh of {:.4g} in diagonal is too far from 0, around {:.6g},{:.6g},"
        "{:.6g}, for 32-bit floats; move it to 0",
        name, bounds.Diagonal(), bounds.Center().x, bounds.Center().y, bounds.Center().z));
  }
  mesh.positions.reserve(x.size());
  for (size_t v = 0; v < x.size(); ++v) {
    const glm::vec3 p{float(x[v]), float(y[v]), float(z[v])};
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw DataError(fmt::format("{}: vertex {} is not finite", name, v));
    }
    mesh.positions.push_back(p);
  }
}

// Colours are 8-bit integers or floats in [0, 1].
void ReadColors(const PlyElement& vertices, TriangleMesh& mesh) {
  const PlyProperty* channels[3] = {vertices.Find("red"), vertices.Find("green"),
                                    vertices.Find("blue")};
  for (const PlyProperty* channel : channels) {
    if (channel == nullptr || channel->is_list) return;
  }
  mesh.colors_srgb.resize(mesh.positions.size());
  for (size_t c = 0; c < 3; ++c) {
    const bool is_real =
        channels[c]->type == PlyType::kFloat || channels[c]->type == PlyType::kDouble;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      const double value = channels[c]->values[v] * (is_real ? 255.0 : 1.0);
      // This form turns NaN into 0.
      const double clamped = value > 0 ? (value < 255 ? value : 255.0) : 0.0;
      mesh.colors_srgb[v][c] = uint8_t(std::lround(clamped));
    }
  }
}

// Two finite numbers per corner.
bool HasCornerCoordinates(const PlyElement& faces, const PlyProperty& lists) {
  const PlyProperty* coordinates = faces.Find("texcoord");
  if (coordinates == nullptr || !coordinates->is_list || coordinates->type != PlyType::kFloat) {
    return false;
  }
  for (size_t f = 0; f < lists.list_sizes.size(); ++f) {
    if (uint64_t{coordinates->list_sizes[f]} != 2 * uint64_t{lists.list_sizes[f]}) return false;
  }
  return std::all_of(coordinates->values.begin(), coordinates->values.end(),
                     [](double value) { return std::isfinite(value); });
}

void ReadTriangles(const PlyElement& faces, const std::string& name, TriangleMesh& mesh) {
  const PlyProperty* lists = faces.Find("vertex_indices");
  if (lists == nullptr) lists = faces.Find("vertex_index");
  if (lists == nullptr || !lists->is_list) {
    throw DataError(fmt::format("{}: element 'face' has no list 'vertex_indices'", name));
  }
  const std::vector<double>* coordinates =
      HasCornerCoordinates(faces, *lists) ? &faces.Find("texcoord")->values : nullptr;
  size_t begin = 0;
  for (size_t f = 0; f < lists->list_sizes.size(); ++f) {
    const uint32_t size = lists->list_sizes[f];
    if (size < 3) throw DataError(fmt::format("{}: face {} has {} vertices", name, f, size));
    const auto id = [&](size_t k) {
      const double value = lists->values[begin + k];
      if (!(value >= 0 && value < double(mesh.positions.size()))) {
        throw DataError(fmt::format("{}: face {} names vertex {} of {}", name, f, value,
                                    mesh.positions.size()));
      }
      return uint32_t(value);
    };
    const auto place = [&](size_t k) {
      const size_t at = 2 * (begin + k);
      return glm::vec2((*coordinates)[at], (*coordinates)[at + 1]);
    };
    for (size_t k = 2; k < size; ++k) {
      mesh.triangles.emplace_back(id(0), id(k - 1), id(k));
      if (coordinates) mesh.corner_coordinates.push_back({place(0), place(k - 1), place(k)});
    }
    begin += size;
  }
}

PlyProperty Scalar(const char* name, PlyType type) {
  PlyProperty property;
  property.name = name;
  property.type = type;
  return property;
}

}  // namespace

TriangleMesh ReadTriangleMesh(const std::filesystem::path& path) {
  const PlyFile file = ReadPly(path);
  const PlyElement *vertices = file.Find("vertex"), *faces = file.Find("face");
  if (vertices == nullptr || faces == nullptr) {
    throw DataError(fmt::format("{}: is not a mesh: it has no element '{}'", path.string(),
                                vertices == nullptr ? "vertex" : "face"));
  }
  TriangleMesh mesh;
  ReadPositions(*vertices, path.string(), mesh);
  ReadColors(*vertices, mesh);
  ReadTriangles(*faces, path.string(), mesh);
  return mesh;
}

void WriteTriangleMeshPly(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const std::string& texture_file) {
  PlyElement vertices{"vertex", mesh.positions.size(), {}};
  const char* const axes[3] = {"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    PlyProperty& property = vertices.properties.emplace_back(Scalar(axes[axis], PlyType::kFloat));
    for (const glm::vec3& p : mesh.positions) property.values.push_back(p[axis]);
  }
  if (!mesh.colors_srgb.empty()) {
    const char* const channels[3] = {"red", "green", "blue"};
    for (size_t c = 0; c < 3; ++c) {
      PlyProperty& property =
          vertices.properties.emplace_back(Scalar(channels[c], PlyType::kUint8));
      for (const auto& color : mesh.colors_srgb) property.values.push_back(color[c]);
    }
  }
  PlyElement faces{"face", mesh.triangles.size(), {}};
  PlyProperty& lists = faces.properties.emplace_back(Scalar("vertex_indices", PlyType::kInt32));
  lists.is_list = true;
  lists.list_sizes.assign(mesh.triangles.size(), 3);
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) lists.values.push_back(t[k]);
  }
  if (!mesh.corner_coordinates.empty()) {
    PlyProperty& coordinates = faces.properties.emplace_back(Scalar("texcoord", PlyType::kFloat));
    coordinates.is_list = true;
    coordinates.list_sizes.assign(mesh.triangles.size(), 6);
    for (const auto& corners : mesh.corner_coordinates) {
      for (const glm::vec2& p : corners) {
        coordinates.values.push_back(p.x);
        coordinates.values.push_back(p.y);
      }
    }
  }
  std::vector<std::string> comments;
  if (!texture_file.empty()) comments.push_back("TextureFile " + texture_file);
  WritePly(path, {std::move(comments), {std::move(vertices), std::move(faces)}});
}

void WriteTriangleMeshObj(const std::filesystem::path& path, const TriangleMesh& mesh,
                          const std::string& material_file) {
  std::string text;
  const auto out = std::back_inserter(text);
  const bool textured = !mesh.corner_coordinates.empty();
  if (!material_file.empty()) {
    fmt::format_to(out, "mtllib {}\nusemtl {}\n", material_file, kMaterialName);
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3& p = mesh.positions[v];
    fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}", p.x, p.y, p.z);
    if (!mesh.colors_srgb.empty() && !textured) {
      const auto& c = mesh.colors_srgb[v];
      fmt::format_to(out, " {:.4g} {:.4g} {:.4g}", c[0] / 255.0, c[1] / 255.0, c[2] / 255.0);
    }
    text += '\n';
  }
  for (const auto& corners : mesh.corner_coordinates) {
    for (const glm::vec2& p : corners) fmt::format_to(out, "vt {:.7g} {:.7g}\n", p.x, p.y);
  }
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const glm::uvec3 t = mesh.triangles[i] + 1u;
    if (textured) {
      fmt::format_to(out, "f {}/{} {}/{} {}/{}\n", t.x, 3 * i + 1, t.y, 3 * i + 2, t.z, 3 * i + 3);
    } else {
      fmt::format_to(out, "f {} {} {}\n", t.x, t.y, t.z);
    }
  }
  WriteText(path, text);
}

void WriteTextureMaterial(const std::filesystem::path& path, const std::string& texture_file) {
  WriteText(path, fmt::format("newmtl {}\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {}\n",
                              kMaterialName, texture_file));
}

void WriteTriangleMeshStl(const std::filesystem::path& path, const TriangleMesh& mesh) {
  // Must not begin with "solid", by which readers recognise text.
  std::array<char, 80> header{"binary STL, written by Tetrec"};
  ByteWriter writer;
  writer.Write(header);
  writer.Write(uint32_t(mesh.triangles.size()));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::vec3 corners[3] = {mesh.positions[t.x], mesh.positions[t.y], mesh.positions[t.z]};
    const glm::dvec3 a(corners[0]);
    const glm::dvec3 normal = glm::cross(glm::dvec3(corners[1]) - a, glm::dvec3(corners[2]) - a);
    const double length = glm::length(normal);
    writer.Write(length > 0 ? glm::vec3(normal / length) : glm::vec3(0));
    writer.WriteArray(std::span<const glm::vec3>(corners));
    writer.Write(uint16_t{0});
  }
  WriteBytes(path, writer.bytes());
}

}  // namespace tetrec
