// What a viewer shows: the scene and the newest field of a run.
#pragma once

#include "view/newest_field.h"
#include "view/paint.h"

#include <nlohmann/json.hpp>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace tetrec {

// Pictures may be asked for by several threads: one is drawn at a time. A field is shown with the
// scene that was there when it appeared: the scene alone may be newer, because the stages after it
// have not been repeated yet, and a field seen through another scene's cameras is wrong.
class ViewSession {
 public:
  // Reads the scene and the newest field. Throws as FindRun, NewestField and the readers.
  ViewSession(const std::filesystem::path& run, const RendererOptions& options);

  // None if it was given up for a draft, or if `asked_of`, the scene that the request was made for,
  // is no longer shown.
  std::optional<Image> Draw(const PictureRequest& request,
                            const std::shared_ptr<const ShownScene>& asked_of);
  // Reads the field again if there is a newer one, and the scene, too, if that has changed since it
  // was read. A file that cannot be read keeps both as they are; Status() contains the reason.
  void Refresh();

  // Never null. Another one once Refresh has read another.
  std::shared_ptr<const ShownScene> scene() const;
  // {"field": what is shown, "loaded": a number that grows with each field, "scene": one that grows
  //  with each scene, "tets", "vertices", "problem": why there is no newer one, or ""}
  nlohmann::json Status() const;
  // {"number": "scene" of Status(), "subject": {"center": [3], "size"}, "views": [{"name", "split",
  //  "eye": [3], "forward": [3], "up": [3], "fov" of the height [degrees], "width", "height"}]}
  nlohmann::json DescribeScene() const;

 private:
  // What a field and its scene are read from.
  struct Sources {
    FieldFile field;
    std::filesystem::file_time_type scene_written;
    bool operator==(const Sources&) const = default;
  };
  Sources NewestSources() const;

  ViewedRun run_;
  RendererOptions options_;
  Sources shown_from_, tried_;  // of the thread that calls Refresh
  std::atomic<int> waiting_drafts_ = 0;
  std::mutex drawing_;
  mutable std::mutex facts_;
  std::shared_ptr<const ShownScene> shown_scene_;  // changed under both locks
  ShownField shown_;                               // guarded by drawing_
  nlohmann::json status_;                          // guarded by facts_
};

}  // namespace tetrec
