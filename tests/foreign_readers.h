// Files read by programs that are not ours: meshio (Python) and assimp.
#pragma once

#include "core/child_process.h"
#include "core/file.h"
#include "mesh/triangle_mesh.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>

namespace tetrec {

// Debian's Python, for which Debian's meshio is installed; another may come first in PATH.
inline const std::filesystem::path kDebianPython = "/usr/bin/python3";

inline bool HasMeshio() {
  return std::filesystem::exists(kDebianPython) &&
         RunChild(kDebianPython, {"-c", "import meshio"}, {}).exit_code == 0;
}

// What meshio finds in a file: {"points": [[x, y, z], ...], "cells": {"tetra": [[ids], ...], ...},
// "point_data": {name: [...]}, "cell_data": {name: [one list per kind of cell]}}.
inline nlohmann::json ReadByMeshio(const std::filesystem::path& file) {
  const std::string script =
      "import json, sys, meshio\n"
      "mesh = meshio.read(sys.argv[1])\n"
      "json.dump({'points': mesh.points.tolist(),\n"
      "           'cells': {block.type: block.data.tolist() for block in mesh.cells},\n"
      "           'point_data': {k: v.tolist() for k, v in mesh.point_data.items()},\n"
      "           'cell_data': {k: [a.tolist() for a in v] for k, v in mesh.cell_data.items()}},\n"
      "          open(sys.argv[2], 'w'))\n";
  const std::string json = file.string() + ".json";
  const ChildResult result = RunChild(kDebianPython, {"-c", script, file.string(), json}, {});
  if (result.exit_code != 0) {
    ADD_FAILURE() << file << ": " << ::testing::PrintToString(result.last_lines);
    return {};
  }
  return ReadJson(json);
}

// The mesh that assimp finds in a file, by way of its own PLY.
inline TriangleMesh ReadByAssimp(const std::filesystem::path& file) {
  const std::string ply = file.string() + ".assimp.ply";
  const ChildResult result = RunChild(FindProgram("assimp"), {"export", file.string(), ply}, {});
  if (result.exit_code != 0) {
    ADD_FAILURE() << file << ": " << ::testing::PrintToString(result.last_lines);
    return {};
  }
  return ReadTriangleMesh(ply);
}

}  // namespace tetrec
