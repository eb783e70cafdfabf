#include "optimize/training_set.h"

#include "core/error.h"
#include "expect_error.h"
#include "image/image.h"
#include "render/ray_blocks.h"
#include "scene/synthetic.h"
#include "scratch_folder.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

namespace tetrec {
namespace {

SyntheticScene TinyScene(int width = 32, int height = 32) {
  SyntheticOptions options;
  options.train_views = 4;
  options.validation_views = 1;
  options.test_views = 1;
  options.width = width;
  options.height = height;
  options.rays_per_side = 1;
  return MakeSyntheticScene(options);
}

std::tuple<uint32_t, uint32_t, uint32_t> Key(const RayBlock& b) { return {b.view, b.x, b.y}; }

bool Same(const std::vector<RayBlock>& a, const std::vector<RayBlock>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const RayBlock& x, const RayBlock& y) { return Key(x) == Key(y); });
}

// A scene on disk, whose images a test may replace.
class TrainingSetTest : public ::testing::Test {
 protected:
  void Write(const SyntheticScene& synthetic) {
    scene_ = synthetic.scene;
    WriteSyntheticScene(folder_.path(), synthetic);
  }
  void Replace(int view, const Image& image) {
    WriteImage(folder_.path() / scene_.views[view].image, image);
  }
  TrainingSet Load() const {
    return LoadTrainingSet(folder_.path(), scene_, scene_.ViewsOf(Split::kTrain));
  }

  ScratchFolder folder_;
  Scene scene_;
};

TEST_F(TrainingSetTest, HoldsEveryBlockOfTheTrainingViewsOnce) {
  Write(TinyScene(33, 31));  // not a multiple of a block
  const TrainingSet set = Load();
  ASSERT_EQ(set.views.size(), 4u);
  ASSERT_EQ(set.targets.size(), 4u);
  EXPECT_EQ(set.pixels, 4u * 33 * 31);
  EXPECT_EQ(set.blocks.size(), 4u * 9 * 16);
  std::set<std::tuple<uint32_t, uint32_t, uint32_t>> seen;
  for (const RayBlock& block : set.blocks.List()) {
    EXPECT_TRUE(seen.insert(Key(block)).second);
    EXPECT_EQ(block.x % kRayBlockWidth, 0u);
    EXPECT_EQ(block.y % kRayBlockHeight, 0u);
    EXPECT_LT(block.x, 33u);
    EXPECT_LT(block.y, 31u);
  }
}

TEST(AlignedBlocks, AreNumberedViewByView) {
  AlignedBlocks blocks;
  blocks.Add(1, 33, 3);   // 9 x 2 blocks
  blocks.Add(4, 4, 5);    // 1 x 3
  blocks.Add(7, 16, 16);  // 4 x 8
  EXPECT_EQ(blocks.size(), 18u + 3 + 32);
  EXPECT_EQ(Key(blocks[0]), std::tuple(1u, 0u, 0u));
  EXPECT_EQ(Key(blocks[17]), std::tuple(1u, 32u, 2u));
  EXPECT_EQ(Key(blocks[18]), std::tuple(4u, 0u, 0u));
  EXPECT_EQ(Key(blocks[20]), std::tuple(4u, 0u, 4u));
  EXPECT_EQ(Key(blocks[26]), std::tuple(7u, 4u, 2u));
  EXPECT_EQ(blocks.OfView(4).begin, 18u);
  EXPECT_EQ(blocks.OfView(4).end, 21u);
  for (const uint32_t absent : {0u, 2u, 9u}) {
    EXPECT_EQ(blocks.OfView(absent).begin, blocks.OfView(absent).end);
  }
  const std::vector<RayBlock> list = blocks.List();
  ASSERT_EQ(list.size(), blocks.size());
  for (size_t i = 0; i < list.size(); ++i) EXPECT_EQ(Key(list[i]), Key(blocks[i]));
}

TEST_F(TrainingSetTest, CallsTheBlocksOnAndBesideTheMaskTheSubject) {
  Write(TinyScene(64, 64));
  const TrainingSet set = Load();
  const std::set<uint32_t> subject(set.subject_blocks.begin(), set.subject_blocks.end());
  EXPECT_EQ(subject.size(), set.subject_blocks.size());
  size_t on_mask = 0, far_off = 0;
  for (uint32_t b = 0; b < set.blocks.size(); ++b) {
    const TargetImage& target = set.targets[set.blocks[b].view];
    int nearest = 1000;  // [px] from the block to the subject, along the farther axis
    for (int y = 0; y < target.height; ++y) {
      for (int x = 0; x < target.width; ++x) {
        if (target.rgba8[size_t(y) * target.width + x] >> 24 == 0) continue;
        const int x0 = int(set.blocks[b].x), y0 = int(set.blocks[b].y);
        const int dx = std::max({0, x0 - x, x - (x0 + kRayBlockWidth - 1)});
        const int dy = std::max({0, y0 - y, y - (y0 + kRayBlockHeight - 1)});
        nearest = std::min(nearest, std::max(dx, dy));
      }
    }
    on_mask += nearest == 0;
    far_off += nearest > 8;
    if (nearest <= 1) {
      EXPECT_TRUE(subject.contains(b));
    }
    if (nearest > 8) {
      EXPECT_FALSE(subject.contains(b));
    }
  }
  EXPECT_GT(on_mask, 0u);
  EXPECT_GT(far_off, 0u);
}

TEST_F(TrainingSetTest, MultipliesColourByAlpha) {
  Write(TinyScene(4, 2));
  const int view = scene_.ViewsOf(Split::kTrain)[0];
  Image image = MakeImage(4, 2, 4);
  for (int i = 0; i < 8; ++i) {
    const uint8_t alpha = uint8_t(i == 7 ? 255 : 32 * i);
    const uint8_t rgba[4] = {255, uint8_t(200 - 20 * i), uint8_t(3 * i), alpha};
    std::copy(rgba, rgba + 4, image.At(i % 4, i / 4));
  }
  Replace(view, image);
  const TargetImage target = Load().targets[0];
  ASSERT_EQ(target.rgba8.size(), 8u);
  for (int i = 0; i < 8; ++i) {
    const uint8_t* straight = image.At(i % 4, i / 4);
    EXPECT_EQ(target.rgba8[size_t(i)] >> 24, straight[3]);
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(int(target.rgba8[size_t(i)] >> (8 * c) & 255),
                int(std::lround(straight[c] * straight[3] / 255.0)))
          << "pixel " << i << " channel " << c;
    }
  }
  EXPECT_EQ(target.rgba8[0], 0u) << "what colour hides behind alpha 0 is nothing";
}

TEST_F(TrainingSetTest, TakesPicturesWithoutAlphaAsOpaque) {
  Write(TinyScene(8, 4));
  for (const int view : scene_.ViewsOf(Split::kTrain)) {
    Image image = MakeImage(8, 4, 3);
    for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = uint8_t(7 * i);
    Replace(view, image);
  }
  const TrainingSet set = Load();
  for (size_t i = 0; i < 32; ++i) {
    const uint32_t r = uint8_t(21 * i), g = uint8_t(21 * i + 7), b = uint8_t(21 * i + 14);
    EXPECT_EQ(set.targets[0].rgba8[i], r | g << 8 | b << 16 | 255u << 24);
  }
  EXPECT_EQ(set.subject_blocks.size(), set.blocks.size());
  EXPECT_EQ(SubjectPixels(set), set.pixels);
}

TEST_F(TrainingSetTest, CountsThePixelsOfTheSubject) {
  Write(TinyScene(64, 64));
  const std::vector<int> training = scene_.ViewsOf(Split::kTrain);
  Image image = MakeImage(64, 64, 4);
  for (const int view : training) Replace(view, image);
  EXPECT_EQ(SubjectPixels(Load()), training.size() * 64 * 64) << "nothing is shown anywhere";
  image.At(33, 33)[3] = 255;
  Replace(training[0], image);
  // Blocks of 4 x 2 pixels within 4 pixels of it: 3 columns, 5 rows.
  EXPECT_EQ(SubjectPixels(Load()), 3u * 5 * 8);
}

TEST_F(TrainingSetTest, LeavesOutWhatMasksHide) {
  Write(TinyScene(16, 8));
  scene_.has_alpha = false;
  scene_.has_masks = true;
  const std::vector<int> training = scene_.ViewsOf(Split::kTrain);
  Image hidden = MakeImage(16, 8, 4);
  for (size_t i = 0; i < hidden.pixels.size(); i += 4) hidden.pixels[i] = 200;
  for (const int view : training) Replace(view, hidden);
  ExpectError<DataError>([&] { Load(); }, {"the masks leave no pixel of any training view"});

  Image image = hidden;
  for (int x = 12; x < 16; ++x) image.At(x, 7)[3] = uint8_t(kSeenAlpha - 14 + x);
  Replace(training[0], image);
  const TrainingSet set = Load();
  for (int i = 0; i < 16 * 8; ++i) {
    const bool seen = i % 16 >= 14 && i / 16 == 7;
    EXPECT_EQ(set.targets[0].rgba8[size_t(i)], seen ? 200u | 255u << 24 : kNotJudgedTarget);
  }
  ASSERT_FALSE(set.subject_blocks.empty());
  for (const uint32_t block : set.subject_blocks) EXPECT_EQ(set.blocks[block].view, 0u);
  EXPECT_LT(set.subject_blocks.size(), 16u * 8 / 8);
  // Nothing else is drawn, nor counts.
  EXPECT_EQ(LearnedBlocks(set).size(), set.subject_blocks.size());
  EXPECT_EQ(LearnedPixels(set), 8 * set.subject_blocks.size());
  for (const RayBlock& block : DrawBlocks(set, 200, 0.5, 1, 1)) EXPECT_EQ(block.view, 0u);
  TrainingSet without_masks = set;
  without_masks.has_masks = false;
  EXPECT_EQ(LearnedBlocks(without_masks).size(), set.blocks.size());
  EXPECT_EQ(LearnedPixels(without_masks), set.pixels);
}

TEST_F(TrainingSetTest, RefusesAPictureOfAnotherSizeThanItsCamera) {
  Write(TinyScene());
  const int view = scene_.ViewsOf(Split::kTrain)[2];
  Replace(view, MakeImage(31, 32, 4));
  ExpectError<DataError>([&] { Load(); }, {scene_.views[view].image, "31x32", "32x32"});
}

TEST_F(TrainingSetTest, RefusesMissingTinyAndNoPictures) {
  Write(TinyScene());
  ExpectError<DataError>([&] { LoadTrainingSet(folder_.path(), scene_, {}); }, {"training view"});
  const std::string image = scene_.views[scene_.ViewsOf(Split::kTrain)[1]].image;
  std::filesystem::remove(folder_.path() / image);
  ExpectError<DataError>([&] { Load(); }, {image});
  Write(TinyScene(3, 2));
  ExpectError<DataError>([&] { Load(); }, {"3x2", "too small"});
}

// View 0 is empty, view 1 shows something everywhere.
TrainingSet TwoViews(int width, int height) {
  TrainingSet set;
  for (uint32_t v = 0; v < 2; ++v) {
    set.targets.push_back({width, height, {}});
    set.targets[v].rgba8.assign(size_t(width) * height, v == 0 ? 0 : ~0u);
    set.blocks.Add(v, width, height);
  }
  for (size_t i = set.blocks.OfView(1).begin; i < set.blocks.size(); ++i) {
    set.subject_blocks.push_back(uint32_t(i));
  }
  return set;
}

TEST(DrawBlocks, DependsOnSeedAndIterationOnly) {
  const TrainingSet set = TwoViews(32, 32);
  const std::vector<RayBlock> first = DrawBlocks(set, 64, 0.85, 3, 17);
  ASSERT_EQ(first.size(), 64u);
  for (uint64_t iteration = 0; iteration < 17; ++iteration) {
    EXPECT_FALSE(Same(DrawBlocks(set, 64, 0.85, 3, iteration), first)) << iteration;
  }
  EXPECT_FALSE(Same(DrawBlocks(set, 64, 0.85, 4, 17), first));
  EXPECT_TRUE(Same(DrawBlocks(set, 64, 0.85, 3, 17), first));
}

TEST(SortByPlace, PutsBlocksOfOneTileOfOneViewTogether) {
  std::vector<RayBlock> blocks = {{1, 0, 0}, {0, 40, 0}, {0, 4, 30}, {0, 0, 40}, {0, 8, 2}};
  SortByPlace(blocks);
  const std::vector<RayBlock> expected = {{0, 8, 2}, {0, 4, 30}, {0, 40, 0}, {0, 0, 40}, {1, 0, 0}};
  EXPECT_TRUE(Same(blocks, expected));
}

TEST(SortByPlace, SortsByViewTileRowAndColumn) {
  std::mt19937 random(9);
  std::vector<RayBlock> blocks;
  for (const uint32_t size : {3u, 40u, 65'536u}) {
    for (int i = 0; i < 500; ++i) {
      const uint32_t view = i % 7 == 0 ? uint32_t(random()) : uint32_t(random() % 3);
      blocks.push_back({view, uint32_t(random() % size), uint32_t(random() % size)});
    }
  }
  std::vector<RayBlock> expected = blocks;
  std::ranges::sort(expected, {}, [](const RayBlock& block) {
    return std::tuple(block.view, block.y / 32, block.x / 32, block.y, block.x);
  });
  SortByPlace(blocks);
  EXPECT_TRUE(Same(blocks, expected));
  std::vector<RayBlock> outside = {{0, 65'536, 0}};
  EXPECT_THROW(SortByPlace(outside), BugError);
}

TEST(DrawBlocks, StaysInsideThePictures) {
  for (const auto& [width, height] : {std::pair{33, 31}, {4, 2}, {5, 3}, {32, 32}}) {
    const TrainingSet set = TwoViews(width, height);
    for (const RayBlock& block : DrawBlocks(set, 5000, 0.5, 1, 1)) {
      ASSERT_LT(block.view, 2u);
      ASSERT_LE(int(block.x), width - kRayBlockWidth);
      ASSERT_LE(int(block.y), height - kRayBlockHeight);
    }
  }
}

TEST(DrawBlocks, CoversEveryPixel) {
  const TrainingSet set = TwoViews(13, 7);
  std::vector<int> hits(13 * 7, 0);
  for (const RayBlock& block : DrawBlocks(set, 5000, 0.5, 1, 1)) {
    for (int i = 0; i < kRaysPerBlock; ++i) {
      ++hits[(block.y + size_t(i) / kRayBlockWidth) * 13 + block.x + size_t(i) % kRayBlockWidth];
    }
  }
  EXPECT_GT(*std::min_element(hits.begin(), hits.end()), 0);
}

TEST(DrawBlocks, TakesTheGivenShareFromTheSubject) {
  const TrainingSet set = TwoViews(32, 32);
  constexpr size_t kCount = 20000;
  for (const double share : {0.0, 0.3, 0.85, 1.0}) {
    size_t subject = 0;
    for (const RayBlock& block : DrawBlocks(set, kCount, share, 9, 2)) subject += block.view == 1;
    // Half of the other draws fall on the subject, too. Four standard deviations of the count.
    const double expected = share + 0.5 * (1 - share);
    const double margin = 4 * std::sqrt(kCount * expected * (1 - expected));
    EXPECT_NEAR(double(subject), kCount * expected, margin) << "share " << share;
  }
}

TEST(DrawTiles, OneIsARectangleOfWholeBlocksInsideOnePicture) {
  for (const auto& [width, height] : {std::pair{33, 31}, {4, 2}, {5, 3}, {64, 32}}) {
    const TrainingSet set = TwoViews(width, height);
    for (uint64_t iteration = 0; iteration < 200; ++iteration) {
      const std::vector<RayBlock> tile = DrawTiles(set, 1, 24, 0.5, 1, iteration).blocks;
      ASSERT_FALSE(tile.empty());
      const auto wider = std::find_if(tile.begin(), tile.end(),
                                      [&](const RayBlock& block) { return block.y != tile[0].y; });
      const size_t columns = size_t(wider - tile.begin());
      ASSERT_EQ(tile.size() % columns, 0u);
      for (size_t i = 0; i < tile.size(); ++i) {
        ASSERT_EQ(tile[i].view, tile[0].view);
        ASSERT_EQ(tile[i].x, tile[0].x + i % columns * kRayBlockWidth);
        ASSERT_EQ(tile[i].y, tile[0].y + i / columns * kRayBlockHeight);
        ASSERT_LE(int(tile[i].x), width - kRayBlockWidth);
        ASSERT_LE(int(tile[i].y), height - kRayBlockHeight);
      }
    }
  }
  // 24 blocks are 192 pixels: the side nearest to 13.9 is 12 pixels wide, 16 high.
  const std::vector<RayBlock> tile = DrawTiles(TwoViews(64, 32), 1, 24, 0.5, 1, 0).blocks;
  EXPECT_EQ(tile.size(), 24u);
  EXPECT_EQ(tile.back().x - tile[0].x, 8u);
}

TEST(DrawTiles, OneCoversEveryPixelThatBlocksCanCover) {
  const TrainingSet set = TwoViews(28, 20);
  std::vector<int> hits(28 * 20, 0);
  for (uint64_t iteration = 0; iteration < 500; ++iteration) {
    for (const RayBlock& block : DrawTiles(set, 1, 8, 0.5, 1, iteration).blocks) {
      for (int i = 0; i < kRaysPerBlock; ++i) {
        ++hits[(block.y + size_t(i) / kRayBlockWidth) * 28 + block.x + size_t(i) % kRayBlockWidth];
      }
    }
  }
  EXPECT_GT(*std::min_element(hits.begin(), hits.end()), 0);
}

TEST(DrawTiles, AreOfOneShapeInsideTheirPictures) {
  TrainingSet set = TwoViews(64, 32);
  const TrainingSet small = TwoViews(21, 19);
  set.targets[1] = small.targets[1];
  set.blocks = {};
  set.blocks.Add(0, 64, 32);
  set.blocks.Add(1, 21, 19);
  set.subject_blocks.resize(set.blocks.OfView(1).end - set.blocks.OfView(1).begin);
  std::iota(set.subject_blocks.begin(), set.subject_blocks.end(),
            uint32_t(set.blocks.OfView(1).begin));
  std::set<uint32_t> views;
  for (uint64_t iteration = 0; iteration < 50; ++iteration) {
    const auto [blocks, shape] = DrawTiles(set, 3, 128, 0.5, 1, iteration);
    // 32 x 32 pixels are requested; the smaller image has room for 5 columns and 9 rows of blocks.
    ASSERT_EQ(shape.columns, 5u);
    ASSERT_EQ(shape.rows, 9u);
    ASSERT_EQ(blocks.size(), 3u * 5 * 9);
    for (size_t i = 0; i < blocks.size(); ++i) {
      const RayBlock &block = blocks[i], &first = blocks[i - i % 45];
      views.insert(block.view);
      ASSERT_EQ(block.view, first.view);
      ASSERT_EQ(block.x, first.x + i % 5 * kRayBlockWidth);
      ASSERT_EQ(block.y, first.y + i % 45 / 5 * kRayBlockHeight);
      ASSERT_LE(int(block.x) + kRayBlockWidth, set.targets[block.view].width);
      ASSERT_LE(int(block.y) + kRayBlockHeight, set.targets[block.view].height);
    }
  }
  EXPECT_EQ(views.size(), 2u);
}

TEST(DrawBlocks, MovesABlockByLessThanItsSize) {
  TrainingSet set = TwoViews(32, 32);
  const std::vector<RayBlock> blocks = set.blocks.List();
  const auto there = std::ranges::find(blocks, std::tuple(1u, 16u, 10u), Key);
  set.subject_blocks = {uint32_t(there - blocks.begin())};
  std::set<std::pair<uint32_t, uint32_t>> offsets;
  for (const RayBlock& block : DrawBlocks(set, 1000, 1.0, 5, 0)) {
    ASSERT_EQ(block.view, 1u);
    ASSERT_LT(std::abs(int(block.x) - 16), kRayBlockWidth);
    ASSERT_LT(std::abs(int(block.y) - 10), kRayBlockHeight);
    offsets.insert({block.x, block.y});
  }
  EXPECT_EQ(offsets.size(), size_t((2 * kRayBlockWidth - 1) * (2 * kRayBlockHeight - 1)))
      << "every offset to either side";
}

TEST(DrawBlocks, DrawsFromEverywhereWhereNothingShows) {
  TrainingSet set = TwoViews(32, 32);
  set.subject_blocks.clear();
  std::set<uint32_t> views;
  for (const RayBlock& block : DrawBlocks(set, 200, 1.0, 5, 0)) views.insert(block.view);
  EXPECT_EQ(views.size(), 2u);
}

}  // namespace
}  // namespace tetrec
