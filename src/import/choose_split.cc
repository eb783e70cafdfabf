// Chooses which images of a data set are for training and which are held out.
#include "import/choose_split.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "scene/split.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>

namespace tetrec::internal {
namespace {

constexpr uint64_t kMaxListBytes = uint64_t{1} << 26;

// The picture that a line of the test list means: by its name, or by the name of its file with or
// without extension and folder.
size_t FindListed(const std::vector<PosedPicture>& pictures, const std::string& line,
                  const std::string& where) {
  std::vector<size_t> found;
  for (size_t i = 0; i < pictures.size(); ++i) {
    const PosedPicture& picture = pictures[i];
    if (picture.name == line) return i;
    const std::filesystem::path& file = picture.file;
    const bool is_its_file = picture.name + file.extension().string() == line ||
                             std::filesystem::path(picture.name).replace_extension() == line ||
                             file.filename() == line || file.stem() == line;
    if (is_its_file) found.push_back(i);
  }
  if (found.empty()) {
    throw DataError(
        fmt::format("{}: no image of the data set has the name \"{}\"; names look like \"{}\"",
                    where, line, pictures[0].name));
  }
  if (found.size() > 1) {
    throw DataError(
        fmt::format("{}: \"{}\" is the name of {} images, such as \"{}\" and \"{}\"; "
                    "write it in full",
                    where, line, found.size(), pictures[found[0]].name, pictures[found[1]].name));
  }
  return found[0];
}

void SplitByList(std::vector<PosedPicture>& pictures, const std::filesystem::path& list) {
  for (PosedPicture& picture : pictures) picture.split = Split::kTrain;
  std::istringstream lines(ReadText(list, kMaxListBytes));
  int number = 0, listed = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    // Windows marks UTF-8 by these bytes.
    if (number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
    line.erase(line.find_last_not_of(" \t\r") + 1);
    line.erase(0, line.find_first_not_of(" \t"));
    if (line.empty() || line[0] == '#') continue;
    line = std::filesystem::path(line).lexically_normal().generic_string();  // for "./a.png"
    const std::string where = fmt::format("{}: line {}", list.string(), number);
    pictures[FindListed(pictures, line, where)].split = Split::kTest;
    ++listed;
  }
  if (listed == 0) {
    throw DataError(fmt::format(
        "{}: names no view; to hold out none, omit the list and set holdout to 0", list.string()));
  }
}

}  // namespace

void ChooseSplit(Dataset& set, const ImportOptions& options) {
  const bool holds_out =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split != Split::kTrain; });
  if (set.has_split && !holds_out && !options.holdout && options.test_list.empty()) {
    LogInfo("the data set holds out no view: every {}th by name is held out (holdout 0: none)",
            kUsualHoldout);
  }
  if (!options.test_list.empty()) {
    SplitByList(set.pictures, options.test_list);
  } else if (options.holdout || !set.has_split || !holds_out) {
    HoldOut(set.pictures, options.holdout.value_or(kUsualHoldout));
  }
  const bool has_training =
      std::any_of(set.pictures.begin(), set.pictures.end(),
                  [](const PosedPicture& picture) { return picture.split == Split::kTrain; });
  if (!has_training) {
    throw DataError(
        fmt::format("all {} images are held out; leave some to train on", set.pictures.size()));
  }
}

}  // namespace tetrec::internal
