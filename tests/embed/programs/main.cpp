// host CORNELL CLOSED_BOX: a host engine that shows two scenes in images of its own with the installed
// package, edits one of them, and uses our passes on what it has drawn itself. Exits with 1 and one line when
// a picture or a count is not what it must be.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdio>
#include <exception>
#include <memory>
#include <stdexcept>

#include "base/version.h"
#include "editor/viewport/viewport.h"
#include "editor/viewport/vulkan_interop.h"
#include "gpu.h"
#include "passes/compare.h"
#include "renderer/gpu_scene/host_objects.h"
#include "renderer/scene/gltf/load_gltf.h"

using namespace raygraph;  // NOLINT: the example reads better

namespace {

constexpr Extent2D kExtent{64, 64};
constexpr VkExtent2D kVkExtent{kExtent.width, kExtent.height};
constexpr uint32_t kTallBlock = 2;          // instance of the Cornell box
constexpr glm::uvec2 kOnTallBlock{25, 38};  // a pixel that shows it
using Picture = std::vector<Texel>;

void Require(bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error("host: " + what);
}

std::unique_ptr<rhi::Device> Adopt(Gpu& gpu) {
    rhi::AdoptedDeviceDesc desc;
    desc.instance = gpu.instance;
    desc.physicalDevice = gpu.physicalDevice;
    desc.device = gpu.device;
    desc.queue = gpu.queue;
    desc.queueFamily = gpu.queueFamily;
    desc.getInstanceProcAddr = vkGetInstanceProcAddr;
    desc.enabledExtensions = gpu.extensions;
    desc.enabledFeatures = rhi::OptionalFeaturesOf(gpu.physicalDevice, vkGetInstanceProcAddr, gpu.instance);
    desc.log = Log(
        [&gpu](const LogMessage& message) {  // on any thread that calls into the library
            const std::lock_guard lock(gpu.messageLock);
            gpu.messages.push_back(std::string(message.category) + ": " + std::string(message.text));
        },
        LogLevel::Info);
    desc.lockQueue = [&gpu] { gpu.queueLock.lock(); };  // since other threads of a host submit, too
    desc.unlockQueue = [&gpu] { gpu.queueLock.unlock(); };
    auto device = rhi::Device::Adopt(desc);
    Require(gpu.messages.size() == 1 && gpu.messages[0].starts_with("device: device 'host': "),
            "the library does not say which device it has, or says more");
    return device;
}

// Holds a scene, a viewport on it, and the host's image in which it is shown.
struct Panel {
    Panel(Gpu& gpu, Renderer& renderer, const char* name, const char* file)
        : scene(renderer),
          viewport(renderer, scene, {.name = name, .size = kExtent}),
          image(gpu.MakePicture(kVkExtent)),
          target(renderer.Device(), {.name = name,
                                     .image = image,
                                     .extent = kExtent,
                                     .layoutAfter = VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL}) {
        scene::SceneData data = scene::LoadGltf(file);
        viewport.SetCamera(scene::ChooseView(data, "", 1.0f));
        viewport.SetRaster(
            {.shadows = passes::RasterShadows::Off, .hasOcclusion = false, .hasTransmission = false});
        scene.SetScene(std::move(data));
    }
    uint32_t Samples() const { return viewport.Progress().pathTracedSamples; }

    GpuScene scene;
    viewport::Viewport viewport;
    VkImage image;
    viewport::HostImage target;
};

// Returns the semaphores for our submission in the host's order of turns.
viewport::HostSemaphores TakeTurn(Gpu& gpu) {
    const uint64_t before = gpu.turn++;
    return {.wait = {{gpu.timeline, before}}, .signal = {{gpu.timeline, gpu.turn}}};
}

using OwnPass = std::function<TextureId(TextureId shown)>;

// Draws a frame of a single panel, with a pass of the host's own on its picture.
Picture Show(Gpu& gpu, Renderer& renderer, Panel& panel, const OwnPass& ownPass = {}) {
    renderer.BeginFrame();
    TextureId shown = panel.viewport.Declare();
    if (ownPass) shown = ownPass(shown);
    panel.target.Show(renderer, shown, TakeTurn(gpu));
    renderer.Execute();
    return gpu.Read(panel.image, kVkExtent);
}

// Returns how much redder than green the columns [first, last) are, in 8-bit steps.
double Redness(const Picture& picture, uint32_t first, uint32_t last) {
    double sum = 0.0;
    for (uint32_t y = 0; y < kExtent.height; ++y)
        for (uint32_t x = first; x < last; ++x) {
            const Texel& texel = picture[size_t{y} * kExtent.width + x];
            sum += double(texel[0]) - double(texel[1]);
        }
    return sum / (double(last - first) * kExtent.height);
}

void RequireCornell(const Picture& picture, const std::string& view) {
    const double left = Redness(picture, 2, 8), right = Redness(picture, 56, 62);
    Require(left > 15.0 && right < -4.0, view + ": redness " + std::to_string(left) + " at the left and " +
                                             std::to_string(right) + " at the right wall");
}

// Requires gray that is nowhere dark, since the radiance is the same from everywhere.
void RequireClosedBox(const Picture& picture) {
    for (const Texel& texel : picture)
        Require(texel[0] == texel[1] && texel[1] == texel[2] && texel[0] > 64, "the closed box is not gray");
}

void ToggleViews(Gpu& gpu, Renderer& renderer, Panel& cornell) {
    for (int i = 0; i < 16; ++i) RequireCornell(Show(gpu, renderer, cornell), "path-traced");
    Require(cornell.Samples() == 16, "a frame is not a sample");
    cornell.viewport.SetView(viewport::View::Raster);
    RequireCornell(Show(gpu, renderer, cornell), "raster");
    Require(cornell.Samples() == 16, "the raster view has touched the accumulation");
    cornell.viewport.SetView(viewport::View::PathTraced);
    RequireCornell(Show(gpu, renderer, cornell), "path-traced again");
    Require(cornell.Samples() == 17,
            "toggling has left " + std::to_string(cornell.Samples()) + " samples of 17");
}

viewport::PickResult PickAt(Gpu& gpu, Renderer& renderer, Panel& panel, glm::uvec2 pixel) {
    const viewport::Pick pick = panel.viewport.RequestPick(pixel);
    Show(gpu, renderer, panel);  // also waits for the frame
    return pick.Result();
}

// In the raster view, only pixels where the block was may change; the path-traced view, which is not shown
// meanwhile, restarts its accumulation.
void MoveObject(Gpu& gpu, Renderer& renderer, Panel& cornell) {
    const size_t blockTexel = kOnTallBlock.x + size_t{kOnTallBlock.y} * kExtent.width;
    cornell.viewport.SetView(viewport::View::Raster);
    cornell.viewport.SetBudget({.maxRasterSamples = 1});
    const Picture there = Show(gpu, renderer, cornell);
    Require(PickAt(gpu, renderer, cornell, kOnTallBlock).instance == kTallBlock,
            "the tall block is not there");
    const uint32_t resets = cornell.viewport.ResetCount(passes::ResetCause::Transform);

    scene::PlacedTransform away = cornell.scene.Transform(kTallBlock);
    away.matrix[3].y -= 10.0f;
    cornell.scene.SetTransform(kTallBlock, away);
    const Picture gone = Show(gpu, renderer, cornell);
    Require(PickAt(gpu, renderer, cornell, kOnTallBlock).instance != kTallBlock,
            "the tall block is still there");
    Require(gone[blockTexel] != there[blockTexel], "the tall block is still shown");
    Require(std::equal(gone.begin(), gone.begin() + 8 * kExtent.width, there.begin()),
            "the ceiling has changed");

    cornell.viewport.SetView(viewport::View::PathTraced);
    Show(gpu, renderer, cornell);
    Require(cornell.Samples() == 1, "the picture is not of the moved object alone");
    Require(cornell.viewport.ResetCount(passes::ResetCause::Transform) == resets + 1,
            "no reset by a transform");
}

// A square in the host's own buffers appears between the camera and the block, moves away and is removed.
void ShowOwnVertices(Gpu& gpu, Renderer& renderer, Panel& cornell) {
    cornell.viewport.SetView(viewport::View::Raster);
    const Picture before = Show(gpu, renderer, cornell);
    struct Square {
        std::array<glm::vec3, 4> positions;
        std::array<uint32_t, 6> indices{0, 1, 2, 0, 2, 3};
    };
    const auto squareAt = [&](float distance) {
        const scene::CameraView& view = cornell.viewport.Camera();
        const glm::vec3 center = glm::vec3(view.eye) + distance * view.forward;
        const glm::vec3 x = 0.5f * view.right, y = 0.5f * view.up;
        return Square{{center - x - y, center + x - y, center + x + y, center - x + y}};
    };
    const auto boundsOf = [](const Square& square) {
        scene::Bounds bounds;
        for (const glm::vec3& position : square.positions) bounds.Extend(position);
        return bounds;
    };
    Square square = squareAt(1.0f);
    const VkBuffer vertices = gpu.MakeVertices(&square, sizeof(square));
    const rhi::Buffer wrapped =
        renderer.Device().WrapBuffer({.name = "vertices of the host",
                                      .size = sizeof(square),
                                      .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::BuildInput},
                                     vertices);

    GpuScene& scene = cornell.scene;
    scene::Material blue;
    blue.isUnlit = blue.isDoubleSided = true;
    blue.baseColorFactor = {0.0f, 0.0f, 1.0f, 1.0f};
    const uint32_t material = scene.AddMaterial(blue);
    const uint32_t mesh = scene.AddMesh({.name = "square",
                                         .vertexCount = 4,
                                         .triangleCount = 2,
                                         .positions = {&wrapped, offsetof(Square, positions)},
                                         .indices = {&wrapped, offsetof(Square, indices)},
                                         .material = material,
                                         .bounds = boundsOf(square)});
    const uint32_t instance = scene.AddInstance(mesh, scene::PlacedTransform{});
    constexpr size_t kCenter = kExtent.width / 2 + size_t{kExtent.height} / 2 * kExtent.width;
    for (const viewport::View view : {viewport::View::Raster, viewport::View::PathTraced}) {
        cornell.viewport.SetView(view);
        const Texel seen = Show(gpu, renderer, cornell)[kCenter];
        Require(seen[2] > seen[0] + 60 && seen[2] > seen[1] + 60,
                "the host's vertices are not seen, but " + std::to_string(seen[0]) + " " +
                    std::to_string(seen[1]) + " " + std::to_string(seen[2]));
    }
    cornell.viewport.SetView(viewport::View::Raster);
    Require(PickAt(gpu, renderer, cornell, glm::uvec2(32, 32)).instance == instance, "they are not picked");

    square = squareAt(-1.0f);  // behind the camera
    gpu.SetVertices(vertices, &square, sizeof(square));
    scene.MarkChanged(mesh, boundsOf(square));
    Require(Show(gpu, renderer, cornell) == before, "the host's vertices have not moved");
    scene.RemoveInstance(instance);
    scene.RemoveMesh(mesh);
    scene.RemoveMaterial(material);
    const Picture after = Show(gpu, renderer, cornell);
    size_t differing = 0;
    for (size_t i = 0; i < after.size(); ++i) differing += after[i] == before[i] ? 0 : 1;
    Require(differing == 0, "the host's vertices have left " + std::to_string(differing) + " texels");
    Require(scene.Statistics().instanceCount == instance, "an instance is left");
    cornell.viewport.SetView(viewport::View::PathTraced);
}

// Wipes between the host's own image, here plain blue, on the left, and ours.
void WipeOverOwnPicture(Gpu& gpu, Renderer& renderer, Panel& cornell) {
    cornell.viewport.SetBudget({.maxSamples = 4});  // afterwards the picture does not change
    Picture ours;
    do ours = Show(gpu, renderer, cornell);
    while (cornell.Samples() < 4);
    const VkImage drawn = gpu.MakePicture(kVkExtent);
    gpu.Clear(drawn, {0.0f, 0.0f, 1.0f, 1.0f});
    const rhi::Texture texture = renderer.Device().WrapTexture(
        {.name = "drawn by the host", .extent = kExtent, .usage = rhi::TextureUsage::Storage}, drawn);
    ResourceState state{.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};  // as Clear leaves it
    const Picture wiped = Show(gpu, renderer, cornell, [&](TextureId picture) {
        const TextureId theirs = renderer.Import("drawn by the host", texture, state);
        const TextureId wipe = passes::Wipe(renderer, theirs, picture, 0.5f);
        renderer.Export(theirs, VK_IMAGE_LAYOUT_GENERAL);  // as the host wants it back
        return wipe;
    });
    Require(state.layout == VK_IMAGE_LAYOUT_GENERAL, "the host has its picture back in another layout");
    for (uint32_t y = 0; y < kExtent.height; ++y) {
        const size_t row = size_t{y} * kExtent.width;
        Require(wiped[row + 31] == Texel{0, 0, 255, 255}, "the host's picture is not left of the line");
        Require(wiped[row + 40] == ours[row + 40], "the viewport's picture is not right of the line");
    }
}

// The host has one command buffer a frame: its own commands are before and after ours, and it draws a square
// over our picture. The picture does not change any more.
void RecordIntoOneBuffer(Gpu& gpu, Renderer& renderer, Panel& cornell) {
    constexpr uint32_t kSide = 8;
    const Picture ours = Show(gpu, renderer, cornell);
    for (int frame = 0; frame < 4; ++frame) {
        renderer.BeginFrame();
        cornell.target.Show(renderer, cornell.viewport.Declare());
        rhi::Submission recorded;
        const Picture drawnOver = gpu.Read(cornell.image, kVkExtent, [&](VkCommandBuffer commands) {
            gpu.BindHeap(commands);
            recorded = renderer.Record(commands);
            gpu.BindHeap(commands);
            gpu.DrawSquare(commands, cornell.image, kSide, {0.0f, 0.0f, 1.0f, 1.0f});
        });
        Require(!renderer.Device().HasCompleted(recorded), "a buffer of the host completes by itself");
        renderer.Device().Complete(recorded);  // Read has waited for it
        for (uint32_t y = 0; y < kExtent.height; ++y)
            for (uint32_t x = 0; x < kExtent.width; ++x) {
                const size_t texel = x + size_t{y} * kExtent.width;
                const Texel expected = x < kSide && y < kSide ? Texel{0, 0, 255, 255} : ours[texel];
                Require(drawnOver[texel] == expected, "the recorded picture is another one");
            }
    }
}

// Shows both scenes in one frame of one Renderer.
void ShowTwoScenes(Gpu& gpu, Renderer& renderer, Panel& first, Panel& second) {
    const Picture before = Show(gpu, renderer, first);
    for (int i = 0; i < 4; ++i) {
        renderer.BeginFrame();
        first.target.Show(renderer, first.viewport.Declare(), TakeTurn(gpu));
        second.target.Show(renderer, second.viewport.Declare());
        renderer.Execute();
        RequireClosedBox(gpu.Read(second.image, kVkExtent));
    }
    Require(second.Samples() == 4, "the second viewport has not accumulated");
    Require(gpu.Read(first.image, kVkExtent) == before, "the second viewport shows in the first one");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("host CORNELL CLOSED_BOX\n", stderr);
        return 2;
    }
    try {
        Require(LibraryVersion() == kHeaderVersion, "headers and library are of two versions");
        Gpu gpu;
        const auto device = Adopt(gpu);
        Renderer renderer(*device);
        Panel cornell(gpu, renderer, "cornell", argv[1]), closedBox(gpu, renderer, "closed box", argv[2]);
        ToggleViews(gpu, renderer, cornell);
        MoveObject(gpu, renderer, cornell);
        ShowOwnVertices(gpu, renderer, cornell);
        WipeOverOwnPicture(gpu, renderer, cornell);
        RecordIntoOneBuffer(gpu, renderer, cornell);
        ShowTwoScenes(gpu, renderer, cornell, closedBox);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
