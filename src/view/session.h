// What a viewer shows: the scene and the newest field of a run.
#pragma once

#include "view/newest_field.h"
#include "view/paint.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <mutex>
#include <optional>
#include <string>

namespace tetrec {

// Pictures may be asked for by several threads: one is drawn at a time.
class ViewSession {
 public:
  // Reads the scene and the newest field. Throws as FindRun, NewestField and the readers.
  ViewSession(const std::filesystem::path& run, const RendererOptions& options);

  // None if it was given up for a draft.
  std::optional<Image> Draw(const PictureRequest& request);
  // Reads the field again if there is a newer one. A file that cannot be read keeps the old one
  // shown; Status() contains the reason.
  void Refresh();

  const Scene& scene() const { return shown_scene_.scene; }
  // {"field": what is shown, "loaded": a number that grows with each field, "tets", "vertices",
  //  "problem": why there is no newer one, or ""}
  nlohmann::json Status() const;
  // {"subject": {"center": [3], "size"}, "views": [{"name", "split", "eye": [3], "forward": [3],
  //  "up": [3], "fov" of the height [degrees], "width", "height"}]}
  nlohmann::json DescribeScene() const;

 private:
  ViewedRun run_;
  RendererOptions options_;
  ShownScene shown_scene_;
  FieldFile file_;  // tried last; of the thread that calls Refresh
  std::atomic<int> waiting_drafts_ = 0;
  std::mutex drawing_;
  ShownField shown_;  // guarded by drawing_
  mutable std::mutex facts_;
  nlohmann::json status_;  // guarded by facts_
};

}  // namespace tetrec
