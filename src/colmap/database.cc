// COLMAP's SQLite database.
#include "colmap/database.h"

#include "colmap/version.h"
#include "core/error.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>

namespace tetrec {
namespace {

constexpr uint64_t kMaxImageId = kMaxImages;  // pair id = kMaxImageId * lower + higher
constexpr int kBusyWait_ms = 10000;

constexpr const char* kMakeAgain = "; force a fresh run, which makes the database again";

// Unexpected tables are damage if the tested version wrote them; another version would write the
// same tables again.
[[noreturn]] void FailByTables(const std::string& message, const std::string& colmap) {
  if (IsTestedColmap(colmap)) throw DataError(message + kMakeAgain);
  throw EnvironmentError(fmt::format("{}; {}", message, ColmapVersions(colmap)));
}

[[noreturn]] void Fail(const DatabaseFile& file, sqlite3* database) {
  const int code = sqlite3_errcode(database) & 0xFF;
  const std::string message = fmt::format("{}: {}", file.path.string(), sqlite3_errmsg(database));
  if (code == SQLITE_FULL) throw EnvironmentError(message + "; free some space and run it again");
  if (code == SQLITE_CORRUPT || code == SQLITE_NOTADB) throw DataError(message + kMakeAgain);
  // A table or column does not exist, or a column must not be left out.
  if (code == SQLITE_ERROR || code == SQLITE_CONSTRAINT) FailByTables(message, file.colmap);
  throw EnvironmentError(message);
}

class Statement {
 public:
  Statement(const DatabaseFile& file, sqlite3* database, const char* sql)
      : file_(file), database_(database) {
    if (sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr) != SQLITE_OK)
      Fail(file, database);
  }
  ~Statement() { sqlite3_finalize(statement_); }
  Statement(const Statement&) = delete;
  Statement& operator=(const Statement&) = delete;

  // True while there is a row.
  bool Step() {
    const int code = sqlite3_step(statement_);
    if (code != SQLITE_ROW && code != SQLITE_DONE) Fail(file_, database_);
    return code == SQLITE_ROW;
  }
  void Reset() { sqlite3_reset(statement_); }
  void Bind(int index, int64_t value) { Check(sqlite3_bind_int64(statement_, index, value)); }
  // The bytes and the text must live until the next Step or Reset.
  void BindText(int index, const std::string& text) {
    Check(sqlite3_bind_text64(statement_, index, text.data(), text.size(), SQLITE_STATIC,
                              SQLITE_UTF8));
  }
  void BindBlob(int index, const void* bytes, size_t size) {
    Check(sqlite3_bind_blob64(statement_, index, bytes, size, SQLITE_STATIC));
  }
  int64_t Integer(int column) const { return sqlite3_column_int64(statement_, column); }
  std::string Text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
    return text == nullptr ? ""
                           : std::string(text, size_t(sqlite3_column_bytes(statement_, column)));
  }
  std::vector<uint8_t> Blob(int column) const {
    const auto* bytes = static_cast<const uint8_t*>(sqlite3_column_blob(statement_, column));
    const auto size = size_t(sqlite3_column_bytes(statement_, column));
    return bytes == nullptr ? std::vector<uint8_t>() : std::vector<uint8_t>(bytes, bytes + size);
  }

 private:
  void Check(int code) {
    if (code != SQLITE_OK) Fail(file_, database_);
  }
  const DatabaseFile& file_;
  sqlite3* database_;
  sqlite3_stmt* statement_ = nullptr;
};

}  // namespace

ColmapDatabase::ColmapDatabase(const std::filesystem::path& path, const std::string& colmap_version)
    : file_{path, colmap_version}, database_(nullptr, &sqlite3_close) {
  sqlite3* database = nullptr;
  const int code = sqlite3_open_v2(path.c_str(), &database, SQLITE_OPEN_READWRITE, nullptr);
  database_.reset(database);
  if (code != SQLITE_OK) Fail(file_, database_.get());
  sqlite3_busy_timeout(database_.get(), kBusyWait_ms);
}

void ColmapDatabase::Execute(const std::string& sql) {
  if (sqlite3_exec(database_.get(), sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
    Fail(file_, database_.get());
}

std::vector<DatabaseImage> ColmapDatabase::Images() const {
  Statement select(file_, database_.get(),
                   "SELECT image_id, name, coalesce(descriptors.rows, 0) FROM images "
                   "LEFT JOIN descriptors USING (image_id) ORDER BY image_id");
  std::vector<DatabaseImage> images;
  while (select.Step())
    images.push_back({uint32_t(select.Integer(0)), select.Text(1), uint64_t(select.Integer(2))});
  return images;
}

Descriptors ColmapDatabase::ReadDescriptors(uint32_t image_id) const {
  Statement select(file_, database_.get(),
                   "SELECT rows, cols, data FROM descriptors WHERE image_id = ?");
  select.Bind(1, image_id);
  if (!select.Step()) return {};
  Descriptors descriptors = select.Blob(2);
  const int64_t rows = select.Integer(0);
  if (rows < 0 || uint64_t(rows) != descriptors.size() / kDescriptorBytes ||
      select.Integer(1) != int64_t(kDescriptorBytes) ||
      descriptors.size() % kDescriptorBytes != 0) {
    throw DataError(fmt::format("{}: descriptors of image {} have {} bytes for {} rows{}",
                                file_.path.string(), image_id, descriptors.size(), rows,
                                kMakeAgain));
  }
  return descriptors;
}

// A keypoint is x, y and either nothing, a scale and an angle, or an affine shape a11 a12 a21 a22.
std::vector<float> ColmapDatabase::ReadScales(uint32_t image_id) const {
  Statement select(file_, database_.get(),
                   "SELECT rows, cols, data FROM keypoints WHERE image_id = ?");
  select.Bind(1, image_id);
  if (!select.Step()) return {};
  const std::vector<uint8_t> bytes = select.Blob(2);
  const int64_t rows = select.Integer(0), columns = select.Integer(1);
  const bool known = columns == 2 || columns == 4 || columns == 6;
  if (!known || rows < 0 || uint64_t(rows) != bytes.size() / (sizeof(float) * size_t(columns))) {
    throw DataError(fmt::format("{}: keypoints of image {} have {} bytes for {} x {}{}",
                                file_.path.string(), image_id, bytes.size(), rows, columns,
                                kMakeAgain));
  }
  std::vector<float> scales;
  for (int64_t row = 0; row < rows; ++row) {
    float k[6] = {0, 0, 1, 0, 0, 1};
    std::memcpy(k, bytes.data() + size_t(row * columns) * sizeof(float),
                size_t(columns) * sizeof(float));
    scales.push_back(columns == 6 ? std::sqrt(std::abs(k[2] * k[5] - k[3] * k[4])) : k[2]);
  }
  return scales;
}

// Rows of the features with the largest scales, from coarse to fine.
std::vector<size_t> ColmapDatabase::CoarsestRows(uint32_t image_id, size_t count) const {
  const std::vector<float> scales = ReadScales(image_id);
  std::vector<size_t> order(scales.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return scales[a] > scales[b]; });
  order.resize(std::min(order.size(), count));
  return order;
}

Descriptors ColmapDatabase::ReadCoarsestDescriptors(uint32_t image_id, size_t count) const {
  const Descriptors all = ReadDescriptors(image_id);
  Descriptors coarse;
  for (const size_t row : CoarsestRows(image_id, count)) {
    if ((row + 1) * kDescriptorBytes > all.size()) continue;
    const auto start = all.begin() + std::ptrdiff_t(row * kDescriptorBytes);
    coarse.insert(coarse.end(), start, start + kDescriptorBytes);
  }
  return coarse;
}

std::set<ImagePair> ColmapDatabase::PairsOf(const char* table) const {
  const std::string sql = fmt::format("SELECT pair_id FROM {}", table);
  Statement select(file_, database_.get(), sql.c_str());
  std::set<ImagePair> pairs;
  while (select.Step()) {
    const auto id = uint64_t(select.Integer(0));
    pairs.insert({uint32_t(id / kMaxImageId), uint32_t(id % kMaxImageId)});
  }
  return pairs;
}

std::set<ImagePair> ColmapDatabase::MatchedPairs() const { return PairsOf("matches"); }
std::set<ImagePair> ColmapDatabase::VerifiedPairs() const { return PairsOf("two_view_geometries"); }
std::set<ImagePair> ColmapDatabase::PairsWithInliers() const {
  return PairsOf("two_view_geometries WHERE rows > 0");
}

uint64_t ColmapDatabase::MatchCount() const {
  Statement select(file_, database_.get(), "SELECT coalesce(sum(rows), 0) FROM matches");
  return select.Step() ? uint64_t(select.Integer(0)) : 0;
}

std::map<ImagePair, uint64_t> ColmapDatabase::MatchCounts() const {
  Statement select(file_, database_.get(), "SELECT pair_id, rows FROM matches");
  std::map<ImagePair, uint64_t> counts;
  while (select.Step()) {
    const auto id = uint64_t(select.Integer(0));
    counts[{uint32_t(id / kMaxImageId), uint32_t(id % kMaxImageId)}] = uint64_t(select.Integer(1));
  }
  return counts;
}

std::vector<std::string> ColmapDatabase::Columns(const char* schema, const char* table) const {
  const std::string sql = fmt::format("PRAGMA {}.table_info({})", schema, table);
  Statement select(file_, database_.get(), sql.c_str());
  std::vector<std::string> columns;
  while (select.Step()) columns.push_back(select.Text(1));
  return columns;
}

// SQL that copies a table from the attached database, with its ids shifted.
std::string ColmapDatabase::CopySql(const char* table, const std::vector<std::string>& needed,
                                    const std::filesystem::path& other) const {
  const std::vector<std::string> ours = Columns("main", table), theirs = Columns("other", table);
  const auto has = [](const std::vector<std::string>& columns, const std::string& column) {
    return std::find(columns.begin(), columns.end(), column) != columns.end();
  };
  for (const std::string& column : needed) {
    if (has(ours, column) && has(theirs, column)) continue;
    const std::filesystem::path& lacking = has(ours, column) ? other : file_.path;
    FailByTables(fmt::format("{}: no column {} in the table {}", lacking.string(), column, table),
                 file_.colmap);
  }
  std::string names, values;
  for (const std::string& column : ours) {
    if (!has(theirs, column)) continue;
    const char* comma = names.empty() ? "" : ", ";
    const char* shift = column == "image_id"    ? " + shift.image"
                        : column == "camera_id" ? " + shift.camera"
                                                : "";
    names += fmt::format("{}\"{}\"", comma, column);
    values += fmt::format("{}\"{}\"{}", comma, column, shift);
  }
  return fmt::format("INSERT INTO main.{0} ({1}) SELECT {2} FROM other.{0}, shift;", table, names,
                     values);
}

// Frames and rigs refer to images and cameras by the ids that change here. COLMAP would silently
// read the wrong ones, or none.
void ColmapDatabase::RefuseFrames(const char* schema, const std::filesystem::path& path) const {
  if (Columns(schema, "frames").empty()) return;
  const std::string sql = fmt::format("SELECT count(*) FROM {}.frames", schema);
  Statement select(file_, database_.get(), sql.c_str());
  if (!select.Step() || select.Integer(0) == 0) return;
  FailByTables(
      fmt::format("{}: {} frames, which Tetrec cannot renumber", path.string(), select.Integer(0)),
      file_.colmap);
}

void ColmapDatabase::Append(const std::filesystem::path& other) {
  {
    const std::string name = other.string();
    Statement attach(file_, database_.get(), "ATTACH ? AS other");
    attach.BindText(1, name);
    attach.Step();
  }
  RefuseFrames("other", other);
  // All statements are made before anything is written, since each may throw.
  const std::string copies =
      CopySql("cameras", {"camera_id", "model", "width", "height", "params"}, other) +
      CopySql("images", {"image_id", "name", "camera_id"}, other) +
      CopySql("keypoints", {"image_id", "rows", "cols", "data"}, other) +
      CopySql("descriptors", {"image_id", "rows", "cols", "data"}, other);
  Execute(
      "BEGIN IMMEDIATE;"
      "CREATE TEMP TABLE shift AS SELECT "
      "  (SELECT coalesce(max(image_id), 0) FROM main.images) AS image,"
      "  (SELECT coalesce(max(camera_id), 0) FROM main.cameras) AS camera;" +
      copies +
      "DROP TABLE shift;"
      "COMMIT;"
      "DETACH other;");
}

void ColmapDatabase::NumberByFileName(bool camera_per_folder) {
  TETREC_CHECK(MatchedPairs().empty() && VerifiedPairs().empty(), "images are matched already");
  RefuseFrames("main", file_.path);
  if (camera_per_folder) {
    Execute(
        "CREATE TEMP TABLE folder_camera AS SELECT rtrim(name, replace(name, '/', '')) AS folder, "
        "  camera_id, min(name) FROM images GROUP BY 1;"
        "UPDATE images SET camera_id = (SELECT folder_camera.camera_id FROM folder_camera "
        "  WHERE folder = rtrim(name, replace(name, '/', '')));"
        "DROP TABLE folder_camera;");
  }
  // Negative ids come in between, since an update must not produce an id that is still in use.
  Execute(
      "PRAGMA ignore_check_constraints = 1;"
      "BEGIN IMMEDIATE;"
      "CREATE TEMP TABLE files AS SELECT image_id, camera_id, name, "
      "  substr(name, 1 + length(rtrim(name, replace(name, '/', '')))) AS file FROM images;"
      "CREATE TEMP TABLE image_order AS SELECT image_id AS old, row_number() OVER "
      "  (ORDER BY file, name) AS new FROM files;"
      "CREATE TEMP TABLE camera_order AS SELECT camera_id AS old, row_number() OVER "
      "  (ORDER BY min(file), min(name)) AS new FROM files GROUP BY camera_id;"
      "DELETE FROM cameras WHERE camera_id NOT IN (SELECT old FROM camera_order);"
      "UPDATE images SET camera_id = (SELECT new FROM camera_order WHERE old = camera_id);"
      "UPDATE cameras SET camera_id = -(SELECT new FROM camera_order WHERE old = camera_id);"
      "UPDATE cameras SET camera_id = -camera_id;"
      "UPDATE images SET image_id = -(SELECT new FROM image_order WHERE old = image_id);"
      "UPDATE images SET image_id = -image_id;"
      "UPDATE keypoints SET image_id = -(SELECT new FROM image_order WHERE old = image_id);"
      "UPDATE keypoints SET image_id = -image_id;"
      "UPDATE descriptors SET image_id = -(SELECT new FROM image_order WHERE old = image_id);"
      "UPDATE descriptors SET image_id = -image_id;"
      "DROP TABLE files; DROP TABLE image_order; DROP TABLE camera_order;"
      "COMMIT;"
      "PRAGMA ignore_check_constraints = 0;");
}

void ColmapDatabase::UseLens(LensModel model, size_t images) {
  struct Row {
    int64_t id = 0;
    LensModel model = LensModel::kUnknown;
    std::vector<double> params;
  };
  std::vector<Row> rows;
  {
    Statement select(file_, database_.get(),
                     "SELECT camera_id, model, params FROM cameras WHERE (SELECT count(*) FROM "
                     "images WHERE images.camera_id = cameras.camera_id) < ?");
    select.Bind(1, int64_t(images));
    while (select.Step()) {
      Row row{select.Integer(0), LensModel(select.Integer(1)), {}};
      const std::vector<uint8_t> bytes = select.Blob(2);
      if (!IsKnown(row.model) || bytes.size() != sizeof(double) * size_t(ParamCount(row.model))) {
        FailByTables(fmt::format("{}: camera {} has no known lens", file_.path.string(), row.id),
                     file_.colmap);
      }
      row.params.resize(bytes.size() / sizeof(double));
      std::memcpy(row.params.data(), bytes.data(), bytes.size());
      rows.push_back(std::move(row));
    }
  }
  Execute("BEGIN IMMEDIATE");
  Statement update(file_, database_.get(),
                   "UPDATE cameras SET model = ?, params = ? WHERE camera_id = ?");
  for (const Row& row : rows) {
    const auto center = size_t(FocalLengths(row.model));
    std::vector<double> params(size_t(FocalLengths(model)), row.params[0]);
    params.insert(params.end(), {row.params[center], row.params[center + 1]});
    params.resize(size_t(ParamCount(model)), 0.0);
    update.Bind(1, int64_t(model));
    update.BindBlob(2, params.data(), params.size() * sizeof(double));
    update.Bind(3, row.id);
    update.Step();
    update.Reset();
  }
  Execute("COMMIT");
}

ColmapDatabase::FeatureRows ColmapDatabase::ReadRows(const char* table, uint32_t image_id) const {
  const std::string sql = fmt::format("SELECT rows, data FROM {} WHERE image_id = ?", table);
  Statement select(file_, database_.get(), sql.c_str());
  select.Bind(1, image_id);
  if (!select.Step() || select.Integer(0) <= 0) return {};
  FeatureRows rows{0, select.Blob(1)};
  rows.row_bytes = rows.bytes.size() / size_t(select.Integer(0));
  return rows;
}

void ColmapDatabase::WriteRows(const char* table, uint32_t image_id, const FeatureRows& rows) {
  const std::string sql = fmt::format("UPDATE {} SET rows = ?, data = ? WHERE image_id = ?", table);
  Statement update(file_, database_.get(), sql.c_str());
  update.Bind(1, int64_t(rows.count()));
  update.BindBlob(2, rows.bytes.data(), rows.bytes.size());
  update.Bind(3, image_id);
  update.Step();
}

void ColmapDatabase::KeepRows(const char* table, uint32_t image_id, std::span<const size_t> rows) {
  const FeatureRows all = ReadRows(table, image_id);
  if (all.count() == 0) return;
  FeatureRows kept{all.row_bytes, {}};
  for (const size_t row : rows) {
    if (row >= all.count()) {
      throw DataError(fmt::format("{}: {} of image {} have no row {}{}", file_.path.string(), table,
                                  image_id, row, kMakeAgain));
    }
    const auto start = all.bytes.begin() + std::ptrdiff_t(row * all.row_bytes);
    kept.bytes.insert(kept.bytes.end(), start, start + std::ptrdiff_t(all.row_bytes));
  }
  WriteRows(table, image_id, kept);
}

void ColmapDatabase::KeepCoarsest(size_t count) {
  TETREC_CHECK(MatchedPairs().empty() && VerifiedPairs().empty(), "images are matched already");
  Execute("BEGIN IMMEDIATE");
  for (const DatabaseImage& image : Images()) {
    if (image.features <= count) continue;
    std::vector<size_t> rows = CoarsestRows(image.id, count);
    std::sort(rows.begin(), rows.end());
    KeepRows("keypoints", image.id, rows);
    KeepRows("descriptors", image.id, rows);
  }
  Execute("COMMIT");
}

uint64_t ColmapDatabase::AppendFiner(const ColmapDatabase& richer) {
  std::map<std::string, uint32_t> rich_id;
  for (const DatabaseImage& image : richer.Images()) rich_id[image.name] = image.id;
  uint64_t added = 0;
  Execute("BEGIN IMMEDIATE");
  for (const DatabaseImage& image : Images()) {
    const auto found = rich_id.find(image.name);
    if (found == rich_id.end()) continue;
    FeatureRows places = ReadRows("keypoints", image.id),
                descriptors = ReadRows("descriptors", image.id);
    const FeatureRows rich_places = richer.ReadRows("keypoints", found->second),
                      rich_descriptors = richer.ReadRows("descriptors", found->second);
    const auto row_of = [](const FeatureRows& rows, size_t row) {
      const auto start = rows.bytes.begin() + std::ptrdiff_t(row * rows.row_bytes);
      return std::string(start, start + std::ptrdiff_t(rows.row_bytes));
    };
    if (rich_places.count() == 0) continue;
    if (rich_places.count() != rich_descriptors.count() ||
        (places.count() > 0 && places.row_bytes != rich_places.row_bytes)) {
      throw DataError(fmt::format("{}: features of image {} do not fit together{}",
                                  richer.file_.path.string(), image.name, kMakeAgain));
    }
    std::set<std::string> own;
    for (size_t row = 0; row < places.count(); ++row) own.insert(row_of(places, row));
    places.row_bytes = rich_places.row_bytes, descriptors.row_bytes = rich_descriptors.row_bytes;
    for (size_t row = 0; row < rich_places.count(); ++row) {
      const std::string place = row_of(rich_places, row);
      if (own.contains(place)) continue;
      const std::string descriptor = row_of(rich_descriptors, row);
      places.bytes.insert(places.bytes.end(), place.begin(), place.end());
      descriptors.bytes.insert(descriptors.bytes.end(), descriptor.begin(), descriptor.end());
      ++added;
    }
    WriteRows("keypoints", image.id, places);
    WriteRows("descriptors", image.id, descriptors);
  }
  Execute("COMMIT");
  return added;
}

void ColmapDatabase::ForgetPairs(const std::vector<ImagePair>& pairs) {
  Execute("BEGIN IMMEDIATE");
  for (const char* table : {"matches", "two_view_geometries"}) {
    const std::string sql = fmt::format("DELETE FROM {} WHERE pair_id = ?", table);
    Statement remove(file_, database_.get(), sql.c_str());
    for (const auto& [first, second] : pairs) {
      remove.Bind(1, int64_t(kMaxImageId * first + second));
      remove.Step();
      remove.Reset();
    }
  }
  Execute("COMMIT");
}

void ColmapDatabase::WriteMatches(
    const std::vector<std::pair<ImagePair, std::vector<FeatureMatch>>>& pairs) {
  static_assert(sizeof(FeatureMatch) == 2 * sizeof(uint32_t));
  Execute("BEGIN IMMEDIATE");
  try {
    Statement insert(file_, database_.get(),
                     "INSERT INTO matches (pair_id, rows, cols, data) VALUES (?, ?, 2, ?)");
    for (const auto& [pair, matches] : pairs) {
      TETREC_CHECK(pair.first < pair.second && pair.second < kMaxImageId, "wrong image pair");
      insert.Bind(1, int64_t(kMaxImageId * pair.first + pair.second));
      insert.Bind(2, int64_t(matches.size()));
      // An empty blob, not NULL, if there are none.
      insert.BindBlob(3, matches.empty() ? static_cast<const void*>("") : matches.data(),
                      matches.size() * sizeof(FeatureMatch));
      insert.Step();
      insert.Reset();
    }
  } catch (...) {
    sqlite3_exec(database_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
  Execute("COMMIT");
}

}  // namespace tetrec
