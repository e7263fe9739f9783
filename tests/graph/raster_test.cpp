// Raster passes: state, targets, depth, loads.
#include <gmock/gmock.h>

#include "shaders/shared/draw_records.h"
#include "tests/graph/graph_test.h"
#include "tests/support/error_of.h"
#include "tests/support/option_rows.h"

namespace raygraph::raster_test {
namespace {

using ::testing::ElementsAre;

constexpr Extent2D kExtent{32, 32};

class Raster : public GraphTest {
  protected:
    Raster() {
        m_renderer.AddShader("test/triangles.vert", CompileText("test/triangles.vert", R"(
struct Vertex { vec2 position; float depth; };
layout(binding = 0, scalar) readonly buffer Vertices { Vertex vertices[]; };
void main() {
    Vertex vertex = vertices[gl_VertexIndex];
    gl_Position = vec4(vertex.position, vertex.depth, 1.0);
})"));
        m_renderer.AddShader("test/color.frag", CompileText("test/color.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { vec4 color; } constants;
void main() { color = constants.color; })"));
    }

    struct Vertex {
        float x, y, depth;
    };
    struct Color {
        float r, g, b, a;
    };
    // The left upper half of the picture, at a depth.
    static std::vector<Vertex> Corner(float depth) {
        return {{-1, -1, depth}, {1, -1, depth}, {-1, 1, depth}};
    }
    static std::vector<Vertex> Everything(float depth) {
        return {{-1, -1, depth}, {3, -1, depth}, {-1, 3, depth}};
    }

    static TextureId Draw(Renderer& renderer, TextureId target, TextureId* depth, BufferId vertices,
                          const Color& color, bool clear, const RasterState& state = {}) {
        renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag").Raster(state);
                pass.Reads("Vertices", vertices);
                pass.Constants(color);
                target = pass.ColorTarget(0, target, {.clear = clear, .value = {0.25f, 0.25f, 0.25f, 1.0f}});
                if (depth) *depth = pass.DepthTarget(*depth, {.clear = clear});
            },
            [](CommandList& commands) { commands.Draw(3); });
        return target;
    }
};

TEST_F(Raster, TriangleByVertexPulling_CoversItsHalf) {
    testing::PassHarness harness(Device());
    harness.Graph().AddShader("test/triangles.vert", CompileText("test/triangles.vert", R"(
struct Vertex { vec2 position; float depth; };
layout(binding = 0, scalar) readonly buffer Vertices { Vertex vertices[]; };
void main() { gl_Position = vec4(vertices[gl_VertexIndex].position, vertices[gl_VertexIndex].depth, 1.0); })"));
    harness.Graph().AddShader("test/color.frag", CompileText("test/color.frag", R"(
layout(location = 0) out vec4 color;
layout(push_constant, std430) uniform Constants { vec4 color; } constants;
void main() { color = constants.color; })"));
    const testing::Texels texels = harness.Run([](testing::PassHarness& h) {
        const BufferId vertices = h.Buffer("vertices", Corner(0.5f));
        const TextureId target =
            h.Graph().CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
        return Draw(h.Graph(), target, nullptr, vertices, {1.0f, 0.0f, 0.0f, 1.0f}, true);
    });
    EXPECT_THAT(texels.At(2, 2), ElementsAre(1.0f, 0.0f, 0.0f, 1.0f));
    EXPECT_THAT(texels.At(30, 30), ElementsAre(64 / 255.0f, 64 / 255.0f, 64 / 255.0f, 1.0f));
}

TEST_F(Raster, DepthTest_KeepsWhatIsNearer) {
    m_renderer.BeginFrame();
    const auto upload = [&](std::string_view name, const std::vector<Vertex>& vertices) {
        const BufferId buffer = m_renderer.CreateBuffer(
            name, {.size = vertices.size() * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
        m_renderer.AddPass(
            "Write " + std::string(name), PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(buffer);
                pass.KeepAlive();
            },
            [buffer, vertices](CommandList&, const PassResources& resources) {
                std::ranges::copy(std::as_bytes(std::span(vertices)),
                                  resources.Buffer(buffer).Mapped().begin());
            });
        return buffer;
    };
    const BufferId nearCorner = upload("near", Corner(0.2f));
    const BufferId farAll = upload("far", Everything(0.8f));
    TextureId depth = m_renderer.CreateTexture("depth", {.extent = kExtent, .format = Format::D32Float});
    TextureId color = m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
    color = Draw(m_renderer, color, &depth, nearCorner, {1, 0, 0, 1}, true);
    color = Draw(m_renderer, color, &depth, farAll, {0, 1, 0, 1}, false);
    const Readback colors = m_renderer.ReadBack(color);
    const Readback depths = m_renderer.ReadBack(depth);
    m_renderer.Execute();
    EXPECT_THAT(Read(colors).At(2, 2), ElementsAre(1.0f, 0.0f, 0.0f, 1.0f));
    EXPECT_THAT(Read(colors).At(30, 30), ElementsAre(0.0f, 1.0f, 0.0f, 1.0f));
    EXPECT_THAT(Read(depths).At(2, 2), ElementsAre(0.2f));
    EXPECT_THAT(Read(depths).At(30, 30), ElementsAre(0.8f));
}

TEST_F(Raster, BlendedDraws_AddUp) {
    m_renderer.BeginFrame();
    TextureId color = m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba32Float});
    BufferId vertices =
        m_renderer.CreateBuffer("vertices", {.size = 3 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
    m_renderer.AddPass(
        "Write", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(vertices);
            pass.KeepAlive();
        },
        [vertices](CommandList&, const PassResources& resources) {
            const std::vector<Vertex> all = Everything(0.5f);
            std::ranges::copy(std::as_bytes(std::span(all)), resources.Buffer(vertices).Mapped().begin());
        });
    for (int i = 0; i < 3; ++i)
        color = Draw(m_renderer, color, nullptr, vertices, {1.0f, 2.0f, 0.0f, 0.0f}, i == 0,
                     {.blend = rhi::BlendMode::Additive});
    const Readback readback = m_renderer.ReadBack(color);
    m_renderer.Execute();
    EXPECT_EQ(Read(readback).At(5, 5)[0], 3.25f);
    EXPECT_EQ(Read(readback).At(5, 5)[1], 6.25f);
}

TEST_F(Raster, DrawIndirect_DrawsItsRangeOfCommandsAndRefusesOneBeyondTheEnd) {
    const auto draw = [&](uint32_t first, uint32_t count) {
        m_renderer.BeginFrame();
        TextureId color =
            m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
        const BufferId vertices = m_renderer.CreateBuffer(
            "vertices", {.size = 6 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload});
        const BufferId commands = m_renderer.CreateBuffer(
            "commands", {.size = 2 * sizeof(gpu::DrawCommand), .memory = rhi::MemoryKind::Upload});
        m_renderer.AddPass(
            "Write", PassKind::Transfer,
            [&](PassBuilder& pass) {
                pass.CopiesFrom(vertices);
                pass.CopiesFrom(commands);
                pass.KeepAlive();
            },
            [vertices, commands](CommandList&, const PassResources& resources) {
                std::vector<Vertex> all = Corner(0.5f);  // the upper left half, then the other
                for (const Vertex& vertex : Corner(0.5f)) all.push_back({-vertex.x, -vertex.y, 0.5f});
                const std::vector<gpu::DrawCommand> list{{3, 1, 0, 0}, {3, 1, 3, 0}};
                std::ranges::copy(std::as_bytes(std::span(all)), resources.Buffer(vertices).Mapped().begin());
                std::ranges::copy(std::as_bytes(std::span(list)),
                                  resources.Buffer(commands).Mapped().begin());
            });
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                pass.Reads("Vertices", vertices);
                pass.ReadsArguments(commands);
                pass.Constants(Color{1, 1, 1, 1});
                color = pass.ColorTarget(0, color);
            },
            [=](CommandList& list, const PassResources& resources) {
                list.DrawIndirect(resources.Buffer(commands), first, count);
            });
        const Readback readback = m_renderer.ReadBack(color);
        m_renderer.Execute();
        const auto texels = Read(readback);
        return std::pair(texels.At(2, 2)[0], texels.At(29, 29)[0]);
    };
    EXPECT_EQ(draw(0, 1), std::pair(1.0f, 0.0f));
    EXPECT_EQ(draw(1, 1), std::pair(0.0f, 1.0f));
    EXPECT_EQ(draw(0, 2), std::pair(1.0f, 1.0f));
    EXPECT_EQ(draw(2, 0), std::pair(0.0f, 0.0f));
    EXPECT_EQ(testing::ErrorTextOf([&] { draw(1, 2); }),
              "DrawIndirect: draws 1 to 3 of 'commands', which holds 2");
}

struct StateRow {
    const char* name;
    void (*change)(RasterState&);
};
using rhi::BlendMode;
using rhi::CullMode;
using rhi::DepthCompare;
using rhi::Topology;
// Each row of kStates changes the picture that DrawnWith draws with kState.
constexpr RasterState kState{.cull = CullMode::Back};
const StateRow kStates[] = {
    {"strip", [](RasterState& s) { s.topology = Topology::TriangleStrip; }},
    {"lines", [](RasterState& s) { s.topology = Topology::LineList; }},
    {"points", [](RasterState& s) { s.topology = Topology::PointList; }},
    {"both sides", [](RasterState& s) { s.cull = CullMode::None; }},
    {"the other side", [](RasterState& s) { s.cull = CullMode::Front; }},
    {"the other front", [](RasterState& s) { s.isFrontClockwise = true; }},
    {"always", [](RasterState& s) { s.depthCompare = DepthCompare::Always; }},
    {"less", [](RasterState& s) { s.depthCompare = DepthCompare::Less; }},
    {"equal", [](RasterState& s) { s.depthCompare = DepthCompare::Equal; }},
    {"greater", [](RasterState& s) { s.depthCompare = DepthCompare::Greater; }},
    {"greater or equal", [](RasterState& s) { s.depthCompare = DepthCompare::GreaterOrEqual; }},
    {"no depth is written", [](RasterState& s) { s.writesDepth = false; }},
    {"alpha", [](RasterState& s) { s.blend = BlendMode::Alpha; }},
    {"premultiplied", [](RasterState& s) { s.blend = BlendMode::Premultiplied; }},
    {"additive", [](RasterState& s) { s.blend = BlendMode::Additive; }},
    {"wireframe", [](RasterState& s) { s.isWireframe = true; }},
};

class RasterStates : public testing::VulkanTest {
  protected:
    static void AddShaders(Renderer& renderer) {
        // Draws four overlapping triangles. The first three have the same winding; the second is behind the
        // first, the third at the same depth as the first. The fourth has the opposite winding.
        renderer.AddShader("test/four.vert", CompileText("test/four.vert", R"(
layout(location = 0) flat out vec4 color;
const vec2 kCorners[3] = vec2[](vec2(-0.9), vec2(-0.9, 0.9), vec2(0.9, -0.9));
const float kDepths[4] = float[](0.5, 0.75, 0.5, 0.25);
const vec4 kColors[4] =
    vec4[](vec4(1, 0, 0, 0.5), vec4(0, 1, 0, 0.5), vec4(0, 0, 1, 0.5), vec4(1, 1, 0, 0.25));
void main() {
    int triangle = gl_VertexIndex / 3, corner = gl_VertexIndex % 3;
    vec2 place = kCorners[triangle == 3 && corner > 0 ? 3 - corner : corner];
    gl_Position = vec4(place + 0.1 * float(triangle), kDepths[triangle], 1.0);
    gl_PointSize = 1.0;
    color = kColors[triangle];
})"));
        renderer.AddShader("test/flat.frag", CompileText("test/flat.frag", R"(
layout(location = 0) flat in vec4 color;
layout(location = 0) out vec4 result;
void main() { result = color; })"));
    }
    static std::vector<float> DrawnWith(Renderer& renderer, const RasterState& state) {
        renderer.BeginFrame();
        TextureId target =
            renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba32Float});
        TextureId depth = renderer.CreateTexture("depth", {.extent = kExtent, .format = Format::D32Float});
        renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/four.vert").Fragment("test/flat.frag").Raster(state);
                target = pass.ColorTarget(0, target, {.value = {0.25f, 0.25f, 0.25f, 1.0f}});
                depth = pass.DepthTarget(depth);
            },
            [](CommandList& commands) { commands.Draw(12); });
        const Readback readback = renderer.ReadBack(target);
        renderer.Execute();
        readback.Wait();
        return testing::As<float>(readback.Bytes());
    }
};

// If pipelines were looked up without a part of the state, both passes would draw one pipeline's picture.
TEST_F(RasterStates, PassesThatDifferInOnePartOfIt_DrawAsEachDoesAlone) {
    Renderer both(Device());
    AddShaders(both);
    const std::vector<float> plain = DrawnWith(both, kState);
    auto rows = testing::OptionRowsOf<RasterState>([](RasterState& s) {
        auto& [topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe] = s;
        return std::tie(topology, cull, isFrontClockwise, depthCompare, writesDepth, blend, isWireframe);
    });
    for (const StateRow& row : kStates) {
        SCOPED_TRACE(row.name);
        RasterState state = kState;
        row.change(state);
        rows.Add(row.name, kState, state);
        if (state.isWireframe && !Device().Info().optional.wireframe) continue;
        Renderer alone(Device());
        AddShaders(alone);
        const std::vector<float> picture = DrawnWith(both, state);
        EXPECT_NE(picture, plain);
        EXPECT_EQ(picture, DrawnWith(alone, state));
        EXPECT_EQ(DrawnWith(both, kState), plain);
    }
    rows.ExpectComplete();
}

TEST_F(Raster, ConstantsWithOneValueTooMany_AreRefused) {
    m_renderer.BeginFrame();
    const TextureId color =
        m_renderer.CreateTexture("color", {.extent = kExtent, .format = Format::Rgba8Unorm});
    const auto add = [&] {
        m_renderer.AddPass(
            "Draw", PassKind::Raster,
            [&](PassBuilder& pass) {
                pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                pass.Reads("Vertices",
                           m_renderer.CreateBuffer(
                               "vertices", {.size = 3 * sizeof(Vertex), .memory = rhi::MemoryKind::Upload}));
                pass.Constants(std::array<float, 5>{});
                [[maybe_unused]] const TextureId drawn = pass.ColorTarget(0, color, {.clear = true});
            },
            [](CommandList& commands) { commands.Draw(3); });
    };
    EXPECT_EQ(testing::ErrorTextOf(add),
              R"(pass "Draw" gives 20 bytes of constants; test/color.frag has 16 bytes of push constants)");
}

TEST_F(Raster, TargetsThatDoNotFit_AreRefused) {
    const auto message = [&](Extent2D second, Format format) {
        m_renderer.BeginFrame();
        TextureId a = m_renderer.CreateTexture("a", {.extent = kExtent, .format = Format::Rgba8Unorm});
        TextureId b = m_renderer.CreateTexture("b", {.extent = second, .format = format});
        return testing::ErrorTextOf([&] {
            m_renderer.AddPass(
                "Draw", PassKind::Raster,
                [&](PassBuilder& pass) {
                    pass.Vertex("test/triangles.vert").Fragment("test/color.frag");
                    a = pass.ColorTarget(0, a);
                    b = pass.DepthTarget(b);
                },
                [](CommandList&) {});
        });
    };
    EXPECT_EQ(message({8, 8}, Format::D32Float), R"(pass "Draw" draws to "a" of 32x32 and to "b" of 8x8)");
    EXPECT_EQ(message(kExtent, Format::Rgba8Unorm), R"(pass "Draw" has "b" of format rgba8 as depth target)");
}

}  // namespace
}  // namespace raygraph::raster_test
