// Shows the picture's cost: samples, error and time left, memory, times of the passes over the last frames.
#include <imgui.h>

#include <algorithm>
#include <array>
#include <string>

#include "base/text.h"
#include "editor/app/frame_statistics.h"
#include "editor/app/panels.h"

namespace raygraph::editor {

namespace {

constexpr size_t kColored = 6;  // passes with a color of their own; the others share one
constexpr std::array<ImU32, kColored + 1> kColors{IM_COL32(232, 143, 52, 255),  IM_COL32(86, 148, 214, 255),
                                                  IM_COL32(112, 184, 104, 255), IM_COL32(196, 104, 176, 255),
                                                  IM_COL32(214, 196, 92, 255),  IM_COL32(98, 192, 190, 255),
                                                  IM_COL32(120, 120, 128, 255)};

void Row(const char* name, const std::string& value) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextDisabled("%s", name);
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(value.c_str());
}

void SampleRows(Workspace& work) {
    const viewport::ViewportProgress progress = work.view.Progress();
    Row("samples", Text("{} path-traced, {} raster", progress.pathTracedSamples, progress.rasterSamples));
    const Extent2D size = work.view.Size();
    const std::optional<double> rate = work.sampleRate.PerSecond();
    if (rate)
        Row("speed",
            Text("{:.2f} Msamples/s, {:.2f} a pixel", *rate * size.width * size.height * 1e-6, *rate));
    else
        Row("speed", "-");
    const viewport::NoiseEstimate& error = work.estimate;
    if (!error.relativeError) {
        Row("error", "-");
        return;
    }
    std::string text = Text("{:.2f} %", 100.0 * *error.relativeError);
    if (rate && *rate > 0.0) {
        const double left =
            SecondsLeft(*error.relativeError, 0.01 * double{work.targetPercent}, error.sampleCount, *rate);
        text += left > 0.0 ? ", " + DurationText(left) + " left" : ", there";
    }
    Row("error", text);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::TextDisabled("wanted");
    ImGui::TableNextColumn();
    ImGui::SetNextItemWidth(90.0f);
    ImGui::DragFloat("##wanted", &work.targetPercent, 0.02f, 0.05f, 50.0f, "%.2f %%",
                     ImGuiSliderFlags_Logarithmic | ImGuiSliderFlags_AlwaysClamp);
}

void Table(Workspace& work) {
    const GpuSceneStatistics& scene = work.gpu.Statistics();
    if (!ImGui::BeginTable("statistics", 2, ImGuiTableFlags_SizingFixedFit)) return;
    Row("device", work.device.Info().name);
    SampleRows(work);
    Row("triangles", Text("{} in {} instances", scene.trianglesPlaced, scene.instanceCount));
    Row("lights", std::to_string(scene.lightCount));
    Row("BLAS", Text("{}, {}, compacted {}", scene.blasCount, BytesText(scene.blasBytesBuilt),
                     BytesText(scene.blasBytesCompacted)));
    Row("TLAS",
        Text("{} builds, {} updates, {}", scene.tlasRebuilds, scene.tlasUpdates, BytesText(scene.tlasBytes)));
    const std::vector<rhi::MemoryHeap> heaps = work.device.MemoryHeaps();
    for (const MemoryRow& row : MemoryRows(work.device.Memory(), heaps)) Row(row.name.c_str(), row.value);
    Row("textures",
        Text("{} of a budget of {}", BytesText(scene.textureBytes), BytesText(scene.textureBudget)));
    if (scene.reducedTextures > 0) Row("", Text("{} smaller, to fit it", scene.reducedTextures));
    ImGui::EndTable();
}

// Draws one column per frame, with the passes stacked.
void Chart(const std::vector<FrameHistory::Pass>& passes, size_t frameCount, float top, ImVec2 size) {
    const ImVec2 from = ImGui::GetCursorScreenPos();
    ImGui::Dummy(size);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(from, {from.x + size.x, from.y + size.y}, IM_COL32(22, 22, 24, 255));
    const float width = size.x / static_cast<float>(FrameHistory::kLength);
    const float right = from.x + size.x;
    const bool isHovered = ImGui::IsItemHovered();
    for (size_t frame = 0; frame < frameCount; ++frame) {
        const float x = right - width * static_cast<float>(frameCount - frame);
        float bottom = from.y + size.y;
        for (size_t i = 0; i < passes.size(); ++i) {
            const float height = size.y * passes[i].ms[frame] / top;
            if (height <= 0.0f) continue;
            const float up = std::max(bottom - height, from.y);
            list.AddRectFilled({x, up}, {x + std::max(width - 0.3f, 0.7f), bottom},
                               kColors[std::min(i, kColored)]);
            bottom = up;
        }
        if (!isHovered || ImGui::GetIO().MousePos.x < x || ImGui::GetIO().MousePos.x >= x + width) continue;
        list.AddRect({x - 1.0f, from.y}, {x + width + 1.0f, from.y + size.y}, IM_COL32(255, 255, 255, 120));
        ImGui::BeginTooltip();
        for (const FrameHistory::Pass& pass : passes)
            if (pass.ms[frame] > 0.0f) ImGui::Text("%8.3f ms  %s", double{pass.ms[frame]}, pass.name.c_str());
        ImGui::EndTooltip();
    }
    list.AddRectFilled(from, {from.x + 62.0f, from.y + 20.0f}, IM_COL32(22, 22, 24, 200));
    list.AddText({from.x + 4.0f, from.y + 2.0f}, IM_COL32(190, 190, 196, 255),
                 Text("{:.1f} ms", double{top}).c_str());
}

void LegendRow(size_t color, const std::string& text) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float side = ImGui::GetTextLineHeight();
    ImGui::GetWindowDrawList()->AddRectFilled({at.x, at.y + 3.0f}, {at.x + side - 6.0f, at.y + side - 3.0f},
                                              kColors[std::min(color, kColored)]);
    ImGui::Dummy({side, side});
    ImGui::SameLine();
    ImGui::TextUnformatted(text.c_str());
}

void Legend(const std::vector<FrameHistory::Pass>& passes) {
    for (size_t i = 0; i < passes.size(); ++i) {
        LegendRow(i, Text("{:8.3f} ms", passes[i].ms.back()));
        ImGui::SameLine();
        ImGui::TextDisabled("%s", passes[i].name.c_str());
    }
}

// Returns the smallest of 1, 2, 5, 10, ... that is not below `value`.
float AxisMaximum(float value) {
    float top = 0.1f;
    for (int i = 0; top < value && i < 30; ++i) top *= i % 3 == 1 ? 2.5f : 2.0f;
    return top;
}

void Times(const Workspace& work) {
    const FrameHistory& history = work.history;
    if (history.Count() == 0) return;
    const std::vector<FrameHistory::Pass> passes = history.Passes();
    const std::vector<float> gpu = history.Gpu();
    ImGui::Text("GPU %.1f ms, CPU %.2f ms, panels %.2f ms", double{gpu.back()}, double{history.Cpu().back()},
                work.uiMs);
    // A single long frame, as when a pipeline is made, must not flatten the others
    std::vector<float> sorted = gpu;
    std::ranges::sort(sorted);
    const float most = sorted[(sorted.size() - 1) * 97 / 100];
    Chart(passes, history.Count(), AxisMaximum(most), {ImGui::GetContentRegionAvail().x, 84.0f});
    Legend(passes);
}

// Plots the errors of the real-time view over the last measurements, on a logarithmic axis.
void RealTimeErrorChart(const RealTimeErrorHistory& history) {
    constexpr float kLeast = 1e-6f, kMost = 10.0f, kHeight = 84.0f;
    constexpr int kDecades = 7;
    const std::vector<RealTimeErrorHistory::Curve> curves = history.Curves();
    if (curves.empty()) {
        ImGui::TextDisabled("errors: once the reference has a sample");
        return;
    }
    const ImVec2 size{ImGui::GetContentRegionAvail().x, kHeight}, from = ImGui::GetCursorScreenPos();
    ImGui::Dummy(size);
    ImDrawList& list = *ImGui::GetWindowDrawList();
    list.AddRectFilled(from, {from.x + size.x, from.y + size.y}, IM_COL32(22, 22, 24, 255));
    for (int decade = 1; decade < kDecades; ++decade) {
        const float y = from.y + size.y * static_cast<float>(decade) / static_cast<float>(kDecades);
        list.AddLine({from.x, y}, {from.x + size.x, y}, IM_COL32(48, 48, 52, 255));
    }
    const float step = size.x / static_cast<float>(RealTimeErrorHistory::kLength - 1);
    for (size_t i = 0; i < curves.size(); ++i) {
        const std::vector<std::optional<float>>& values = curves[i].values;
        std::optional<ImVec2> last;
        for (size_t k = 0; k < values.size(); ++k) {
            std::optional<ImVec2> point;
            if (values[k])
                point = ImVec2{from.x + size.x - step * static_cast<float>(values.size() - 1 - k),
                               from.y + size.y * (1.0f - OnLogAxis(*values[k], kLeast, kMost))};
            if (point && last) list.AddLine(*last, *point, kColors[i], 1.5f);
            last = point;
        }
    }
    const ImU32 text = IM_COL32(190, 190, 196, 255);
    list.AddText({from.x + 4.0f, from.y + 2.0f}, text, "10");
    list.AddText({from.x + 4.0f, from.y + size.y - ImGui::GetTextLineHeight() - 2.0f}, text, "1e-6");
    for (size_t i = 0; i < curves.size(); ++i) LegendRow(i, curves[i].text);
}

}  // namespace

void StatisticsPanel(Workspace& work) {
    // Charts are side by side if there is room
    const float room = ImGui::GetContentRegionAvail().x;
    const bool isWide = room > 520.0f;
    if (isWide) ImGui::BeginChild("numbers", {0.46f * room, 0.0f});
    Table(work);
    if (isWide) {
        ImGui::EndChild();
        ImGui::SameLine();
        ImGui::BeginChild("times");
    }
    if (viewport::ComparesRealTime(work.view.Show())) RealTimeErrorChart(work.realTimeErrors);
    Times(work);
    if (isWide) ImGui::EndChild();
}

}  // namespace raygraph::editor
