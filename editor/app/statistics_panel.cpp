// Shows the picture's cost: samples, error and time left, memory, times of the passes over the last frames.

#include "editor/app/statistics_panel.h"

#include <imgui.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>

#include "base/text.h"
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

void Legend(const std::vector<FrameHistory::Pass>& passes) {
    for (size_t i = 0; i < passes.size(); ++i) {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float side = ImGui::GetTextLineHeight();
        ImGui::GetWindowDrawList()->AddRectFilled(
            {at.x, at.y + 3.0f}, {at.x + side - 6.0f, at.y + side - 3.0f}, kColors[std::min(i, kColored)]);
        ImGui::Dummy({side, side});
        ImGui::SameLine();
        ImGui::Text("%8.3f ms", double{passes[i].ms.back()});
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
    Times(work);
    if (isWide) ImGui::EndChild();
}

std::vector<MemoryRow> MemoryRows(const rhi::MemoryStatistics& memory,
                                  std::span<const rhi::MemoryHeap> heaps) {
    std::vector<MemoryRow> rows{
        {"memory", BytesText(memory.usedBytes) + ", peak " + BytesText(memory.peakBytes)}};
    if (memory.fallbackBytes > 0)
        rows.push_back({"", BytesText(memory.fallbackBytes) + " in the host's memory: the device's is full"});
    for (const rhi::MemoryHeap& heap : heaps)
        rows.push_back({heap.isDeviceLocal ? "device heap" : "host heap",
                        BytesText(heap.usedBytes) + " of " + BytesText(heap.budgetBytes)});
    return rows;
}

void FrameHistory::Add(const FrameTiming& timing) {
    Timed frame;
    frame.cpuMs = static_cast<float>(timing.declareMs + timing.compileMs + timing.recordMs + timing.submitMs);
    for (const PassTiming& pass : timing.passes) {
        const auto found = std::ranges::find(m_names, pass.name);
        const auto index = static_cast<size_t>(found - m_names.begin());
        if (found == m_names.end()) m_names.push_back(pass.name);
        frame.passes.emplace_back(index, static_cast<float>(pass.gpuMs));
    }
    m_frames.push_back(std::move(frame));
    if (m_frames.size() > kLength) m_frames.pop_front();
}

std::vector<float> FrameHistory::Gpu() const {
    std::vector<float> times;
    for (const Timed& frame : m_frames)
        times.push_back(std::accumulate(frame.passes.begin(), frame.passes.end(), 0.0f,
                                        [](float sum, const auto& pass) { return sum + pass.second; }));
    return times;
}

std::vector<float> FrameHistory::Cpu() const {
    std::vector<float> times;
    for (const Timed& frame : m_frames) times.push_back(frame.cpuMs);
    return times;
}

std::vector<FrameHistory::Pass> FrameHistory::Passes() const {
    std::vector<Pass> passes;
    for (const std::string& name : m_names)
        passes.push_back({.name = name, .ms = std::vector<float>(m_frames.size(), 0.0f)});
    for (size_t i = 0; i < m_frames.size(); ++i)
        for (const auto& [index, ms] : m_frames[i].passes) passes[index].ms[i] += ms;
    std::erase_if(passes, [](Pass& pass) {
        const float sum = std::accumulate(pass.ms.begin(), pass.ms.end(), 0.0f);
        pass.mean = pass.ms.empty() ? 0.0f : sum / static_cast<float>(pass.ms.size());
        return sum == 0.0f;
    });
    std::ranges::stable_sort(passes, [](const Pass& a, const Pass& b) { return a.mean > b.mean; });
    return passes;
}

void SampleRate::Add(double seconds, double samples) {
    if (!m_points.empty() && samples < m_points.back().samples) m_points.clear();
    m_points.push_back({seconds, samples});
    // Keep one point just before the span
    while (m_points.size() > 2 && m_points[1].seconds < seconds - kSpan) m_points.pop_front();
}

std::optional<double> SampleRate::PerSecond() const {
    if (m_points.size() < 2) return std::nullopt;
    const double span = m_points.back().seconds - m_points.front().seconds;
    if (span < 0.25) return std::nullopt;
    return (m_points.back().samples - m_points.front().samples) / span;
}

double SecondsLeft(double error, double target, double samples, double samplesPerSecond) {
    const double times = error / target;
    return std::max(0.0, samples * (times * times - 1.0) / samplesPerSecond);
}

}  // namespace raygraph::editor
