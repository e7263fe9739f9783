// Tests --crop: a part of a picture has the same bits as in the whole, in every channel. It needs a device.
#include <algorithm>
#include <cstring>
#include <functional>
#include <iterator>

#include "base/files.h"
#include "base/text.h"
#include "editor/session/file/render_file.h"
#include "editor/session/file/render_file_impl.h"
#include "renderer/image/exr.h"
#include "renderer/image/image.h"
#include "tests/cli/animated_box.h"
#include "tests/cli/cli_test.h"
#include "tests/cli/program_runner.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::program_crop_test {
namespace {

using test::ProgramResult;
using test::RunProgram;

// Position and size are odd, and no multiple of any kind of tile.
constexpr passes::Region kCrop{7, 5, 13, 9};
constexpr const char* kCropOption = " --crop 7,5,13,9";

void Render(const test::TemporaryFolder& folder, const std::string& options) {
    const ProgramResult result = RunProgram(folder, "render " + options);
    EXPECT_EQ(result.exitCode, 0) << result.messages;
}

// A channel with words of sums, which a file omits if they are 0 in all of its pixels.
bool IsOfSums(const image::ExrChannel& channel) {
    return channel.name.find("sum") != std::string::npos || channel.name.find("squares") != std::string::npos;
}

// Expects that every sum of `part` equals the one at its place in `whole`.
void ExpectSumsOf(session::RenderFile&& whole, session::RenderFile&& part, const passes::Region& crop) {
    const std::vector<passes::ExactSums*> inWhole = session::AllOf(whole.sums),
                                          inPart = session::AllOf(part.sums);
    ASSERT_EQ(inPart.size(), inWhole.size());
    size_t different = 0, compared = 0;
    for (size_t i = 0; i < inPart.size(); ++i) {
        ASSERT_EQ(inPart[i]->IsEmpty(), inWhole[i]->IsEmpty());
        ASSERT_EQ(inPart[i]->HasSquares(), inWhole[i]->HasSquares());
        for (const auto planes : {&passes::ExactSums::sums, &passes::ExactSums::squares})
            for (size_t k = 0; k < passes::ExactSums::kPlanes; ++k) {
                const passes::ExactSums::Plane &some = (inPart[i]->*planes)[k],
                                               &all = (inWhole[i]->*planes)[k];
                for (size_t y = 0; !some.empty() && y < crop.height; ++y, ++compared)
                    different += std::memcmp(&some[4 * y * crop.width],
                                             &all[4 * ((y + crop.y) * whole.size.width + crop.x)],
                                             16 * crop.width) != 0;
            }
    }
    EXPECT_EQ(different, 0u) << "rows of sums";
    EXPECT_GT(compared, 0u);
}

// Expects that every other channel of `part` has the bits at its place in `whole`.
void ExpectPartOf(const image::ExrImage& whole, const image::ExrImage& part, const passes::Region& crop) {
    ASSERT_EQ(part.width, crop.width);
    ASSERT_EQ(part.height, crop.height);
    EXPECT_EQ(part.window, (image::ExrWindow{static_cast<int32_t>(crop.x), static_cast<int32_t>(crop.y),
                                             whole.width, whole.height}));
    EXPECT_EQ(whole.window, (image::ExrWindow{0, 0, whole.width, whole.height}));
    std::vector<image::ExrChannel> ofWhole, ofPart;
    std::ranges::copy_if(whole.channels, std::back_inserter(ofWhole), std::not_fn(IsOfSums));
    std::ranges::copy_if(part.channels, std::back_inserter(ofPart), std::not_fn(IsOfSums));
    ASSERT_EQ(ofPart.size(), ofWhole.size());
    for (size_t i = 0; i < ofPart.size(); ++i) {
        const image::ExrChannel &inPart = ofPart[i], &inWhole = ofWhole[i];
        ASSERT_EQ(inPart.name, inWhole.name);
        std::visit(
            [&](const auto& samples) {
                const auto& all = std::get<std::decay_t<decltype(samples)>>(inWhole.samples);
                size_t different = 0;
                for (size_t y = 0; y < crop.height; ++y)
                    different += std::memcmp(&samples[y * crop.width],
                                             &all[(y + crop.y) * whole.width + crop.x], 4 * crop.width) != 0;
                EXPECT_EQ(different, 0u) << "rows of " << inPart.name;
            },
            inPart.samples);
    }
}

// Renders the whole and the part with the options, and compares them.
void ExpectPartOfWhole(const std::string& options, const passes::Region& crop = kCrop) {
    SCOPED_TRACE(options);
    const test::TemporaryFolder folder;
    test::WriteBox(folder);
    const std::string common = options + " --size 30x21 --quiet -o ";
    Render(folder, common + "whole.exr");
    Render(folder, common + Text("part.exr --crop {},{},{},{}", crop.x, crop.y, crop.width, crop.height));
    const image::ExrImage whole = image::ReadExr(folder / "whole.exr");
    ASSERT_GT(whole.channels.size(), 4u);
    ExpectPartOf(whole, image::ReadExr(folder / "part.exr"), crop);
    if (std::ranges::any_of(whole.channels, IsOfSums))
        ExpectSumsOf(session::ReadRenderFile(folder / "whole.exr"),
                     session::ReadRenderFile(folder / "part.exr"), crop);
}

TEST(ProgramCrop, EveryChannelHasTheBitsOfTheWhole) {
    ExpectPartOfWhole("@cornell.gltf --spp 3 --aov all");
    ExpectPartOfWhole(
        "@cornell.gltf --spp 5 --aov all --sampler pcg --max-depth 3 --clamp-indirect 0.5 --aperture 0.1");
    ExpectPartOfWhole("@texture_coordinates_grid.gltf --spp 2 --aov all --texture-lod 0 --background 1,1,1");
    ExpectPartOfWhole(
        "@many_lights.gltf --spp 2 --aov all --light-group 'first=light [0-3]' --light-group shards=shards");
    ExpectPartOfWhole("@points_and_lines.gltf --spp 2 --points 1% --lines 0.5% --background 1,1,1 --aov all");
}

TEST(ProgramCrop, MotionHasTheBitsOfTheWhole) {
    ExpectPartOfWhole("box.gltf --spp 4 --at 0 --shutter 0:0.5 --aov all");
    ExpectPartOfWhole("box.gltf --spp 1 --at 0 --shutter 0:0.5 --aov motion --camera '0 1 4 0 1 0 0 1 0 3m'");
}

TEST(ProgramCrop, ItMayBeOnePixelInACornerOrTheWhole) {
    ExpectPartOfWhole("@cornell.gltf --spp 2", {29, 20, 1, 1});
    ExpectPartOfWhole("@cornell.gltf --spp 2", {0, 0, 30, 21});
}

TEST(ProgramCrop, ViewsByRaysHaveTheBitsOfTheWhole) {
    for (const char* view :
         {"albedo", "normals", "roughness", "metallic", "emissive", "wireframe", "ray-cost"})
        ExpectPartOfWhole(std::string("@cornell.gltf --spp 2 --view ") + view);
    for (const char* view : {"depth", "instance", "material"})
        ExpectPartOfWhole(std::string("@cornell.gltf --view ") + view);
}

TEST(ProgramCrop, PicturesForTheEyeHoldThePartAlone) {
    const test::TemporaryFolder folder;
    Render(folder, "@cornell.gltf --size 30x21 --spp 2 -o whole.png -o whole.hdr");
    Render(folder, std::string("@cornell.gltf --size 30x21 --spp 2 -o part.png -o part.hdr") + kCropOption);
    const auto expectPart = [&](const auto& whole, const auto& part) {
        ASSERT_EQ(part.width, kCrop.width);
        ASSERT_EQ(part.height, kCrop.height);
        for (uint32_t y = 0; y < kCrop.height; ++y)
            for (uint32_t i = 0; i < 4 * kCrop.width; ++i)
                ASSERT_EQ(part.rgba[4 * y * kCrop.width + i],
                          whole.rgba[4 * ((y + kCrop.y) * whole.width + kCrop.x) + i]);
    };
    const auto read = [&](const char* name) { return image::DecodeImage8(ReadFile(folder / name), name); };
    expectPart(read("whole.png"), read("part.png"));
    expectPart(image::ReadEnvironment(folder / "whole.hdr").image,
               image::ReadEnvironment(folder / "part.hdr").image);
}

TEST(ProgramCrop, AsAMapItStandsWhereItBelongs) {
    const test::TemporaryFolder folder;
    const std::string scene = "@cornell.gltf --size 30x21 --spp 2 --background 1,2,3 --quiet -o ";
    Render(folder, scene + "whole.exr");
    Render(folder, scene + "part.exr" + kCropOption);
    const image::ImageF whole = image::ReadEnvironment(folder / "whole.exr").image;
    const image::ImageF part = image::ReadEnvironment(folder / "part.exr").image;
    ASSERT_EQ(part.width, 30u);
    ASSERT_EQ(part.height, 21u);
    for (uint32_t i = 0; i < 30 * 21; ++i) {
        const uint32_t x = i % 30, y = i / 30;
        const bool isInside =
            x >= kCrop.x && x < kCrop.x + kCrop.width && y >= kCrop.y && y < kCrop.y + kCrop.height;
        for (uint32_t c = 0; c < 3; ++c)
            ASSERT_EQ(part.rgba[4 * i + c], isInside ? whole.rgba[4 * i + c] : 0.0f) << x << ", " << y;
    }
    Render(folder, "@cornell.gltf --size 8x8 --spp 1 --quiet --env part.exr -o lit.exr");
}

TEST(ProgramCrop, ItIsRecordedResumedAndMerged) {
    const test::TemporaryFolder folder;
    const std::string scene = "@cornell.gltf --aov albedo,depth --max-depth 4 --quiet ";
    const std::string cropped = scene + "--size 30x21" + kCropOption;
    Render(folder, cropped + " --spp 3 -o a.exr");
    Render(folder, cropped + " --spp 8 -o all.exr");
    Render(folder, "@cornell.gltf --resume a.exr --spp 8 --quiet -o resumed.exr");
    Render(folder, cropped + " --spp 5 --sample-offset 3 -o b.exr");
    ASSERT_EQ(RunProgram(folder, "merge a.exr b.exr -o merged.exr").exitCode, 0);
    const image::ExrImage all = image::ReadExr(folder / "all.exr");
    for (const char* name : {"resumed.exr", "merged.exr"}) {
        SCOPED_TRACE(name);
        const image::ExrImage other = image::ReadExr(folder / name);
        EXPECT_EQ(other.window, all.window);
        ASSERT_EQ(other.channels.size(), all.channels.size());
        for (size_t i = 0; i < all.channels.size(); ++i)
            EXPECT_EQ(other.channels[i].samples, all.channels[i].samples) << all.channels[i].name;
    }
    EXPECT_EQ(session::ReadRenderFile(folder / "merged.exr").settings.at("crop"), "7,5,13,9");

    // A crop of the same size elsewhere
    Render(folder, scene + "--size 30x21 --crop 8,5,13,9 --spp 5 --sample-offset 3 -o c.exr");
    const ProgramResult merge = RunProgram(folder, "merge a.exr c.exr -o x.exr");
    EXPECT_EQ(merge.exitCode, 4);
    EXPECT_EQ(merge.messages, "raygraph: a.exr and c.exr differ: crop: 7,5,13,9 against 8,5,13,9\n");
    const ProgramResult resume =
        RunProgram(folder, "render @cornell.gltf --resume a.exr --spp 8 --crop 8,5,13,9");
    EXPECT_EQ(resume.exitCode, 2);
    EXPECT_EQ(resume.messages, "raygraph: --crop 8,5,13,9: a.exr was rendered with 7,5,13,9\n");
}

TEST(ProgramCrop, WhatIsNotAPartOfThePictureIsRefused) {
    const test::TemporaryFolder folder;
    const auto refusal = [&](const std::string& options) {
        const ProgramResult result = RunProgram(folder, "render @cornell.gltf --size 30x21 " + options);
        EXPECT_EQ(result.exitCode, 2) << options;
        EXPECT_FALSE(std::filesystem::exists(folder / "render.png"));
        return result.messages;
    };
    EXPECT_EQ(refusal("--crop 18,5,13,9"),
              "raygraph: --crop: a region of 13x9 pixels from 18, 5 on, in a picture of 30x21\n");
    EXPECT_NE(refusal("--crop 0,20,1,2").find("in a picture of 30x21"), std::string::npos);
    for (const char* text : {"1,2,3", "1,2,3,4,5", "1,2,0,4", "1,2,3,0", "-1,2,3,4", "a,b,c,d", "1;2;3;4"})
        EXPECT_NE(refusal(std::string("--crop ") + text).find("is not X,Y,W,H"), std::string::npos) << text;
    for (const char* view : {"raster", "overdraw"})
        EXPECT_NE(refusal(std::string("--crop 0,0,4,4 --view ") + view).find("drawn as a whole"),
                  std::string::npos);
}

}  // namespace
}  // namespace raygraph::program_crop_test
