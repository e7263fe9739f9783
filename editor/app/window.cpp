#include "editor/app/window.h"

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>
#include <imgui.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "base/text.h"

namespace raygraph::editor {

namespace {

std::optional<Key> KeyOf(int key) {
    const auto from = [&](int first, Key start) {
        return static_cast<Key>(static_cast<int>(start) + key - first);
    };
    if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) return from(GLFW_KEY_A, Key::A);
    if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9) return from(GLFW_KEY_0, Key::Digit0);
    if (key >= GLFW_KEY_KP_0 && key <= GLFW_KEY_KP_9) return from(GLFW_KEY_KP_0, Key::Digit0);
    if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) return from(GLFW_KEY_F1, Key::F1);
    switch (key) {
        case GLFW_KEY_TAB:
            return Key::Tab;
        case GLFW_KEY_SPACE:
            return Key::Space;
        case GLFW_KEY_ENTER:
        case GLFW_KEY_KP_ENTER:
            return Key::Enter;
        case GLFW_KEY_ESCAPE:
            return Key::Escape;
        case GLFW_KEY_BACKSPACE:
            return Key::Backspace;
        case GLFW_KEY_DELETE:
            return Key::Delete;
        case GLFW_KEY_HOME:
            return Key::Home;
        case GLFW_KEY_END:
            return Key::End;
        case GLFW_KEY_LEFT:
            return Key::Left;
        case GLFW_KEY_RIGHT:
            return Key::Right;
        case GLFW_KEY_UP:
            return Key::Up;
        case GLFW_KEY_DOWN:
            return Key::Down;
        case GLFW_KEY_PERIOD:
        case GLFW_KEY_KP_DECIMAL:
            return Key::Period;
        case GLFW_KEY_PAGE_UP:
            return Key::PageUp;
        case GLFW_KEY_PAGE_DOWN:
            return Key::PageDown;
        default:
            return std::nullopt;
    }
}

std::string GlfwErrorText() {
    const char* text = nullptr;
    glfwGetError(&text);
    return text ? text : "no reason given";
}

}  // namespace

struct Window::Impl {
    static FrameInput& EventsOf(GLFWwindow* of) {
        return static_cast<Impl*>(glfwGetWindowUserPointer(of))->events;
    }

    ~Impl() {
        if (window) glfwDestroyWindow(window);
        glfwTerminate();
    }

    GLFWwindow* window = nullptr;
    FrameInput events;  // since the last Poll
    double lastTime = 0.0;
};

Window::Window(const std::string& title, rhi::Extent2D size) {
    if (!glfwInit()) throw MakeError(ErrorKind::NoDevice, "no window can be opened: {}", GlfwErrorText());
    m_impl = std::make_unique<Impl>();
    if (!glfwVulkanSupported())
        throw Error(ErrorKind::NoDevice,
                    "no window can be opened: there is no Vulkan driver for this display");
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    GLFWwindow* window = glfwCreateWindow(static_cast<int>(size.width), static_cast<int>(size.height),
                                          title.c_str(), nullptr, nullptr);
    if (!window) throw MakeError(ErrorKind::NoDevice, "no window can be opened: {}", GlfwErrorText());
    m_impl->window = window;
    m_impl->lastTime = glfwGetTime();
    glfwSetWindowUserPointer(window, m_impl.get());
    // A click that is shorter than a frame still counts
    glfwSetInputMode(window, GLFW_STICKY_MOUSE_BUTTONS, GLFW_TRUE);
    glfwSetInputMode(window, GLFW_STICKY_KEYS, GLFW_TRUE);
    glfwSetScrollCallback(
        window, [](GLFWwindow* of, double, double y) { Impl::EventsOf(of).wheel += static_cast<float>(y); });
    glfwSetCharCallback(
        window, [](GLFWwindow* of, unsigned int character) { Impl::EventsOf(of).text.push_back(character); });
    glfwSetKeyCallback(window, [](GLFWwindow* of, int code, int, int action, int modifiers) {
        const std::optional<Key> key = KeyOf(code);
        if (!key || action != GLFW_PRESS) return;
        FrameInput& events = Impl::EventsOf(of);
        events.pressed.push_back(*key);
        events.isControl |= (modifiers & GLFW_MOD_CONTROL) != 0;
        events.isShift |= (modifiers & GLFW_MOD_SHIFT) != 0;
        events.isAlt |= (modifiers & GLFW_MOD_ALT) != 0;
    });
    glfwSetDropCallback(window, [](GLFWwindow* of, int count, const char** paths) {
        for (int i = 0; i < count; ++i) Impl::EventsOf(of).dropped.emplace_back(paths[i]);
    });
}

Window::~Window() = default;

std::vector<std::string> Window::SurfaceExtensions() const {
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    return names ? std::vector<std::string>(names, names + count) : std::vector<std::string>{};
}

rhi::MakeSurface Window::SurfaceMaker() {
    return [window = m_impl->window](auto instance, auto* surface) {
        return glfwCreateWindowSurface(instance, window, nullptr, surface) == 0;
    };
}

rhi::Extent2D Window::Extent() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(m_impl->window, &width, &height);
    return {static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
}

FrameInput Window::Poll(double seconds) {
    if (seconds > 0.0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
    GLFWwindow* window = m_impl->window;
    FrameInput input = std::exchange(m_impl->events, {});
    input.extent = Extent();
    float scaleX = 1.0f, scaleY = 1.0f;
    glfwGetWindowContentScale(window, &scaleX, &scaleY);
    input.scale = std::max(scaleX, 0.5f);
    const double now = glfwGetTime();
    input.seconds = static_cast<float>(now - std::exchange(m_impl->lastTime, now));
    int windowWidth = 0, windowHeight = 0;
    glfwGetWindowSize(window, &windowWidth, &windowHeight);
    double x = 0.0, y = 0.0;
    glfwGetCursorPos(window, &x, &y);
    if (windowWidth > 0 && windowHeight > 0)  // convert screen coordinates to pixels
        input.mouse = glm::vec2(static_cast<float>(x * input.extent.width / windowWidth),
                                static_cast<float>(y * input.extent.height / windowHeight));
    constexpr std::array kButtons{GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT, GLFW_MOUSE_BUTTON_MIDDLE};
    for (size_t i = 0; i < kMouseButtonCount; ++i)
        input.buttons[i] = glfwGetMouseButton(window, kButtons[i]) == GLFW_PRESS;
    const auto isHeld = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS; };
    for (int code = GLFW_KEY_SPACE; code <= GLFW_KEY_LAST; ++code)
        if (const std::optional<Key> key = KeyOf(code); key && isHeld(code))
            input.keys[static_cast<size_t>(*key)] = true;
    input.isControl |= isHeld(GLFW_KEY_LEFT_CONTROL) || isHeld(GLFW_KEY_RIGHT_CONTROL);
    input.isShift |= isHeld(GLFW_KEY_LEFT_SHIFT) || isHeld(GLFW_KEY_RIGHT_SHIFT);
    input.isAlt |= isHeld(GLFW_KEY_LEFT_ALT) || isHeld(GLFW_KEY_RIGHT_ALT);
    input.isClosing = glfwWindowShouldClose(window) != 0;
    glfwSetWindowShouldClose(window, GLFW_FALSE);  // the user may decline
    return input;
}

void Window::SetTitle(const std::string& title) {
    glfwSetWindowTitle(m_impl->window, title.c_str());
}

void Window::Hide() {
    glfwHideWindow(m_impl->window);
}

void Window::ShareClipboard() {
    ImGuiIO& io = ImGui::GetIO();
    io.ClipboardUserData = m_impl->window;
    io.SetClipboardTextFn = [](void* window, const char* text) {
        glfwSetClipboardString(static_cast<GLFWwindow*>(window), text);
    };
    io.GetClipboardTextFn = [](void* window) {
        return glfwGetClipboardString(static_cast<GLFWwindow*>(window));
    };
}

std::optional<TextureId> PictureScreen::Begin(Renderer& renderer, rhi::Extent2D extent) {
    if (extent.IsEmpty()) return std::nullopt;
    return renderer.CreateTexture("screen", {extent, rhi::Format::Rgba8Unorm});
}

void PictureScreen::End(Renderer& renderer, TextureId drawn) {
    renderer.Present(drawn);
    renderer.Execute();
}

}  // namespace raygraph::editor
