// Descriptor matching and the database: vector code against plain code, and COLMAP's schema.
#include "colmap/matching.h"

#include "colmap/database.h"
#include "colmap/match_lanes.h"
#include "core/error.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <random>

namespace tetrec {
namespace {

// Descriptors like COLMAP's: not negative, with the length 512.
Descriptors RandomDescriptors(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::exponential_distribution<double> entry(1.0);
  Descriptors all;
  for (size_t i = 0; i < count; ++i) {
    std::vector<double> d(kDescriptorBytes);
    double squared = 0;
    for (double& v : d) {
      v = entry(random);
      squared += v * v;
    }
    for (const double v : d)
      all.push_back(uint8_t(std::min(255.0, std::round(512 * v / std::sqrt(squared)))));
  }
  return all;
}

#if defined(__x86_64__)
struct VectorCode {
  const char* name;
  bool (*can_run)();
  internal::BestOfPair (*find)(std::span<const uint8_t>, std::span<const uint8_t>);
};

class VectorMatching : public ::testing::TestWithParam<VectorCode> {
 protected:
  void SetUp() override {
    if (!GetParam().can_run()) GTEST_SKIP() << "the processor lacks the instructions";
  }
};

std::string NameOfCode(const ::testing::TestParamInfo<VectorCode>& code) { return code.param.name; }

INSTANTIATE_TEST_SUITE_P(
    Codes, VectorMatching,
    ::testing::Values(VectorCode{"Avx2", internal::CanMatchByAvx2, internal::FindBestAvx2},
                      VectorCode{"Vnni", internal::CanMatchByVnni, internal::FindBestVnni}),
    NameOfCode);

TEST_P(VectorMatching, FindsWhatPlainCodeFinds) {
  // Sizes around the tiles' 4 rows and 16 or 64 columns, and images without descriptors.
  for (const size_t first : {0, 1, 3, 4, 5, 37}) {
    for (const size_t second : {0, 1, 15, 16, 17, 50, 63, 64, 65, 130}) {
      const Descriptors a = RandomDescriptors(first, 1), b = RandomDescriptors(second, 2);
      const internal::BestOfPair fast = GetParam().find(a, b),
                                 plain = internal::FindBestPlain(a, b);
      EXPECT_EQ(fast.of_first, plain.of_first) << first << " x " << second;
      EXPECT_EQ(fast.of_second, plain.of_second) << first << " x " << second;
    }
  }
}

TEST_P(VectorMatching, IsExactForTheLargestEntries) {
  const Descriptors white(3 * kDescriptorBytes, 255), black(2 * kDescriptorBytes, 0);
  EXPECT_EQ(GetParam().find(white, white).of_first[0].best, 255 * 255 * int(kDescriptorBytes));
  EXPECT_EQ(GetParam().find(white, black).of_first[0].index, -1);
  EXPECT_EQ(GetParam().find(black, white).of_second[2].index, -1);
}

TEST_P(VectorMatching, AmongEqualDescriptorsTheFirstIsTheBest) {
  const Descriptors one = RandomDescriptors(1, 3);
  Descriptors many;
  for (int i = 0; i < 70; ++i) many.insert(many.end(), one.begin(), one.end());
  const internal::BestOfPair fast = GetParam().find(many, many),
                             plain = internal::FindBestPlain(many, many);
  EXPECT_EQ(fast.of_first, plain.of_first);
  EXPECT_EQ(fast.of_first[7].index, 0);
  EXPECT_EQ(fast.of_first[7].best, fast.of_first[7].second);
}
#endif

TEST(Matching, ShuffledAndSlightlyDisturbedDescriptorsFindTheirPartners) {
  const size_t count = 200;
  const Descriptors first = RandomDescriptors(count, 4);
  std::vector<uint32_t> order(count);
  for (uint32_t i = 0; i < count; ++i) order[i] = i;
  std::mt19937 random(5);
  std::shuffle(order.begin(), order.end(), random);
  Descriptors second(first.size());
  for (size_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < kDescriptorBytes; ++k) {
      const int noisy = first[i * kDescriptorBytes + k] + int(random() % 5) - 2;
      second[order[i] * kDescriptorBytes + k] = uint8_t(std::clamp(noisy, 0, 255));
    }
  }
  const std::vector<FeatureMatch> matches = MatchDescriptors(first, second);
  ASSERT_EQ(matches.size(), count);
  for (uint32_t i = 0; i < count; ++i) EXPECT_EQ(matches[i], (FeatureMatch{i, order[i]}));
}

TEST(Matching, AmbiguousAndUnlikeDescriptorsAreNotMatched) {
  const Descriptors one = RandomDescriptors(1, 6);
  Descriptors twice = one;
  twice.insert(twice.end(), one.begin(), one.end());
  EXPECT_TRUE(MatchDescriptors(one, twice).empty());  // the second best is as good as the best
  Descriptors left(kDescriptorBytes, 0), right(kDescriptorBytes, 0);
  left[0] = right[1] = 255;
  EXPECT_TRUE(MatchDescriptors(left, right).empty());  // perpendicular
  EXPECT_EQ(MatchDescriptors(one, one).size(), 1u);    // alone: no second best
}

void RunSql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  char* error = nullptr;
  EXPECT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  sqlite3_free(error);
  sqlite3_close(db);
}

// The first number that a query returns.
int NumberOf(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* db = nullptr;
  sqlite3_open(path.c_str(), &db);
  int number = -1;
  sqlite3_exec(
      db, sql.c_str(),
      [](void* n, int, char** v, char**) {
        *static_cast<int*>(n) = v[0] == nullptr ? -1 : std::stoi(v[0]);
        return 0;
      },
      &number, nullptr);
  sqlite3_close(db);
  return number;
}

constexpr const char* kPriors =
    "prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx REAL, prior_ty REAL, "
    "prior_tz REAL, ";

// A database in COLMAP's schema (its documentation, "Database Format") with images numbered out of
// order. Later versions dropped the columns `priors`.
void MakeDatabase(const std::filesystem::path& path, const std::vector<std::string>& names,
                  const std::string& priors = kPriors) {
  sqlite3* db = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &db), SQLITE_OK);
  const auto run = [&](const std::string& sql) {
    char* error = nullptr;
    ASSERT_EQ(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &error), SQLITE_OK) << error;
  };
  run("CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER "
      "NOT NULL, width "
      "INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT "
      "NULL);"
      "CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT "
      "NULL UNIQUE, camera_id "
      "INTEGER NOT NULL, " +
      priors +
      "CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647), "
      "FOREIGN "
      "KEY(camera_id) REFERENCES cameras(camera_id));"
      "CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols "
      "INTEGER NOT NULL, "
      "data BLOB);"
      "CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, "
      "cols INTEGER NOT NULL, "
      "data BLOB);"
      "CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL, cols "
      "INTEGER NOT NULL, data "
      "BLOB);"
      "CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT "
      "NULL, cols INTEGER "
      "NOT NULL, data BLOB, config INTEGER NOT NULL);");
  for (size_t i = 0; i < names.size(); ++i) {
    run(
        fmt::format("INSERT INTO cameras VALUES ({0}, 2, 64, 48, NULL, {0});"
                    "INSERT INTO images (image_id, name, camera_id) VALUES ({0}, '{1}', {0});",
                    i + 1, names[i]));
    // The descriptor's first byte is the last letter of the name, so that it can be recognised.
    run(
        fmt::format("INSERT INTO descriptors VALUES ({0}, 1, 128, X'{1:02x}{2:0254}');"
                    "INSERT INTO keypoints VALUES ({0}, 1, 2, X'0000000000000000');",
                    i + 1, int(names[i].back()), 0));
  }
  sqlite3_close(db);
}

TEST(ColmapDatabase, ImagesAreNumberedByFileNameWithTheirFeatures) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"2/c", "10/a", "2/b", "10/d"});
  ColmapDatabase database(folder / "a.db");
  database.NumberByFileName(true);
  const std::vector<DatabaseImage> images = database.Images();
  const std::vector<std::string> expected = {"10/a", "2/b", "2/c", "10/d"};
  ASSERT_EQ(images.size(), expected.size());
  for (size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(images[i].id, i + 1);
    EXPECT_EQ(images[i].name, expected[i]);
    EXPECT_EQ(images[i].features, 1u);
    EXPECT_EQ(database.ReadDescriptors(images[i].id)[0], uint8_t(expected[i].back()));
  }
  // Each folder has one camera, the first that of the first image.
  const char* cameras =
      "SELECT sum(camera_id = 2 - (name LIKE '10/%')) * 10 + max(camera_id) FROM images";
  EXPECT_EQ(NumberOf(folder / "a.db", cameras), 42);
}

TEST(ColmapDatabase, TheCoarsestFeaturesAreKeptInTheirOrder) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/a", "0/b"});
  // Keypoints are x, y, scale, angle; x and the descriptor's first byte are the feature's number.
  const float scales[] = {3, 9, 1, 9, 2, 8};
  std::string keypoints, descriptors;
  for (size_t i = 0; i < std::size(scales); ++i) {
    for (const float value : {float(i), 0.0f, scales[i], 0.0f}) {
      for (int byte = 0; byte < 4; ++byte) {
        keypoints += fmt::format("{:02x}", std::bit_cast<uint32_t>(value) >> (8 * byte) & 255);
      }
    }
    descriptors += fmt::format("{:02x}{:0254}", i, 0);
  }
  NumberOf(folder / "a.db",
           fmt::format("UPDATE keypoints SET rows = 6, cols = 4, data = X'{}' WHERE image_id = 1;"
                       "UPDATE descriptors SET rows = 6, data = X'{}' WHERE image_id = 1;",
                       keypoints, descriptors));
  ColmapDatabase database(folder / "a.db");
  database.KeepCoarsest(4);
  const Descriptors kept = database.ReadDescriptors(1);
  ASSERT_EQ(kept.size(), 4 * kDescriptorBytes);
  const uint8_t expected[] = {0, 1, 3, 5};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(kept[i * kDescriptorBytes], expected[i]);
  EXPECT_EQ(NumberOf(folder / "a.db", "SELECT rows * length(data) FROM keypoints WHERE image_id=1"),
            4 * 4 * 16);
  EXPECT_EQ(database.ReadDescriptors(2).size(), kDescriptorBytes);
  EXPECT_EQ(database.ReadCoarsestDescriptors(1, 2)[0], 1);
}

// Sets image 1's features: x and the descriptor's first byte are each feature's number.
void SetFeatures(const std::filesystem::path& path, const std::vector<int>& numbers) {
  std::string keypoints, descriptors;
  for (const int number : numbers) {
    for (const float value : {float(number), 0.0f}) {
      for (int byte = 0; byte < 4; ++byte) {
        keypoints += fmt::format("{:02x}", std::bit_cast<uint32_t>(value) >> (8 * byte) & 255);
      }
    }
    descriptors += fmt::format("{:02x}{:0254}", number, 0);
  }
  NumberOf(path, fmt::format("UPDATE keypoints SET rows = {0}, cols = 2, data = X'{1}' WHERE "
                             "image_id = 1; UPDATE descriptors SET rows = {0}, data = X'{2}' WHERE "
                             "image_id = 1;",
                             numbers.size(), keypoints, descriptors));
}

TEST(ColmapDatabase, FinerFeaturesAreAddedBehindThoseThatMatchesReferTo) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/a", "0/b"});
  MakeDatabase(folder / "rich.db", {"0/a"});
  SetFeatures(folder / "a.db", {5, 3});
  SetFeatures(folder / "rich.db", {3, 8, 5, 9});
  ColmapDatabase database(folder / "a.db");
  EXPECT_EQ(database.AppendFiner(ColmapDatabase(folder / "rich.db")), 2u);
  const Descriptors all = database.ReadDescriptors(1);
  ASSERT_EQ(all.size(), 4 * kDescriptorBytes);
  const uint8_t expected[] = {5, 3, 8, 9};
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(all[i * kDescriptorBytes], expected[i]);
  EXPECT_EQ(NumberOf(folder / "a.db", "SELECT rows * length(data) FROM keypoints WHERE image_id=1"),
            4 * 4 * 8);
  EXPECT_EQ(database.ReadDescriptors(2).size(), kDescriptorBytes);  // is not in the other
}

TEST(ColmapDatabase, ForgottenPairsCanBeMatchedAgain) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/a", "0/b", "0/c"});
  ColmapDatabase database(folder / "a.db");
  database.WriteMatches({{{1, 2}, {{0, 0}}}, {{1, 3}, {}}});
  EXPECT_EQ(database.MatchCounts(), (std::map<ImagePair, uint64_t>{{{1, 2}, 1}, {{1, 3}, 0}}));
  database.ForgetPairs({{1, 2}, {2, 3}});
  EXPECT_EQ(database.MatchedPairs(), (std::set<ImagePair>{{1, 3}}));
  database.WriteMatches({{{1, 2}, {}}});
}

TEST(ColmapDatabase, AppendedPartsAreOneDatabaseWhateverTheParts) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/a", "0/c"});
  MakeDatabase(folder / "b.db", {"0/b", "0/d"});
  {
    ColmapDatabase database(folder / "a.db");
    database.Append(folder / "b.db");
    database.NumberByFileName(true);
    const std::vector<DatabaseImage> images = database.Images();
    ASSERT_EQ(images.size(), 4u);
    for (uint32_t i = 0; i < 4; ++i) {
      EXPECT_EQ(images[i].id, i + 1);
      EXPECT_EQ(database.ReadDescriptors(i + 1)[0], uint8_t('a' + i));
    }
  }
  EXPECT_EQ(NumberOf(folder / "a.db", "SELECT count(*) FROM cameras"), 1);  // of the folder
}

TEST(ColmapDatabase, ColumnsThatBothDatabasesHaveAreAppended) {
  const ScratchFolder folder;
  // The columns of later versions, and columns that only one of the two has.
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", ""},
      {"", kPriors},
      {kPriors, ""},
      {"shape REAL, prior_qw REAL, ", "prior_qw REAL, mask TEXT, "}};
  for (const auto& [ours, theirs] : cases) {
    const std::filesystem::path a = folder / "a.db", b = folder / "b.db";
    std::filesystem::remove(a);
    std::filesystem::remove(b);
    MakeDatabase(a, {"0/a", "0/c"}, ours);
    MakeDatabase(b, {"0/b", "0/d"}, theirs);
    const bool both =
        ours.find("prior_qw") != std::string::npos && theirs.find("prior_qw") != std::string::npos;
    if (both) RunSql(b, "UPDATE images SET prior_qw = 7 WHERE name = '0/d'");
    {
      ColmapDatabase database(a, "3.11.1");
      database.Append(b);
      database.NumberByFileName(false);
      const std::vector<DatabaseImage> images = database.Images();
      ASSERT_EQ(images.size(), 4u);
      for (uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(images[i].name, std::string("0/") + char('a' + i));
        EXPECT_EQ(database.ReadDescriptors(i + 1)[0], uint8_t('a' + i));
      }
    }
    // The prior of a camera is its number in its first database: 0/c and 0/d keep the second of
    // each.
    const char* priors =
        "SELECT sum(prior_focal_length * (image_id IN (3, 4))) FROM images JOIN "
        "cameras USING (camera_id)";
    EXPECT_EQ(NumberOf(a, priors), 4);
    EXPECT_EQ(both ? NumberOf(a, "SELECT prior_qw FROM images WHERE name = '0/d'") : 7, 7);
  }
}

TEST(ColmapDatabase, TablesOfAnotherVersionAreEnvironmentErrorsThatNameIt) {
  const ScratchFolder folder;
  const std::filesystem::path a = folder / "a.db", b = folder / "b.db";
  const std::string versions = "COLMAP 5.1 was found, 3.8 is the tested version";
  const auto refuse = [&](const std::string& change_of_a, const std::string& change_of_b,
                          const auto& call, const std::string& what) {
    std::filesystem::remove(a);
    std::filesystem::remove(b);
    MakeDatabase(a, {"a"});
    MakeDatabase(b, {"b"});
    RunSql(a, change_of_a);
    RunSql(b, change_of_b);
    ColmapDatabase database(a, "5.1");
    ExpectError<EnvironmentError>([&] { call(database); }, {what, versions});
  };
  const auto append = [&](ColmapDatabase& database) { database.Append(b); };
  const auto number = [](ColmapDatabase& database) { database.NumberByFileName(true); };
  const std::string rename = "ALTER TABLE images RENAME COLUMN camera_id TO camera";
  refuse("", rename, append, "b.db: no column camera_id in the table images");
  refuse(rename, "", append, "a.db: no column camera_id in the table images");
  refuse("", "DROP TABLE keypoints", append, "b.db: no column image_id in the table keypoints");
  refuse("CREATE TRIGGER t BEFORE INSERT ON images BEGIN SELECT RAISE(ABORT, 'rig'); END", "",
         append, "a.db: rig");
  refuse(rename, "", number, "a.db: no such column: camera_id");
  refuse(
      "DROP TABLE matches", "", [](ColmapDatabase& database) { database.MatchedPairs(); },
      "a.db: no such table: matches");
  refuse(
      "ALTER TABLE matches ADD COLUMN kind INTEGER CHECK (kind IS NOT NULL)", "",
      [](ColmapDatabase& database) {
        database.WriteMatches({{{1, 2}, {}}});
      },
      "constraint");
  // COLMAP writes an empty table of frames if there are none.
  const std::string frames = "CREATE TABLE frames (frame_id, rig_id);";
  refuse(frames, frames + "INSERT INTO frames VALUES (1, 1)", append, "b.db: 1 frames");
  refuse(frames + "INSERT INTO frames VALUES (1, 1), (2, 1)", frames, number, "a.db: 2 frames");
  std::filesystem::remove(a);
  MakeDatabase(a, {"a"});
  RunSql(a, frames);
  EXPECT_NO_THROW(ColmapDatabase(a).NumberByFileName(true));
}

TEST(ColmapDatabase, OtherTablesThanTheTestedVersionsAreDamage) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"a"});
  RunSql(folder / "a.db", "DROP TABLE images");
  ExpectError<DataError>([&] { ColmapDatabase(folder / "a.db", "3.8").Images(); },
                         {"no such table: images", "force a fresh run"});
  MakeDatabase(folder / "b.db", {"b"});
  ExpectError<DataError>([&] { ColmapDatabase(folder / "b.db", "3.8").Append(folder / "a.db"); },
                         {"a.db: no column image_id in the table images", "force a fresh run"});
  ExpectError<EnvironmentError>([&] { ColmapDatabase(folder / "a.db").Images(); },
                                {"no such table: images", "COLMAP unknown was found"});
}

TEST(ColmapDatabase, MatchesAreWrittenUnderColmapsPairIds) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"a", "b", "c"});
  ColmapDatabase database(folder / "a.db");
  database.WriteMatches({{{1, 2}, {{0, 0}}}, {{2, 3}, {}}});
  EXPECT_EQ(database.MatchedPairs(), (std::set<ImagePair>{{1, 2}, {2, 3}}));
  EXPECT_TRUE(database.VerifiedPairs().empty());
  RunSql(folder / "a.db",
         "INSERT INTO two_view_geometries (pair_id, rows, cols, config) VALUES "
         "(2147483649, 20, 2, 2), (4294967297, 0, 2, 0)");
  EXPECT_EQ(database.VerifiedPairs().size(), 2u);
  EXPECT_EQ(database.PairsWithInliers(), (std::set<ImagePair>{{1, 2}}));
  EXPECT_EQ(database.MatchCount(), 1u);
  EXPECT_THROW(database.WriteMatches({{{2, 1}, {}}}), BugError);
}

TEST(ColmapDatabase, MissingAndForeignFilesAreErrors) {
  const ScratchFolder folder;
  folder.Write("x.db", std::string(5000, 'x'));
  EXPECT_THROW(ColmapDatabase(folder / "none.db"), Error);
  ExpectError<DataError>([&] { ColmapDatabase(folder / "x.db").Images(); }, {"x.db"});
}

}  // namespace
}  // namespace tetrec
