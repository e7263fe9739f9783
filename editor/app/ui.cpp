#include "editor/app/ui.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "base/text.h"

namespace raygraph::editor {

namespace {

constexpr float kFontPoints = 15.0f;
// The font belongs to the system; if it is missing, ImGui's own is used.
constexpr const char* kFontFile = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";

// Copies ImGui's draw lists, which its next frame overwrites, in the layout of the pass.
struct Geometry {
    struct Part {
        uint32_t firstIndex = 0, indexCount = 0, source = 0;
        int32_t x = 0, y = 0;
        rhi::Extent2D scissor;
    };
    std::vector<ImDrawVert> vertices;
    std::vector<uint32_t> indices;
    std::vector<Part> parts;
};

Geometry GeometryOf(const ImDrawData& data, rhi::Extent2D extent, bool hasPicture, bool hasThumbnails) {
    Geometry geometry;
    for (int i = 0; i < data.CmdListsCount; ++i) {
        const ImDrawList& list = *data.CmdLists[i];
        const auto firstVertex = static_cast<uint32_t>(geometry.vertices.size());
        const auto firstIndex = static_cast<uint32_t>(geometry.indices.size());
        geometry.vertices.insert(geometry.vertices.end(), list.VtxBuffer.begin(), list.VtxBuffer.end());
        for (const ImDrawIdx index : list.IdxBuffer) geometry.indices.push_back(firstVertex + index);
        for (const ImDrawCmd& command : list.CmdBuffer) {
            if (command.UserCallback) continue;
            const uint32_t source = command.GetTexID() == PictureTexture()     ? 1
                                    : command.GetTexID() == ThumbnailTexture() ? 2
                                                                               : 0;
            if ((source == 1 && !hasPicture) || (source == 2 && !hasThumbnails)) continue;
            const auto pixels = [&](float points, float scale, uint32_t limit) {
                return std::clamp(static_cast<int32_t>(points * scale), 0, static_cast<int32_t>(limit));
            };
            const ImVec2 scale = data.FramebufferScale, origin = data.DisplayPos;
            const int32_t left = pixels(command.ClipRect.x - origin.x, scale.x, extent.width);
            const int32_t top = pixels(command.ClipRect.y - origin.y, scale.y, extent.height);
            const int32_t right = pixels(command.ClipRect.z - origin.x, scale.x, extent.width);
            const int32_t bottom = pixels(command.ClipRect.w - origin.y, scale.y, extent.height);
            if (right <= left || bottom <= top) continue;
            geometry.parts.push_back(
                {.firstIndex = firstIndex + command.IdxOffset,
                 .indexCount = command.ElemCount,
                 .source = source,
                 .x = left,
                 .y = top,
                 .scissor = {static_cast<uint32_t>(right - left), static_cast<uint32_t>(bottom - top)}});
        }
    }
    return geometry;
}

struct UiConstants {
    glm::vec2 scale, offset;
};

template <typename T>
void Fill(const rhi::Buffer& buffer, const std::vector<T>& items) {
    std::memcpy(buffer.Mapped().data(), items.data(), items.size() * sizeof(T));
}

}  // namespace

Ui::Ui() {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // the editor stores its settings itself
    io.BackendRendererName = "raygraph";
    io.ConfigWindowsMoveFromTitleBarOnly = true;
}

Ui::~Ui() {
    ImGui::DestroyContext();
}

void Ui::Begin(const FrameInput& input) {
    ImGuiIO& io = ImGui::GetIO();
    if (m_scale != input.scale) {
        m_scale = input.scale;
        ++m_atlas;
        io.Fonts->Clear();
        // Fonts are rasterized at pixel size, and scaled back to points
        if (std::filesystem::exists(kFontFile))
            io.Fonts->AddFontFromFileTTF(kFontFile, kFontPoints * m_scale);
        else
            io.Fonts->AddFontDefault();
        io.FontGlobalScale = 1.0f / m_scale;
        io.Fonts->Build();
        io.Fonts->SetTexID(ImTextureID{});
        ApplyStyle(ImGui::GetStyle());
    }
    const float points = 1.0f / input.scale;
    io.DisplaySize = {static_cast<float>(input.extent.width) * points,
                      static_cast<float>(input.extent.height) * points};
    io.DisplayFramebufferScale = {input.scale, input.scale};
    io.DeltaTime = std::max(input.seconds, 1e-4f);
    io.MousePos = {input.mouse.x * points, input.mouse.y * points};
    for (size_t i = 0; i < kMouseButtonCount; ++i) io.MouseDown[i] = input.buttons[i];
    io.MouseWheel += input.wheel;
    io.KeyCtrl = input.isControl;
    io.KeyShift = input.isShift;
    io.KeyAlt = input.isAlt;
    for (const char32_t character : input.text) io.AddInputCharacter(static_cast<unsigned int>(character));
    FeedKeys(io, input);
    ImGui::NewFrame();
}

void Ui::End() {
    ImGui::Render();
}

// Copies the font atlas to the device if it is new.
TextureId Ui::DeclareAtlas(Renderer& renderer) {
    unsigned char* texels = nullptr;
    int width = 0, height = 0;
    ImGui::GetIO().Fonts->GetTexDataAsRGBA32(&texels, &width, &height);
    const rhi::Extent2D extent{static_cast<uint32_t>(width), static_cast<uint32_t>(height)};
    TextureId atlas = renderer.Persist(Text("ui atlas {}", m_atlas), {extent, rhi::Format::Rgba8Unorm});
    if (!renderer.IsFresh(atlas)) return atlas;
    const uint64_t bytes = uint64_t{4} * extent.width * extent.height;
    const BufferId staging =
        renderer.CreateBuffer("ui atlas texels", {.size = bytes, .memory = rhi::MemoryKind::Upload});
    std::vector<unsigned char> copy(texels, texels + bytes);
    renderer.AddPass(
        "UploadUiAtlas", PassKind::Transfer,
        [&](PassBuilder& pass) {
            pass.CopiesFrom(staging);
            atlas = pass.CopiesTo(atlas);
        },
        [staging, atlas, copy = std::move(copy)](CommandList& commands, const PassResources& resources) {
            Fill(resources.Buffer(staging), copy);
            commands.CopyToTexture(resources.Buffer(staging), 0, resources.Texture(atlas));
        });
    return atlas;
}

TextureId Ui::Draw(Renderer& renderer, TextureId target, TextureId picture, TextureId thumbnails) {
    const ImDrawData& data = *ImGui::GetDrawData();
    const rhi::Extent2D extent = renderer.Desc(target).extent;
    auto geometry =
        std::make_shared<const Geometry>(GeometryOf(data, extent, picture.IsValid(), thumbnails.IsValid()));
    if (geometry->parts.empty()) return target;
    const TextureId atlas = DeclareAtlas(renderer);
    const auto buffer = [&](const char* name, size_t bytes) {
        return renderer.CreateBuffer(name, {.size = bytes, .memory = rhi::MemoryKind::Upload});
    };
    const BufferId vertices = buffer("ui vertices", geometry->vertices.size() * sizeof(ImDrawVert));
    const BufferId indices = buffer("ui indices", geometry->indices.size() * sizeof(uint32_t));
    UiConstants constants;
    constants.scale = {2.0f / data.DisplaySize.x, 2.0f / data.DisplaySize.y};
    constants.offset = glm::vec2(-1.0f) - glm::vec2(data.DisplayPos.x, data.DisplayPos.y) * constants.scale;
    const rhi::SamplerDesc smooth{.addressU = rhi::AddressMode::ClampToEdge,
                                  .addressV = rhi::AddressMode::ClampToEdge};
    rhi::SamplerDesc exact = smooth;
    exact.magFilter = exact.minFilter = rhi::Filter::Nearest;
    renderer.AddPass(
        "DrawUi", PassKind::Raster,
        [&](PassBuilder& pass) {
            pass.Vertex("editor/ui.vert").Fragment("editor/ui.frag");
            pass.Raster({.blend = rhi::BlendMode::Alpha});
            pass.Reads("vertices", vertices);
            pass.ReadsIndices(indices);
            pass.Reads("atlas", atlas, smooth);
            pass.Reads("picture", picture.IsValid() ? picture : atlas, exact);
            pass.Reads("thumbnails", thumbnails.IsValid() ? thumbnails : atlas, smooth);
            pass.Constants(constants);
            target = pass.ColorTarget(0, target, {.value = {0.0f, 0.0f, 0.0f, 1.0f}});
        },
        [geometry, vertices, indices](CommandList& commands, const PassResources& resources) {
            Fill(resources.Buffer(vertices), geometry->vertices);
            Fill(resources.Buffer(indices), geometry->indices);
            for (const Geometry::Part& part : geometry->parts) {
                commands.SetScissor(part.x, part.y, part.scissor);
                commands.DrawIndexed(resources.Buffer(indices), part.indexCount, 1, part.firstIndex, 0,
                                     part.source);
            }
        });
    return target;
}

// --- Style, and keys ---

namespace {

ImVec4 Gray(float value, float alpha = 1.0f) {
    return {value, value, value * 1.03f, alpha};
}

struct KeyPair {
    Key from;
    ImGuiKey to;
};
constexpr std::array kKeyPairs{
    KeyPair{Key::Tab, ImGuiKey_Tab},
    KeyPair{Key::Left, ImGuiKey_LeftArrow},
    KeyPair{Key::Right, ImGuiKey_RightArrow},
    KeyPair{Key::Up, ImGuiKey_UpArrow},
    KeyPair{Key::Down, ImGuiKey_DownArrow},
    KeyPair{Key::PageUp, ImGuiKey_PageUp},
    KeyPair{Key::PageDown, ImGuiKey_PageDown},
    KeyPair{Key::Home, ImGuiKey_Home},
    KeyPair{Key::End, ImGuiKey_End},
    KeyPair{Key::Delete, ImGuiKey_Delete},
    KeyPair{Key::Backspace, ImGuiKey_Backspace},
    KeyPair{Key::Space, ImGuiKey_Space},
    KeyPair{Key::Enter, ImGuiKey_Enter},
    KeyPair{Key::Escape, ImGuiKey_Escape},
    KeyPair{Key::A, ImGuiKey_A},
    KeyPair{Key::C, ImGuiKey_C},
    KeyPair{Key::V, ImGuiKey_V},
    KeyPair{Key::X, ImGuiKey_X},
    KeyPair{Key::Y, ImGuiKey_Y},
    KeyPair{Key::Z, ImGuiKey_Z},
};

}  // namespace

void ApplyStyle(ImGuiStyle& style) {
    style = ImGuiStyle();
    ImGui::StyleColorsDark(&style);
    style.WindowPadding = {10.0f, 8.0f};
    style.FramePadding = {7.0f, 4.0f};
    style.ItemSpacing = {7.0f, 5.0f};
    style.ScrollbarSize = 12.0f;
    style.WindowRounding = 0.0f;
    style.FrameRounding = 3.0f;
    style.GrabRounding = 3.0f;
    style.PopupRounding = 4.0f;
    style.WindowBorderSize = 1.0f;
    style.FrameBorderSize = 0.0f;
    const ImVec4 accent{0.91f, 0.56f, 0.20f, 1.0f};
    const ImVec4 faint{accent.x, accent.y, accent.z, 0.35f};
    ImVec4* colors = style.Colors;
    colors[ImGuiCol_Text] = Gray(0.88f);
    colors[ImGuiCol_TextDisabled] = Gray(0.50f);
    colors[ImGuiCol_WindowBg] = Gray(0.125f);
    colors[ImGuiCol_ChildBg] = Gray(0.125f);
    colors[ImGuiCol_PopupBg] = Gray(0.15f, 0.98f);
    colors[ImGuiCol_MenuBarBg] = Gray(0.10f);
    colors[ImGuiCol_Border] = Gray(0.06f);
    colors[ImGuiCol_FrameBg] = Gray(0.19f);
    colors[ImGuiCol_FrameBgHovered] = Gray(0.24f);
    colors[ImGuiCol_FrameBgActive] = Gray(0.28f);
    colors[ImGuiCol_TitleBg] = colors[ImGuiCol_TitleBgActive] = Gray(0.10f);
    colors[ImGuiCol_Header] = Gray(0.22f);
    colors[ImGuiCol_HeaderHovered] = Gray(0.27f);
    colors[ImGuiCol_HeaderActive] = faint;
    colors[ImGuiCol_Button] = Gray(0.22f);
    colors[ImGuiCol_ButtonHovered] = Gray(0.28f);
    colors[ImGuiCol_ButtonActive] = faint;
    colors[ImGuiCol_CheckMark] = accent;
    // The number of a slider is drawn over its grab
    colors[ImGuiCol_SliderGrab] = colors[ImGuiCol_SliderGrabActive] = {accent.x, accent.y, accent.z, 0.55f};
    colors[ImGuiCol_PlotLines] = colors[ImGuiCol_PlotHistogram] = accent;
    colors[ImGuiCol_Tab] = Gray(0.14f);
    colors[ImGuiCol_TabHovered] = Gray(0.27f);
    colors[ImGuiCol_TabActive] = Gray(0.22f);
    colors[ImGuiCol_ModalWindowDimBg] = Gray(0.0f, 0.55f);
    colors[ImGuiCol_Separator] = Gray(0.22f);
    colors[ImGuiCol_TextSelectedBg] = faint;
}

void FeedKeys(ImGuiIO& io, const FrameInput& input) {
    // Tab goes from field to field, but not into the first
    const auto isDown = [&](Key key) { return input.IsDown(key) && (key != Key::Tab || io.WantTextInput); };
#if IMGUI_VERSION_NUM >= 18700
    for (const KeyPair& pair : kKeyPairs) io.AddKeyEvent(pair.to, isDown(pair.from));
#else
    for (const KeyPair& pair : kKeyPairs) {
        io.KeyMap[pair.to] = static_cast<int>(pair.from);
        io.KeysDown[static_cast<int>(pair.from)] = isDown(pair.from);
    }
#endif
}

}  // namespace raygraph::editor
