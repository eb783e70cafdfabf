// Meshes by TetGen.
#include "start/tetgen.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "geometry/orientation.h"
#include "start/start_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

namespace tetrec {
namespace {

// Rows of numbers; '#' starts a comment.
class NumberRows {
 public:
  NumberRows(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  // The next row with content. Throws if there is none or it has fewer than `min_count` numbers.
  std::vector<double> Next(size_t min_count, const char* what) {
    while (!text_.empty()) {
      ++line_;
      const size_t end = std::min(text_.find('\n'), text_.size());
      std::string_view row = text_.substr(0, end);
      row = row.substr(0, std::min(row.find('#'), row.size()));
      text_.remove_prefix(std::min(end + 1, text_.size()));
      const std::vector<double> numbers = Numbers(row);
      if (numbers.empty()) continue;
      if (numbers.size() < min_count) Fail(what);
      return numbers;
    }
    Fail(what);
  }
  // A whole number in [0, limit).
  uint32_t Id(double value, size_t limit, const char* what) {
    if (!(value >= 0 && value < double(limit)) || value != std::floor(value)) Fail(what);
    return uint32_t(value);
  }
  size_t bytes_left() const { return text_.size(); }
  [[noreturn]] void Fail(const char* what) const {
    throw DataError(fmt::format("{}:{}: {} expected", name_, line_, what));
  }

 private:
  std::vector<double> Numbers(std::string_view row) const {
    std::vector<double> numbers;
    const char* p = row.data();
    const char* const end = p + row.size();
    while (true) {
      while (p != end && (*p == ' ' || *p == '\t' || *p == '\r')) ++p;
      if (p == end) return numbers;
      double value = 0;
      const auto [after, error] = std::from_chars(p, end, value);
      if (error != std::errc() || !std::isfinite(value)) Fail("a finite number");
      numbers.push_back(value);
      p = after;
    }
  }

  std::string_view text_;
  const std::string& name_;
  size_t line_ = 0;
};

// The shortest row, "0 0 0 0\n", has 8 bytes.
size_t CheckedCount(NumberRows& rows, double count, const char* what) {
  const uint32_t checked = rows.Id(count, kNoTet, what);
  if (checked > rows.bytes_left() / 8) rows.Fail("a count that the file has room for");
  return checked;
}

glm::vec3 Corner(const Bounds3& box, int i) {
  return glm::vec3(glm::dvec3((i & 1 ? box.max : box.min).x, (i & 2 ? box.max : box.min).y,
                              (i & 4 ? box.max : box.min).z));
}

std::string BoxAsPoly(const Bounds3& box) {
  constexpr int kTriangles[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                     {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7},
                                     {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  std::string poly = "8 3 0 0\n";
  for (int i = 0; i < 8; ++i) {
    const glm::vec3 p = Corner(box, i);
    poly += fmt::format("{} {:.9g} {:.9g} {:.9g}\n", i, p.x, p.y, p.z);
  }
  poly += "12 0\n";
  for (const auto& t : kTriangles) poly += fmt::format("1\n3 {} {} {}\n", t[0], t[1], t[2]);
  return poly + "0\n0\n";
}

// TetGen 1.5 refines nothing if every vertex is on a surface that must not change, so it starts
// from a jittered grid twice as coarse as the requested tets.
std::string InnerPointsAsNode(const Bounds3& box, double max_volume, uint64_t seed) {
  const double edge = std::cbrt(6 * std::sqrt(2.0) * max_volume);  // of a regular tet
  const glm::dvec3 size = box.Size();
  const double longest = std::max({size.x, size.y, size.z});
  const int cells = int(std::clamp(std::ceil(longest / (2 * edge)), 2.0, 256.0));
  const StartPoints grid = StartFromGrid(box, cells, seed);
  std::string node = fmt::format("{} 3 0 0\n", grid.positions.size() - 8);
  for (size_t i = 8; i < grid.positions.size(); ++i) {
    const glm::vec3& p = grid.positions[i];
    node += fmt::format("{} {:.9g} {:.9g} {:.9g}\n", i - 8, p.x, p.y, p.z);
  }
  return node;
}

void CheckBox(const Bounds3& box, double max_volume) {
  const glm::vec3 low = Corner(box, 0), high = Corner(box, 7);
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(low[axis]) || !std::isfinite(high[axis]) || !(low[axis] < high[axis])) {
      throw DataError(
          fmt::format("the box for TetGen spans {} to {} along axis {}: it has no volume",
                      low[axis], high[axis], axis));
    }
  }
  if (!std::isfinite(max_volume) || !(max_volume > 0)) {
    throw DataError(fmt::format("TetGen's volume bound is {}: it must be positive", max_volume));
  }
}

}  // namespace

TetMesh TetrahedralizeBox(const Bounds3& box, double max_volume, uint64_t seed,
                          const std::filesystem::path& folder) {
  CheckBox(box, max_volume);
  const std::filesystem::path program = FindProgram("tetgen");
  if (program.empty()) {
    throw EnvironmentError("tetgen is not in PATH; install it: apt-get install tetgen");
  }
  std::filesystem::create_directories(folder);
  WriteText(folder / "box.poly", BoxAsPoly(box));
  WriteText(folder / "box.a.node", InnerPointsAsNode(box, max_volume, seed));
  ChildOptions options;
  options.working_folder = folder;
  options.log = folder / "tetgen.log";
  // p: a surface is given, q: quality, i: inner points are given, Y: no new vertex on the surface,
  // a: volume bound.
  const ChildResult child =
      RunChild(program, {fmt::format("-pqiYa{:.12f}", max_volume), "box.poly"}, options);
  if (child.exit_code != 0) {
    throw EnvironmentError(
        fmt::format("tetgen failed with exit code {} on {}: {}", child.exit_code,
                    (folder / "box.poly").string(),
                    child.last_lines.empty() ? "it printed nothing" : child.last_lines.back()));
  }
  const std::filesystem::path nodes = folder / "box.1.node", elements = folder / "box.1.ele";
  return ParseTetgen(ReadText(nodes), ReadText(elements), nodes.string(), elements.string());
}

TetMesh ParseTetgen(const std::string& node_text, const std::string& ele_text,
                    const std::string& node_name, const std::string& ele_name) {
  TetMesh mesh;
  NumberRows nodes(node_text, node_name);
  const size_t node_count =
      CheckedCount(nodes, nodes.Next(2, "the number of nodes")[0], "the number of nodes");
  std::optional<uint32_t> first;  // TetGen counts from 0 or 1, as its input does
  for (size_t i = 0; i < node_count; ++i) {
    const std::vector<double> row = nodes.Next(4, "a node: id x y z");
    if (!first) first = nodes.Id(row[0], 2, "a first node id of 0 or 1");
    if (row[0] != double(i + *first)) nodes.Fail("consecutive node ids");
    mesh.positions.emplace_back(float(row[1]), float(row[2]), float(row[3]));
  }

  NumberRows elements(ele_text, ele_name);
  const size_t tet_count =
      CheckedCount(elements, elements.Next(2, "the number of tets")[0], "the number of tets");
  for (size_t t = 0; t < tet_count; ++t) {
    const std::vector<double> row = elements.Next(5, "a tet: id and four node ids");
    glm::uvec4 tet;
    for (int i = 0; i < 4; ++i) {
      tet[i] = elements.Id(row[size_t(i) + 1] - first.value_or(0), node_count, "a known node id");
    }
    const auto& p = mesh.positions;
    if (Orientation(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) < 0) std::swap(tet[2], tet[3]);
    mesh.tets.push_back(tet);
  }
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  CheckTetMesh(mesh);
  SortAlongMortonCurve(mesh);
  return mesh;
}

}  // namespace tetrec
