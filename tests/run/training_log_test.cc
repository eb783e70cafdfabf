#include "run/training_log.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr const char* kHeader =
    "iteration,seconds,rays,loss,train_psnr,heldout_psnr,tets,vertices,phase,degenerate_tets\n";

TEST(TrainingLog, WhatWasWrittenIsReadBack) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / kTrainingLogFile;
  TrainingLogWriter log(path, 0);
  log.Add({1, 0.5, 4096, {}, {}, {}, 5000, 900, "optimise"});
  log.Add({20, 1.25, 81920, 0.0123456789, 18.25, 17.5, 6000, 1100, "end", 3});
  EXPECT_EQ(ReadText(path), std::string(kHeader) +
                                "1,0.500,4096,,,,5000,900,optimise,\n"
                                "20,1.250,81920,0.0123457,18.250,17.500,6000,1100,end,3\n");
  EXPECT_EQ(log.bytes(), std::filesystem::file_size(path));
  const std::vector<TrainingRow> rows = ReadTrainingLog(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].iteration, 1u);
  EXPECT_FALSE(rows[0].loss || rows[0].train_psnr || rows[0].heldout_psnr);
  EXPECT_EQ(rows[0].phase, "optimise");
  EXPECT_EQ(rows[1].seconds, 1.25);
  EXPECT_EQ(rows[1].rays, 81920u);
  EXPECT_EQ(rows[1].loss, 0.0123457);  // six digits are written
  EXPECT_EQ(rows[1].train_psnr, 18.25);
  EXPECT_EQ(rows[1].heldout_psnr, 17.5);
  EXPECT_EQ(rows[1].tets, 6000u);
  EXPECT_EQ(rows[1].vertices, 1100u);
  EXPECT_FALSE(rows[0].degenerate_tets);
  EXPECT_EQ(rows[1].degenerate_tets, 3u);
}

TEST(TrainingLog, AResumedLogLosesTheRowsAfterItsCheckpoint) {
  const ScratchFolder folder;
  const std::filesystem::path path = folder / kTrainingLogFile;
  const TrainingRow row{1, 1, 1, {}, {}, {}, 1, 1, "optimise"};
  uint64_t checkpoint = 0;
  {
    TrainingLogWriter log(path, 0);
    log.Add(row);
    checkpoint = log.bytes();
    log.Add(row);
    log.Add(row);
  }
  TrainingLogWriter(path, checkpoint).Add({7, 2, 7, {}, {}, {}, 1, 1, "optimise"});
  const std::vector<TrainingRow> rows = ReadTrainingLog(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].iteration, 7u);
  // A file shorter than the checkpoint states is another file.
  TrainingLogWriter(path, 1 << 20);
  EXPECT_EQ(ReadText(path), kHeader);
}

TEST(TrainingLog, ColumnsAreFoundByNameAndACutLastLineIsLeftOut) {
  const ScratchFolder folder;
  const auto rows = ReadTrainingLog(folder.Write(
      "metrics.csv",
      "seconds,iteration,rays,loss,extra,train_psnr,heldout_psnr,tets,vertices,phase\n"
      "1.5,10,400,0.01,x,20,,100,30,coarse\n3,20,800,0.005,x,23,22.5,120,40,fine\n4,30,12"));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].seconds, 1.5);
  EXPECT_EQ(rows[0].iteration, 10u);
  EXPECT_FALSE(rows[0].heldout_psnr.has_value());
  EXPECT_EQ(rows[1].heldout_psnr, 22.5);
  EXPECT_EQ(rows[1].phase, "fine");
}

TEST(TrainingLog, NamesTheBadLineAndColumn) {
  const ScratchFolder folder;
  const auto refused = [&](const std::string& text, std::initializer_list<std::string> parts) {
    const std::filesystem::path path = folder.Write("bad.csv", text);
    ExpectError<DataError>([&] { ReadTrainingLog(path); }, parts);
  };
  refused("", {"bad.csv", "no header line"});
  refused("seconds,loss\n1,2\n", {"bad.csv", "no column 'iteration'"});
  const std::string header = kHeader;
  refused(header + "1,2,3,4,5,six,7,8,p,\n",
          {"bad.csv: line 2, column heldout_psnr", "'six' is not a number"});
  refused(header + "1,2,3,4,5,6,7,8,p,\n1,,3,4,5,6,7,8,p,\n",
          {"bad.csv: line 3, column seconds", "'' is not a number"});
  refused(header + "1,2,3,4,5,6,-7,8,p,\n",
          {"bad.csv: line 2, column tets", "'-7' is not a whole number"});
  refused(header + "1,2,3,4,5,6,7,99999999999999999999999,p,\n",
          {"bad.csv: line 2, column vertices", "is not a whole number"});
  refused(header + "1,2,3,4,5,6,7,8,p,few\n",
          {"bad.csv: line 2, column degenerate_tets", "'few' is not a whole number"});
  refused(header + "1,2,3\n", {"bad.csv: line 2 has 3 cells, the header has 10"});
}

}  // namespace
}  // namespace tetrec
