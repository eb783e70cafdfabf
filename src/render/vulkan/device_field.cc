// A field on the device: mesh, parameters, gradients, the state of Adam.
#include "render/vulkan/device_field.h"

#include "core/error.h"
#include "geometry/bounds3.h"
#include "mesh/boundary.h"
#include "render/training_renderer.h"
#include "shared/gpu_types.glsl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <tuple>

namespace tetrec {
namespace {

// Vertex ids and neighbours, two rows per tet.
std::vector<glm::uvec4> TetRows(const TetMesh& mesh) {
  std::vector<glm::uvec4> rows(2 * mesh.tets.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    rows[2 * t] = mesh.tets[t];
    rows[2 * t + 1] = mesh.neighbors[t];
  }
  return rows;
}

// Position with density, and colour, two rows per vertex, then one row per cell that has
// attributes; density and colour are 0 here.
std::vector<glm::vec4> VertexRows(const TetMesh& mesh, FieldStorage storage) {
  const size_t cells = storage == FieldStorage::kCell ? mesh.tets.size() : 0;
  std::vector<glm::vec4> rows(2 * mesh.positions.size() + cells, glm::vec4(0.0f));
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    rows[2 * v] = glm::vec4(mesh.positions[v], 0.0f);
  }
  return rows;
}

// Bytes of one sum.
uint64_t SumBytes(bool fixed_point) { return fixed_point ? 8 : 4; }

// A convex boundary with more faces is searched by its tree of boxes, too.
constexpr size_t kFewFaces = 64;

// Outward normal, offset.
glm::vec4 PlaneOf(const TetMesh& mesh, const BoundaryFace& face) {
  const auto& corner = kFaceVertices[face.face];
  const glm::uvec4& tet = mesh.tets[face.tet];
  const glm::dvec3 a(mesh.positions[tet[corner[0]]]), b(mesh.positions[tet[corner[1]]]),
      c(mesh.positions[tet[corner[2]]]);
  const glm::dvec3 outward = glm::normalize(glm::cross(b - a, c - a));
  return {outward, float(glm::dot(outward, a))};
}

// Plane and (a, b, c, tet) as bits, two rows per boundary face.
std::vector<glm::vec4> FaceRows(const TetMesh& mesh, std::span<const BoundaryFace> faces) {
  std::vector<glm::vec4> rows;
  rows.reserve(2 * faces.size());
  for (const BoundaryFace& face : faces) {
    const auto& corner = kFaceVertices[face.face];
    const glm::uvec4& tet = mesh.tets[face.tet];
    rows.push_back(PlaneOf(mesh, face));
    // Wound inwards, so positive in the frame of a ray that enters.
    rows.push_back(
        glm::uintBitsToFloat(glm::uvec4(tet[corner[0]], tet[corner[2]], tet[corner[1]], face.tet)));
  }
  return rows;
}

void SortByPlane(const TetMesh& mesh, std::vector<BoundaryFace>& faces) {
  std::stable_sort(faces.begin(), faces.end(), [&](const BoundaryFace& a, const BoundaryFace& b) {
    const glm::vec4 pa = PlaneOf(mesh, a), pb = PlaneOf(mesh, b);
    return std::tie(pa.x, pa.y, pa.z, pa.w) < std::tie(pb.x, pb.y, pb.z, pb.w);
  });
}

// Plane and (first face, face after the last) as bits, two rows per plane, for faces sorted by
// plane. Returns the number of planes.
uint32_t AppendPlanes(std::vector<glm::vec4>& rows) {
  const uint32_t faces = uint32_t(rows.size() / 2);
  uint32_t planes = 0;
  for (uint32_t begin = 0, end = 0; begin < faces; begin = end, ++planes) {
    const glm::vec4 plane = rows[2 * begin];
    while (end < faces && rows[2 * end] == plane) ++end;
    rows.push_back(plane);
    rows.push_back(glm::uintBitsToFloat(glm::uvec4(begin, end, 0, 0)));
  }
  return planes;
}

void AppendTree(std::vector<glm::vec4>& rows, const BoxTree& tree) {
  rows.reserve(rows.size() + 2 * tree.nodes.size());
  for (const BoxNode& node : tree.nodes) {
    rows.emplace_back(node.min, std::bit_cast<float>(node.first));
    rows.emplace_back(node.max, std::bit_cast<float>(node.second));
  }
}

void UploadBoundary(const Device& device, DeviceField& field) {
  std::vector<BoundaryFace> faces = BoundaryFaces(field.mesh);
  field.not_convex = WhyNotConvex(field.mesh, faces);
  field.hull_faces = uint32_t(faces.size());
  std::vector<glm::vec4> rows;
  if (!field.not_convex.empty() || faces.size() > kFewFaces) {
    const BoxTree tree = BuildBoxTree(field.mesh, faces);
    field.tree_leaves = tree.leaves;
    rows = FaceRows(field.mesh, faces);
    AppendTree(rows, tree);
  } else {
    SortByPlane(field.mesh, faces);
    rows = FaceRows(field.mesh, faces);
    field.hull_planes = AppendPlanes(rows);
  }
  field.hull = MakeBuffer(device, "hull", rows, VK_FORMAT_R32G32B32A32_SFLOAT);
}

// A part of a row: `count` of its components from `first` on, in rows of `stride` on the device.
struct RowPart {
  size_t first, count, stride;
};

constexpr RowPart kStandardPart{0, kStandardComponents, kStandardComponents};

RowPart OtherPart(const FieldLayout& layout) {
  const size_t count = size_t(layout.Components() - kStandardComponents);
  return {kStandardComponents, count, (count + 3) / 4 * 4};
}

// A part of rows of `components`, padded with 0.
template <class T>
std::vector<T> PartOf(std::span<const T> rows, size_t components, const RowPart& part) {
  std::vector<T> result(rows.size() / components * part.stride, T(0));
  for (size_t row = 0; row * components < rows.size(); ++row) {
    const auto from = rows.begin() + long(row * components + part.first);
    std::copy(from, from + long(part.count), result.begin() + long(row * part.stride));
  }
  return result;
}

// Puts a part back in its place.
template <class T>
void PutPart(std::span<const T> part_rows, size_t components, const RowPart& part,
             std::vector<T>& rows) {
  for (size_t row = 0; row * part.stride < part_rows.size(); ++row) {
    const auto from = part_rows.begin() + long(row * part.stride);
    std::copy(from, from + long(part.count), rows.begin() + long(row * components + part.first));
  }
}

// The second moments of the other attributes in FieldState::second_moment.
RowPart OtherMomentPart(const FieldLayout& layout) {
  const size_t count = layout.attributes.size() - 2;
  return {kStandardComponents, count, count};
}

// Adam's moments, for colour and density: all first ones of a row, then all second ones.
std::vector<float> AdamMomentRows(const FieldState& state) {
  const size_t width = size_t(state.layout.SecondMoments());
  std::vector<float> rows;
  rows.reserve(2 * state.first_moment.size());
  for (size_t row = 0; row < state.rows(); ++row) {
    const auto first = state.first_moment.begin() + long(row * kStandardComponents);
    const auto second = state.second_moment.begin() + long(row * width);
    rows.insert(rows.end(), first, first + kStandardComponents);
    rows.insert(rows.end(), second, second + kStandardComponents);
  }
  return rows;
}

// The opposite.
void PutAdamMoments(std::span<const float> rows, FieldState& state) {
  const size_t width = size_t(state.layout.SecondMoments());
  for (size_t row = 0; row < state.rows(); ++row) {
    const auto from = rows.begin() + long(2 * row * kStandardComponents);
    std::copy_n(from, kStandardComponents,
                state.first_moment.begin() + long(row * kStandardComponents));
    std::copy_n(from + kStandardComponents, kStandardComponents,
                state.second_moment.begin() + long(row * width));
  }
}

constexpr VkFormat kTexels = VK_FORMAT_R32G32B32A32_SFLOAT;

OtherAttributes UploadOthers(const Device& device, const FieldState& state) {
  const RowPart part = OtherPart(state.layout);
  const RowPart moments = OtherMomentPart(state.layout);
  OtherAttributes others{.components = uint32_t(part.count),
                         .stride = uint32_t(part.stride),
                         .attributes = uint32_t(moments.count)};
  others.parameters = MakeBuffer(
      device, "other parameters",
      PartOf<float>(std::span(state.parameters), size_t(state.layout.Components()), part), kTexels);
  others.moments = MakeBuffer(
      device, "other moments",
      PartOf<float>(std::span(state.second_moment), size_t(state.layout.SecondMoments()), moments));
  return others;
}

// The quanta of each component of a row of gradients (FixedPoint), by rate class.
std::vector<double> QuantaOf(const FieldLayout& layout, const FixedPoint& fixed) {
  std::vector<double> quanta;
  for (const Attribute* attribute : layout.ByComponent()) {
    quanta.push_back(attribute->rate == RateClass::kDensity ? fixed.density_quanta
                                                            : fixed.color_quanta);
  }
  return quanta;
}

// Sums in units of value. `quanta`: of a row's sums, in turn; floats are not counted in quanta.
std::vector<double> DownloadSums(bool fixed_point, const Buffer& sums,
                                 std::span<const double> quanta) {
  const uint64_t count = sums.bytes() / SumBytes(fixed_point);
  std::vector<double> values;
  values.reserve(count);
  if (!fixed_point) {
    for (const float sum : sums.DownloadAs<float>(count)) values.push_back(double(sum));
    return values;
  }
  for (const int64_t sum : sums.DownloadAs<int64_t>(count)) {
    values.push_back(double(sum) / quanta[values.size() % quanta.size()]);
  }
  return values;
}

// Adds `values` to the sums, in the same units.
void AddToSums(bool fixed_point, Buffer& sums, std::span<const double> values,
               std::span<const double> quanta) {
  TETREC_CHECK(values.size() == sums.bytes() / SumBytes(fixed_point), "one value per sum");
  if (fixed_point) {
    auto all = sums.DownloadAs<int64_t>(values.size());
    for (size_t i = 0; i < all.size(); ++i) {
      const double count = values[i] * quanta[i % quanta.size()];
      TETREC_CHECK(std::abs(count) <= 0x1p62, "a gradient is too large for the fixed-point sums");
      all[i] += std::llround(count);
    }
    sums.Upload(all);
  } else {
    auto all = sums.DownloadAs<float>(values.size());
    for (size_t i = 0; i < all.size(); ++i) all[i] += float(values[i]);
    sums.Upload(all);
  }
}

// Of the rows of a part; 1 where they are padded.
std::vector<double> QuantaOf(const FieldLayout& layout, const FixedPoint& fixed,
                             const RowPart& part) {
  const std::vector<double> all = QuantaOf(layout, fixed);
  std::vector<double> quanta(part.stride, 1.0);
  std::copy_n(all.begin() + long(part.first), part.count, quanta.begin());
  return quanta;
}

// Rows whose other attributes have gradients move.
void MarkRowsWithGradients(DeviceField& field, std::span<const double> padded) {
  auto marks = field.others.has_gradients.DownloadAs<uint32_t>(field.row_count);
  for (size_t i = 0; i < padded.size(); ++i) {
    if (padded[i] != 0.0) marks[i / field.others.stride] = 1;
  }
  field.others.has_gradients.Upload(marks);
}

}  // namespace

DeviceFieldBytes BytesOf(const FieldLayout& layout, bool fixed_point, size_t views_per_batch) {
  const uint64_t sum = SumBytes(fixed_point);
  const bool cells = layout.storage == FieldStorage::kCell;
  // Rows of 16 bytes: 2 per tet, beside its scores; 2 per vertex and 4 sums; for what has
  // attributes a parameter, two moments and a sum per component, the rates, behind colour and
  // density a parameter and a sum per component (padded to 4) and a moment per attribute, and one
  // row more if that is a tet; 2 per face, and twice as many nodes of 2 as there are faces, at
  // most. View-dependent colours of a row and their sums for each view of a batch.
  const RowPart others = OtherPart(layout);
  const uint64_t views = layout.HarmonicsDegree() > 0 ? views_per_batch : 0;
  const uint64_t attributes = kStandardComponents * (3 * 4 + sum) + 16 + others.stride * (4 + sum) +
                              4 * OtherMomentPart(layout).count + (others.count > 0 ? 4 : 0) +
                              views * (16 + kStandardComponents * sum);
  return {.of_tet = 2 * 16 + kScoresPerTet * sum + (cells ? 16 + attributes : 0),
          .of_vertex = 2 * 16 + 4 * sum + (cells ? 0 : attributes),
          .of_face = 2 * 16 + 2 * 2 * 16};
}

DeviceField UploadField(const Device& device, TetMesh host_mesh, const FieldState& state,
                        bool fixed_point) {
  DeviceField field;
  field.mesh = std::move(host_mesh);
  const TetMesh& mesh = field.mesh;
  const size_t components = size_t(state.layout.Components());
  TETREC_CHECK(state.parameters.size() == RowCount(mesh, state.layout.storage) * components,
               "one row of parameters per vertex, or per tet");
  field.fixed_point = fixed_point;
  field.most_tets_at_vertex = MostTetsAtVertex(mesh);
  const Bounds3 bounds = BoundsOf(mesh.positions);
  field.diagonal = bounds.Diagonal();
  field.ball = glm::vec4(bounds.Center(), 1.001f * 0.5f * float(field.diagonal));
  field.vertex_count = uint32_t(mesh.positions.size());
  field.tet_count = uint32_t(mesh.tets.size());
  field.layout = state.layout;
  field.row_count = uint32_t(state.rows());
  field.first_cell = 2 * field.vertex_count;
  field.tets = MakeBuffer(device, "tets", TetRows(mesh), VK_FORMAT_R32G32B32A32_UINT);
  field.vertices = MakeBuffer(device, "vertices", VertexRows(mesh, state.layout.storage),
                              VK_FORMAT_R32G32B32A32_SFLOAT);
  UploadBoundary(device, field);
  field.parameters =
      MakeBuffer(device, "parameters",
                 PartOf<float>(std::span(state.parameters), components, kStandardPart), kTexels);
  field.moments = MakeBuffer(device, "moments", AdamMomentRows(state), kTexels);
  if (!state.layout.IsStandard()) field.others = UploadOthers(device, state);
  field.row_rates = Buffer(device, "row rates", field.row_count * sizeof(glm::vec4), kTexels);
  UploadRowRates(field, std::vector<RowRates>(field.row_count));
  field.gradients =
      Buffer(device, "field gradients",
             uint64_t{field.row_count} * kStandardComponents * SumBytes(fixed_point), kTexels);
  field.gradients.FillZero();
  field.tet_scores =
      Buffer(device, "tet scores", kScoresPerTet * field.tet_count * SumBytes(fixed_point));
  field.tet_scores.FillZero();
  return field;
}

void AllocatePositionGradients(const Device& device, DeviceField& field) {
  if (field.position_gradients.handle() != VK_NULL_HANDLE) return;
  field.position_gradients =
      Buffer(device, "position gradients", 4 * field.vertex_count * SumBytes(field.fixed_point));
  field.position_gradients.FillZero();
}

void AllocateOtherGradients(const Device& device, DeviceField& field) {
  OtherAttributes& others = field.others;
  if (!others || others.HasSums()) return;
  const uint64_t rows = field.row_count;
  others.gradients = Buffer(device, "other gradients",
                            rows * others.stride * SumBytes(field.fixed_point), kTexels);
  others.gradients.FillZero();
  others.has_gradients = Buffer(device, "rows with gradients", rows * 4);
  others.has_gradients.FillZero();
}

std::vector<double> DownloadGradients(const DeviceField& field, const FixedPoint& fixed) {
  const size_t components = size_t(field.layout.Components());
  std::vector<double> values(field.row_count * components);
  const auto put = [&](const Buffer& sums, const RowPart& part) {
    PutPart<double>(DownloadSums(field.fixed_point, sums, QuantaOf(field.layout, fixed, part)),
                    components, part, values);
  };
  put(field.gradients, kStandardPart);
  if (field.others.HasSums()) put(field.others.gradients, OtherPart(field.layout));
  return values;
}

void AddToGradients(DeviceField& field, std::span<const double> values, const FixedPoint& fixed) {
  const size_t components = size_t(field.layout.Components());
  TETREC_CHECK(values.size() == field.row_count * components, "one gradient per component");
  AddToSums(field.fixed_point, field.gradients, PartOf(values, components, kStandardPart),
            QuantaOf(field.layout, fixed, kStandardPart));
  if (!field.others) return;
  const RowPart part = OtherPart(field.layout);
  const std::vector<double> rows = PartOf(values, components, part);
  AddToSums(field.fixed_point, field.others.gradients, rows, QuantaOf(field.layout, fixed, part));
  MarkRowsWithGradients(field, rows);
}

void ClearGradients(DeviceField& field) {
  field.gradients.FillZero();
  if (!field.others.HasSums()) return;
  field.others.gradients.FillZero();
  field.others.has_gradients.FillZero();
}

std::vector<double> DownloadPositionGradients(const DeviceField& field, const FixedPoint& fixed) {
  return DownloadSums(field.fixed_point, field.position_gradients,
                      std::vector<double>{fixed.position_quanta});
}

void AddToPositionGradients(DeviceField& field, std::span<const double> values,
                            const FixedPoint& fixed) {
  AddToSums(field.fixed_point, field.position_gradients, values,
            std::vector<double>{fixed.position_quanta});
}

void UploadRowRates(DeviceField& field, std::span<const RowRates> rates) {
  const auto parameter = [&](float density) {
    // Devices need not know infinity.
    constexpr float kMost = std::numeric_limits<float>::max();
    return std::clamp(ParameterOf(field.layout.density(), density), -kMost, kMost);
  };
  std::vector<glm::vec4> rows;
  rows.reserve(rates.size());
  for (const RowRates& r : rates) {
    rows.emplace_back(r.share, parameter(r.kept_density), parameter(r.least_density), 0.0f);
  }
  field.row_rates.Upload(rows.data(), rows.size() * sizeof(glm::vec4));
}

void UploadParameters(DeviceField& field, std::span<const float> parameters) {
  const size_t components = size_t(field.layout.Components());
  field.parameters.Upload(PartOf(parameters, components, kStandardPart));
  if (field.others) {
    field.others.parameters.Upload(PartOf(parameters, components, OtherPart(field.layout)));
  }
}

void UploadPositions(DeviceField& field, std::span<const glm::vec3> positions) {
  field.mesh.positions.assign(positions.begin(), positions.end());
  field.vertices.Upload(VertexRows(field.mesh, field.layout.storage));
}

TetScores DownloadScores(const DeviceField& field) {
  const size_t count = kScoresPerTet * field.tet_count;
  TetScores scores;
  const auto add = [&](const auto& sums, double unit) {
    for (size_t i = 0; i < count; i += kScoresPerTet) {
      scores.errors.push_back(float(double(sums[i]) * unit));
      scores.light.push_back(float(double(sums[i + 1]) * unit));
    }
  };
  if (field.fixed_point) {
    add(field.tet_scores.DownloadAs<int64_t>(count), 1 / kScoreQuanta);
  } else {
    add(field.tet_scores.DownloadAs<float>(count), 1.0);
  }
  return scores;
}

FieldState DownloadState(const DeviceField& field) {
  const size_t components = size_t(field.layout.Components()), rows = field.row_count;
  FieldState state = WithoutMoments(field.layout, std::vector<float>(rows * components));
  const auto put = [&](const Buffer& parameters, const RowPart& part) {
    PutPart<float>(parameters.DownloadAs<float>(rows * part.stride), components, part,
                   state.parameters);
  };
  put(field.parameters, kStandardPart);
  PutAdamMoments(field.moments.DownloadAs<float>(2 * rows * kStandardComponents), state);
  if (!field.others) return state;
  put(field.others.parameters, OtherPart(field.layout));
  const RowPart moments = OtherMomentPart(field.layout);
  PutPart<float>(field.others.moments.DownloadAs<float>(rows * moments.stride),
                 size_t(field.layout.SecondMoments()), moments, state.second_moment);
  return state;
}

}  // namespace tetrec
