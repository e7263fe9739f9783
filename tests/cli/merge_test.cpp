#include "editor/session/file/merge.h"

#include "renderer/image/exr.h"
#include "tests/cli/cli_test.h"
#include "tests/support/temporary_folder.h"

namespace raygraph::session::merge_test {
namespace {

using test::ExpectError;
using test::MakeRender;

void ExpectSameBits(const RenderFile& a, const RenderFile& b) {
    EXPECT_EQ(a.samples, b.samples);
    EXPECT_EQ(a.radiance, b.radiance);
    EXPECT_EQ(a.variance, b.variance);
    EXPECT_EQ(a.albedo, b.albedo);
    EXPECT_EQ(a.normal, b.normal);
    EXPECT_EQ(a.sums.radiance, b.sums.radiance);
    EXPECT_EQ(a.sums.albedo, b.sums.albedo);
}

TEST(Merge, HasTheBitsOfOneRenderOfAllSamplesInAnyOrder) {
    const RenderFile whole = MakeRender(0, 8);
    const RenderFile a = MakeRender(0, 1), b = MakeRender(1, 2), c = MakeRender(3, 5);
    ExpectSameBits(Merge({{"a", a}, {"b", b}, {"c", c}}), whole);
    ExpectSameBits(Merge({{"c", c}, {"a", a}, {"b", b}}), whole);
    ExpectSameBits(Merge({{"a", a}, {"bc", Merge({{"c", c}, {"b", b}})}}), whole);
    ExpectSameBits(Merge({{"b", MakeRender(20, 44)}, {"a", MakeRender(0, 19)}, {"c", MakeRender(19, 1)}}),
                   MakeRender(0, 64));
}

// Files of earlier versions record how rays were traced, which changes no picture.
TEST(Merge, SettingsThatAreNoneAnyMoreAreLeftOut) {
    const test::TemporaryFolder folder;
    const RenderFile written = MakeRender(0, 4);
    WriteRenderFile(folder / "a.exr", written);
    image::ExrImage file = image::ReadExr(folder / "a.exr");
    file.attributes["raygraph.setting.traversal"] = "own";
    file.attributes["raygraph.setting.integrator-form"] = "wavefront:4";
    image::WriteExr(folder / "a.exr", file);
    const RenderFile read = ReadRenderFile(folder / "a.exr");
    EXPECT_EQ(read.settings, written.settings);
    EXPECT_EQ(FirstMismatch(read, written), "");
    file.attributes["raygraph.setting.wavelength"] = "500";
    image::WriteExr(folder / "a.exr", file);
    EXPECT_THROW(std::ignore = ReadRenderFile(folder / "a.exr"), Error);
}

TEST(Merge, APartThatIsRefusedLeavesTheOthers) {
    Merger merger;
    ExpectError(
        ErrorKind::Usage, [&] { merger.Take(); }, "no renders");
    merger.Add({"b", MakeRender(3, 5)});
    merger.Add({"a", MakeRender(0, 2)});
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            merger.Add({"again", MakeRender(1, 2)});
        },
        "a and again", "0-1 and 1-2");
    RenderFile other = MakeRender(2, 1);
    other.settings["seed"] = "10";
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            merger.Add({"other", other});
        },
        "b and other differ");
    merger.Add({"c", MakeRender(2, 1)});
    ExpectSameBits(merger.Take(), MakeRender(0, 8));
    ExpectError(
        ErrorKind::Usage, [&] { merger.Take(); }, "no renders");
    merger.Add({"d", MakeRender(1, 2)});
    ExpectSameBits(merger.Take(), MakeRender(1, 2));
}

TEST(Merge, RemovedLightIsWeighedByTheSamplesTracedTwice) {
    const auto part = [](uint32_t first, const std::vector<float>& removed) {
        RenderFile render = MakeRender(first, 8);
        passes::ExactSums& sums = render.sums.removed[1];
        sums = passes::MakeExactSums(PixelCount(render.size), true);
        for (const float value : removed) passes::AddSample(sums, Texels(render.radiance.size(), value));
        render.removedSamples = static_cast<uint32_t>(removed.size());
        render.removed[1] = render.removedVariance[1] = Texels(render.radiance.size(), 0.0f);
        return render;
    };
    const RenderFile merged = Merge({{"a", part(0, {2})}, {"b", part(8, {})}, {"c", part(16, {3, 4, 5})}});
    EXPECT_EQ(merged.removedSamples, 4u);
    EXPECT_FLOAT_EQ(merged.removed[1][5], 3.5f);
    EXPECT_FLOAT_EQ(merged.removedVariance[1][5], 5.0f / 3.0f);
    EXPECT_TRUE(merged.removed[0].empty());
    EXPECT_EQ(Merge({{"a", part(0, {})}, {"b", part(8, {})}}).removed[1][5], 0.0f);
}

TEST(Merge, WhatHasNoSumsIsNamed) {
    RenderFile other = MakeRender(8, 8);
    other.sums = {};
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
        },
        "b.exr", "no channel sum0.R");
    other = MakeRender(8, 8);
    other.sums.albedo = other.sums.normal = {};  // as saved by the editor
    ExpectError(
        ErrorKind::BadInput,
        [&] {
            Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
        },
        "b.exr", "no channel albedo.sum0.R", "resume it once");
}

TEST(Merge, RendersThatNoReaderCheckedAreRefused) {
    ExpectError(
        ErrorKind::Usage, [] { Merge({}); }, "no renders");
    const auto expectRefused = [](auto&& change, const char* part) {
        RenderFile other = MakeRender(8, 8);
        change(other);
        ExpectError(
            ErrorKind::BadInput,
            [&] {
                Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}});
            },
            "b.exr", part);
    };
    expectRefused([](RenderFile& r) { r.samples.clear(); }, "it has no samples");
    expectRefused([](RenderFile& r) { r.sums.radiance = passes::MakeExactSums(4, true); },
                  "sums of radiance");
    expectRefused([](RenderFile& r) { r.sums.lightGroups.resize(2); }, "groups of lights");
}

TEST(Merge, KeepsTheListOfSeparateRanges) {
    const RenderFile merged =
        Merge({{"a", MakeRender(100, 10)}, {"b", MakeRender(0, 10)}, {"c", MakeRender(10, 5)}});
    EXPECT_EQ(merged.samples, (SampleRanges{{0, 15}, {100, 10}}));
}

TEST(Merge, DepthAndIdsAreThoseOfTheFirstSamples) {
    RenderFile other = MakeRender(8, 8);
    other.depth.assign(other.depth.size(), 3.0f);
    other.instance.assign(other.instance.size(), 5);
    const RenderFile first = MakeRender(0, 8), merged = Merge({{"b", other}, {"a", first}});
    EXPECT_EQ(merged.depth, first.depth);
    EXPECT_EQ(merged.instance, first.instance);
}

TEST(Merge, OverlapNamesBothFilesAndRanges) {
    ExpectError(
        ErrorKind::BadInput,
        [] {
            Merge(
                {{"a.exr", MakeRender(0, 32)}, {"b.exr", MakeRender(64, 8)}, {"c.exr", MakeRender(31, 32)}});
        },
        "a.exr", "c.exr", "0-31", "31-62");
}

TEST(Merge, DifferentPicturesAreRefusedNamingTheDifference) {
    const auto merge = [](auto change) {
        RenderFile other = MakeRender(8, 8);
        change(other);
        return [other] { Merge({{"a.exr", MakeRender(0, 8)}, {"b.exr", other}}); };
    };
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["seed"] = "10"; }), "a.exr",
                "b.exr", "seed: 9 against 10");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.settings["size"] = "3x5"; }),
                "size: 5x3 against 3x5");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneFile = "ball.gltf"; }),
                "scene: box.gltf against ball.gltf");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash = "other"; }),
                "box.gltf has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.sceneHash.clear(); }),
                "box.gltf was saved by the editor");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentFile.clear(); }),
                "environment: sky.hdr against none");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.environmentHash.clear(); }),
                "sky.hdr has changed");
    ExpectError(ErrorKind::BadInput, merge([](RenderFile& r) { r.albedo.clear(); }),
                "a.exr has the channels of albedo, b.exr has not");
}

}  // namespace
}  // namespace raygraph::session::merge_test
