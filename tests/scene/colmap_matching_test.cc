// Descriptor matching and the database: vector code against plain code, and COLMAP's schema.
#include "scene/colmap_matching.h"

#include "core/error.h"
#include "expect_error.h"
#include "scene/colmap_database.h"
#include "scene/match_lanes.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetrec {
namespace {

// Descriptors as COLMAP makes them: not negative, of the length 512.
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
  // Sizes around the tiles' 4 rows and 16 or 64 columns, the empty picture included.
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

TEST_P(VectorMatching, OfEqualDescriptorsTheFirstIsTheBest) {
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

// A database in COLMAP's schema (its documentation, "Database Format"), pictures numbered out of
// order.
void MakeDatabase(const std::filesystem::path& path, const std::vector<std::string>& names) {
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
      "INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL, prior_tx "
      "REAL, prior_ty REAL, "
      "prior_tz REAL, CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647), "
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
    // The descriptor's first byte is the last letter of the name, so that it can be followed.
    run(
        fmt::format("INSERT INTO descriptors VALUES ({0}, 1, 128, X'{1:02x}{2:0254}');"
                    "INSERT INTO keypoints VALUES ({0}, 1, 2, X'0000000000000000');",
                    i + 1, int(names[i].back()), 0));
  }
  sqlite3_close(db);
}

TEST(ColmapDatabase, PicturesAreNumberedByNameWithTheirFeatures) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/c", "1/a", "0/b"});
  ColmapDatabase database(folder / "a.db");
  database.NumberByName(true);
  const std::vector<DatabaseImage> images = database.Images();
  ASSERT_EQ(images.size(), 3u);
  const std::vector<std::string> expected = {"0/b", "0/c", "1/a"};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(images[i].id, i + 1);
    EXPECT_EQ(images[i].name, expected[i]);
    EXPECT_EQ(images[i].features, 1u);
    EXPECT_EQ(database.ReadDescriptors(images[i].id)[0], uint8_t(expected[i].back()));
  }
}

TEST(ColmapDatabase, AppendedPartsAreOneDatabaseWhateverTheParts) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"0/a", "0/c"});
  MakeDatabase(folder / "b.db", {"0/b", "0/d"});
  {
    ColmapDatabase database(folder / "a.db");
    database.Append(folder / "b.db");
    database.NumberByName(true);
    const std::vector<DatabaseImage> images = database.Images();
    ASSERT_EQ(images.size(), 4u);
    for (uint32_t i = 0; i < 4; ++i) {
      EXPECT_EQ(images[i].id, i + 1);
      EXPECT_EQ(database.ReadDescriptors(i + 1)[0], uint8_t('a' + i));
    }
  }
  sqlite3* db = nullptr;  // one camera for the folder is left
  sqlite3_open((folder / "a.db").c_str(), &db);
  int cameras = 0;
  sqlite3_exec(
      db, "SELECT count(*) FROM cameras",
      [](void* n, int, char** v, char**) {
        *static_cast<int*>(n) = std::stoi(v[0]);
        return 0;
      },
      &cameras, nullptr);
  sqlite3_close(db);
  EXPECT_EQ(cameras, 1);
}

TEST(ColmapDatabase, MatchesAreWrittenUnderColmapsPairIds) {
  const ScratchFolder folder;
  MakeDatabase(folder / "a.db", {"a", "b", "c"});
  ColmapDatabase database(folder / "a.db");
  database.WriteMatches({{{1, 2}, {{0, 0}}}, {{2, 3}, {}}});
  EXPECT_EQ(database.MatchedPairs(), (std::set<ImagePair>{{1, 2}, {2, 3}}));
  EXPECT_TRUE(database.VerifiedPairs().empty());
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
