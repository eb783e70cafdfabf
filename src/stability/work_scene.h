// Scenes that the stability test makes or damages, in folders as the first stage writes them.
#pragma once

#include "stability/picture_damage.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace tetrec {

// Photos of a textured ball in a room, with sparse points: 24 training and 6 held-out views of
// 64x64 px, or 16 and 4 of 32x32 px in the short form.
SceneWithImages SyntheticRoom(bool is_short, uint64_t seed);
// Objects with alpha, without points, for the sweep: two balls of 64x64 px, or 32x32 px.
SceneWithImages SyntheticBalls(bool is_short, uint64_t seed);

// A scene folder with its images. Throws DataError.
SceneWithImages ReadSceneWithImages(const std::filesystem::path& folder);
// "sfm" or "import": the stage that wrote the folder. Throws DataError for any other folder.
std::string FirstStageOf(const std::filesystem::path& folder);

// Writes a scene folder with the manifest of that stage; `damage` names what was done to it.
void WriteSceneStage(const SceneWithImages& given, const std::string& stage,
                     const std::string& damage, const std::filesystem::path& folder);

}  // namespace tetrec
