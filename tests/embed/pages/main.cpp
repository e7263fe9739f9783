// pages CORNELL CLOSED_BOX: runs the code of docs/embed.md. Exits with 1 and one line when it does not do
// what the page says.
#include <cstdio>
#include <exception>

#include "embed.cpp"  // the code of the page
#include "renderer/scene/check.h"
#include "rhi/command_list.h"
#include "rhi/readback.h"

namespace {

constexpr Extent2D kSize{16, 16};

void Require(bool holds, const char* what) {
    if (!holds) throw std::runtime_error(std::string("pages: not so: ") + what);
}

std::vector<VkPhysicalDevice> MakeInstance(HostVulkan& host) {
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = rhi::Requirements().apiVersion;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    Require(vkCreateInstance(&info, nullptr, &host.instance) == VK_SUCCESS, "there is an instance");
    uint32_t count = 0;
    vkEnumeratePhysicalDevices(host.instance, &count, nullptr);
    std::vector<VkPhysicalDevice> devices(count);
    vkEnumeratePhysicalDevices(host.instance, &count, devices.data());
    return devices;
}

// Makes an image that stands for the engine's.
rhi::Texture MakeImage(rhi::Device& device) {
    return device.CreateTexture({.name = "image",
                                 .extent = kSize,
                                 .usage = rhi::TextureUsage::Storage | rhi::TextureUsage::Sampled |
                                          rhi::TextureUsage::CopySource |
                                          rhi::TextureUsage::CopyDestination});
}

// Is the timeline by which the engine and its frames take turns.
class Turns {
  public:
    explicit Turns(VkDevice device) : m_device(device) {
        VkSemaphoreTypeCreateInfo type{VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO};
        type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
        VkSemaphoreCreateInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO};
        info.pNext = &type;
        Require(vkCreateSemaphore(device, &info, nullptr, &m_semaphore) == VK_SUCCESS,
                "there is a semaphore");
    }
    ~Turns() { vkDestroySemaphore(m_device, m_semaphore, nullptr); }
    Turns(const Turns&) = delete;
    Turns& operator=(const Turns&) = delete;

    rhi::SemaphoreUse Before() const { return {m_semaphore, m_turn}; }
    rhi::SemaphoreUse After() const { return {m_semaphore, m_turn + 1}; }
    void WaitForFrame() {
        ++m_turn;
        VkSemaphoreWaitInfo info{VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO};
        info.semaphoreCount = 1;
        info.pSemaphores = &m_semaphore;
        info.pValues = &m_turn;
        Require(vkWaitSemaphores(m_device, &info, UINT64_MAX) == VK_SUCCESS, "the frame signals");
    }

  private:
    VkDevice m_device;
    VkSemaphore m_semaphore = VK_NULL_HANDLE;
    uint64_t m_turn = 0;
};

uint32_t FirstTexel(rhi::Device& device, const rhi::Texture& image) {
    const std::vector<std::byte> bytes =
        rhi::ReadTexture(device, image, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    return std::to_integer<uint32_t>(bytes[0]) | std::to_integer<uint32_t>(bytes[1]) << 8 |
           std::to_integer<uint32_t>(bytes[2]) << 16;
}

void RunPage(HostVulkan& host, const char* cornell, const char* closedBox) {
    Require(IsTheLibraryCompiledAgainst(), "the library is the one compiled against");
    Turns turns(host.device);
    const auto device = Adopt(host);
    Require(host.messages.size() == 1 && host.messages[0].starts_with("device: device 'host': "),
            "the library says which device it has, and nothing that is below LogLevel::Info");
    Renderer renderer(*device);
    const rhi::Texture leftImage = MakeImage(*device), rightImage = MakeImage(*device);
    Panel left(renderer, "left", leftImage.Image(), kSize),
        right(renderer, "right", rightImage.Image(), kSize);

    std::future<scene::SceneData> loading = LoadBeside(cornell);
    std::string line;
    Require(!Open(right, "missing.gltf", line), "a missing file is not opened");
    Require(line.find("missing.gltf") != std::string::npos, "the line names the file");
    Require(Open(right, closedBox, line), "the closed box is opened");
    scene::SceneData loaded = loading.get();
    scene::Check(loaded);
    left.Show(std::move(loaded));

    for (int i = 0; i < 3; ++i) {
        Frame(renderer, left, right, turns.Before(), turns.After());
        turns.WaitForFrame();
    }
    Require(left.viewport.Progress().pathTracedSamples == 3, "each frame adds a sample to the left panel");
    Require(right.viewport.Progress().pathTracedSamples == 3, "each frame adds a sample to the right panel");
    const uint32_t leftTexel = FirstTexel(*device, leftImage);
    Require(leftTexel != FirstTexel(*device, rightImage), "two panels show two scenes");

    EnginePicture drawn{.texture = MakeImage(*device),
                        .state = {.layout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL}};
    rhi::CommandList commands = device->BeginCommands("engine draws");
    commands.Transition(drawn.texture, VK_IMAGE_LAYOUT_UNDEFINED, drawn.state.layout);
    commands.Clear(drawn.texture, {0.0f, 0.0f, 1.0f, 1.0f});
    const rhi::SemaphoreUse hasDrawn = turns.After();
    device->Submit(std::move(commands), {}, std::span(&hasDrawn, 1));
    turns.WaitForFrame();
    WipeOver(renderer, drawn, left, turns.Before(), turns.After());
    turns.WaitForFrame();
    Require(FirstTexel(*device, leftImage) == 0xff0000, "the engine's picture is left of the line");
    Require(drawn.state.layout == VK_IMAGE_LAYOUT_GENERAL, "the engine has its picture back as it wants it");
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    HostVulkan host;
    int status = 0;
    try {
        MakeDevice(host, MakeInstance(host));
        RunPage(host, argv[1], argv[2]);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        status = 1;
    }
    if (host.device) vkDestroyDevice(host.device, nullptr);
    if (host.instance) vkDestroyInstance(host.instance, nullptr);
    return status;
}
