// cameras.json: how the cameras of the training photos were corrected while the field was fitted.
// Written beside the field, only if corrections were kept; read by the report and by whoever wants
// better cameras.
#pragma once

#include "geometry/rigid3.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kCameraCorrectionsFile = "cameras.json";

struct CameraCorrection {
  std::string name;         // of the scene's view
  Rigid3 cam_from_world;    // corrected
  double rotation_deg = 0;  // angle of the turn
  double move = 0;          // of the centre [world units; the subject's longest side is 2]
  double shift_px = 0;      // of the picture, root mean square, at the median depth of the view
};

// {"schema": 1, "views": [{"name", "rotation_deg", "move", "shift_px",
//                          "cam_from_world": {"rotation": 3 x 3 by rows, "translation": [3]}}]}
// Throw DataError naming file and field: another schema, a view named twice, a negative number, a
// matrix that is not a rotation. Writing refuses what reading would refuse.
void WriteCameraCorrections(const std::filesystem::path& path,
                            const std::vector<CameraCorrection>& corrections);
std::vector<CameraCorrection> ReadCameraCorrections(const std::filesystem::path& path);
std::vector<CameraCorrection> ParseCameraCorrections(const nlohmann::json& value,
                                                     const std::string& name);

// True if the picture moved so far that the camera was plainly wrong.
bool MovedMuch(const CameraCorrection& correction);
inline constexpr double kMovedMuch_px = 1.5;
// "5 of 44 cameras were moved ...": for people, with the threshold of MovedMuch.
std::string MovedMuchWarning(size_t moved, size_t cameras);

}  // namespace tetrec
