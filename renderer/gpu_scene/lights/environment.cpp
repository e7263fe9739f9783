#include "renderer/gpu_scene/lights/environment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <span>
#include <utility>

#include "base/check.h"
#include "base/error.h"
#include "base/text.h"
#include "renderer/gpu_scene/device_limits.h"
#include "renderer/gpu_scene/lights/light_set.h"
#include "renderer/scene/model/check.h"
#include "renderer/scene/model/studio.h"

namespace raygraph {

namespace {

// A fraction of the mean luminance: directions that are no brighter are left to BSDF sampling, which finds
// them as well. The value is measured (docs/performance.md); with 1, an even map would have no density at
// all.
constexpr double kShareLeftToScattering = 0.5;

// Returns the luminance of a Rec. 709 color.
double Luminance(const glm::dvec3& color) {
    return 0.2126 * color.x + 0.7152 * color.y + 0.0722 * color.z;
}

// One row of the means of the interpolated map over the cells of its texels: a cell takes 3/4 from its own
// texel and 1/8 from each neighbor, along both axes.
class TexelMeans {
  public:
    explicit TexelMeans(const image::ImageF& map) : m_map(map), m_column(map.width), m_row(map.width) {}

    const std::vector<glm::dvec3>& Row(uint32_t y) {
        const uint32_t above = y > 0 ? y - 1 : 0;
        const uint32_t below = y + 1 < m_map.height ? y + 1 : y;
        for (uint32_t x = 0; x < m_map.width; ++x)
            m_column[x] = 0.125 * (Texel(x, above) + Texel(x, below)) + 0.75 * Texel(x, y);
        for (uint32_t x = 0; x < m_map.width; ++x) {
            const glm::dvec3& left = m_column[x > 0 ? x - 1 : m_map.width - 1];
            const glm::dvec3& right = m_column[x + 1 < m_map.width ? x + 1 : 0];
            m_row[x] = 0.125 * (left + right) + 0.75 * m_column[x];
        }
        return m_row;
    }

  private:
    glm::dvec3 Texel(uint32_t x, uint32_t y) const {
        const float* texel = &m_map.rgba[4 * (size_t{y} * m_map.width + x)];
        return {texel[0], texel[1], texel[2]};
    }

    const image::ImageF& m_map;
    std::vector<glm::dvec3> m_column, m_row;
};

// Returns the solid angle of a texel of row y.
double SolidAngle(const image::ImageF& map, uint32_t y) {
    const double theta0 = std::numbers::pi * y / map.height;
    const double theta1 = std::numbers::pi * (y + 1) / map.height;
    return 4.0 * std::numbers::pi / map.width * std::sin(0.5 * (theta0 + theta1)) *
           std::sin(0.5 * (theta1 - theta0));
}

// Returns the integral, over the solid angle of a texel of row y, of the cosine to +y where that is positive.
double CosineOfSky(const image::ImageF& map, uint32_t y) {
    const auto sine2 = [&](uint32_t row) {  // of the angle to +y, at most 90 degrees
        const double sine = std::sin(std::numbers::pi * std::min(row / static_cast<double>(map.height), 0.5));
        return sine * sine;
    };
    return std::numbers::pi / map.width * (sine2(y + 1) - sine2(y));
}

struct EnvironmentMeans {
    glm::dvec3 radiance{0.0};       // over the sphere
    glm::dvec3 skyIrradiance{0.0};  // EnvironmentTable::skyIrradiance
};

EnvironmentMeans MeansOf(const image::ImageF& map, TexelMeans& means) {
    EnvironmentMeans result;
    for (uint32_t y = 0; y < map.height; ++y) {
        glm::dvec3 sum(0.0);
        for (const glm::dvec3& texel : means.Row(y)) sum += texel;
        result.radiance += SolidAngle(map, y) / (4.0 * std::numbers::pi) * sum;
        result.skyIrradiance += CosineOfSky(map, y) * sum;
    }
    return result;
}

// Distributes the kEnvironmentSteps steps of u over the entries in proportion to their weights, with at least
// one for each weight above 0. Returns the sum of the weights.
double ApportionSteps(std::span<const double> weights, std::span<gpu::EnvironmentEntry> entries) {
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    const auto count = static_cast<uint32_t>(weights.size());
    if (!(sum > 0.0)) {
        std::fill(entries.begin(), entries.end(), gpu::EnvironmentEntry{});
        return 0.0;
    }
    const auto litCount = static_cast<uint32_t>(
        std::count_if(weights.begin(), weights.end(), [](double w) { return w > 0.0; }));
    RG_CHECK_LE(litCount, gpu::kEnvironmentSteps);
    const double rest = gpu::kEnvironmentSteps - litCount;
    uint32_t first = 0, lit = 0, slot = 0;
    double before = 0.0;
    for (uint32_t i = 0; i < count; ++i) {
        before += weights[i];
        lit += weights[i] > 0.0;
        const uint32_t end = lit == litCount
                                 ? gpu::kEnvironmentSteps
                                 : lit + static_cast<uint32_t>(rest * std::min(before / sum, 1.0));
        entries[i].end = static_cast<float>(end) / gpu::kEnvironmentSteps;
        entries[i].probability = static_cast<float>(end - first) / gpu::kEnvironmentSteps;
        // Slot s holds the u with u * count in [s, s + 1). The greatest step below s / count may round up to
        // it
        const auto lastBefore = [&](uint32_t s) {
            return s == 0 ? 0 : (uint64_t{s} * gpu::kEnvironmentSteps - 1) / count;
        };
        for (; slot < count && lastBefore(slot) < end; ++slot) entries[slot].guide = i;
        first = end;
    }
    return sum;
}

}  // namespace

void RequireRadiance(const image::ImageF& map) {
    const size_t count = size_t{4} * map.width * map.height;
    if (count == 0 || map.rgba.size() != count)
        throw MakeError(ErrorKind::Usage, "GpuScene: SetEnvironmentMap: {}x{} texels asked for, {} given",
                        map.width, map.height, map.rgba.size() / 4);
    for (size_t i = 0; i < count; ++i)
        if (!std::isfinite(map.rgba[i]) || map.rgba[i] < 0.0f)
            throw MakeError(
                ErrorKind::Usage,
                "GpuScene: SetEnvironmentMap: texel {}, {} holds {}, must be finite and not negative",
                i / 4 % map.width, i / 4 / map.width, map.rgba[i]);
}

EnvironmentTable BuildEnvironmentTable(const image::ImageF& map, uint64_t maxCells) {
    RG_CHECK(map.width > 0 && map.height > 0);
    uint32_t step = 1;
    while (uint64_t{map.width / step} * (map.height / step) > maxCells && map.width % (2 * step) == 0 &&
           map.height % (2 * step) == 0)
        step *= 2;
    EnvironmentTable result{.width = map.width / step, .height = map.height / step, .entries = {}};
    result.entries.resize(size_t{result.height} * (result.width + 1));
    const std::span<gpu::EnvironmentEntry> rows = std::span(result.entries).first(result.height);

    TexelMeans means(map);
    const EnvironmentMeans mean = MeansOf(map, means);
    const double level = kShareLeftToScattering * Luminance(mean.radiance);
    std::vector<double> rowWeights(result.height);
    std::vector<double> weights(result.width);
    for (uint32_t row = 0; row < result.height; ++row) {
        std::fill(weights.begin(), weights.end(), 0.0);
        for (uint32_t y = row * step; y < (row + 1) * step; ++y) {
            const double solidAngle = SolidAngle(map, y);
            const std::vector<glm::dvec3>& texels = means.Row(y);
            for (uint32_t x = 0; x < map.width; ++x)
                weights[x / step] += solidAngle * std::max(Luminance(texels[x]) - level, 0.0);
        }
        const size_t first = result.height + size_t{row} * result.width;
        rowWeights[row] = ApportionSteps(weights, std::span(result.entries).subspan(first, result.width));
    }
    ApportionSteps(rowWeights, rows);
    for (uint32_t row = 0; row < result.height; ++row) {
        const size_t first = result.height + size_t{row} * result.width;
        for (gpu::EnvironmentEntry& cell : std::span(result.entries).subspan(first, result.width))
            if (cell.probability > 0.0f)
                cell.probability =
                    std::max(cell.probability * rows[row].probability, std::numeric_limits<float>::min());
    }
    result.meanRadiance = glm::vec3(mean.radiance);
    result.skyIrradiance = glm::vec3(mean.skyIrradiance);
    return result;
}

EnvironmentTable ConstantEnvironmentTable() {
    const gpu::EnvironmentEntry all{.end = 1.0f, .guide = 0, .probability = 1.0f};
    EnvironmentTable result;
    result.entries.assign(2, all);
    return result;
}

// --- Map and table on the device ---

namespace {

// `texel` is one texel of the format.
rhi::Texture SolidTexture(rhi::Device& device, rhi::Uploader& uploader, const char* name, rhi::Format format,
                          std::span<const std::byte> texel) {
    rhi::Texture texture = device.CreateTexture({.name = name, .extent = {1, 1}, .format = format});
    uploader.UploadTexture(texture, texel);
    return texture;
}

rhi::Buffer UploadTable(rhi::Device& device, rhi::Uploader& uploader, const EnvironmentTable& table) {
    RequireBindable(device, "entries of the environment's table", table.entries.size(),
                    sizeof(table.entries[0]));
    const std::span<const std::byte> bytes = std::as_bytes(std::span(table.entries));
    rhi::Buffer buffer =
        device.CreateBuffer({.name = "environment table",
                             .size = bytes.size(),
                             .usage = rhi::BufferUsage::Storage | rhi::BufferUsage::CopySource |
                                      rhi::BufferUsage::CopyDestination});
    uploader.UploadBuffer(buffer, 0, bytes);
    return buffer;
}

}  // namespace

rhi::Texture WhiteTexture(rhi::Device& device, rhi::Uploader& uploader) {
    const uint32_t white = 0xFFFFFFFFu;
    return SolidTexture(device, uploader, "white", rhi::Format::Rgba8Unorm,
                        std::as_bytes(std::span(&white, 1)));
}

EnvironmentOnDevice UploadEnvironment(rhi::Device& device, rhi::Uploader& uploader,
                                      const image::ImageF& map) {
    EnvironmentOnDevice result;
    result.map = device.CreateTexture(
        {.name = "environment map", .extent = {map.width, map.height}, .format = rhi::Format::Rgba32Float});
    const EnvironmentTable table = BuildEnvironmentTable(map);
    result.table = UploadTable(device, uploader, table);
    uploader.UploadTexture(result.map, std::as_bytes(std::span(map.rgba)));
    result.cells = {table.width, table.height};
    result.meanRadiance = table.meanRadiance;
    result.skyIrradiance = table.skyIrradiance;
    return result;
}

EnvironmentOnDevice BlankEnvironment(rhi::Device& device, rhi::Uploader& uploader) {
    const glm::vec4 black(0.0f);
    EnvironmentOnDevice result;
    result.map = SolidTexture(device, uploader, "no environment map", rhi::Format::Rgba32Float,
                              std::as_bytes(std::span(&black, 1)));
    result.table = UploadTable(device, uploader, ConstantEnvironmentTable());
    return result;
}

SceneEnvironment::SceneEnvironment(rhi::Device& device, rhi::Uploader& uploader)
    : m_device(device), m_uploader(uploader), m_blank(BlankEnvironment(device, uploader)) {}

bool SceneEnvironment::Set(const EnvironmentSettings& settings) {
    if (m_settings == settings) return false;
    if (!scene::IsFinite(settings.radiance) || glm::any(glm::lessThan(settings.radiance, glm::vec3(0.0f))) ||
        !std::isfinite(settings.rotation))
        throw Error(ErrorKind::Usage,
                    "GpuScene: SetEnvironment: radiance and rotation must be finite, radiance not negative");
    m_settings = settings;
    return true;
}

void SceneEnvironment::SetMap(const image::ImageF& equirectangular) {
    RequireRadiance(equirectangular);
    std::optional<EnvironmentOnDevice> uploaded;
    m_uploader.FlushAfter([&] { uploaded = UploadEnvironment(m_device, m_uploader, equirectangular); });
    m_ofHost = std::move(uploaded);
    ++m_version;
}

bool SceneEnvironment::RemoveMap() {
    if (!m_ofHost) return false;
    m_ofHost.reset();
    ++m_version;
    return true;
}

EnvironmentSettings SceneEnvironment::Shown() const {
    EnvironmentSettings shown = m_settings;
    shown.defaultLight = ShownDefault();
    return shown;
}

void SceneEnvironment::SetScene(std::optional<EnvironmentOnDevice>&& map, bool hasOwnLight) {
    if (map || m_ofScene) ++m_version;
    m_ofScene = std::move(map);
    m_sources = {};
    m_sources.isScene = hasOwnLight;
}

DefaultLight SceneEnvironment::ShownDefault() const {
    if (m_ofHost || !m_settings.usesScene) return DefaultLight::None;
    if (m_settings.defaultLight != DefaultLight::Auto) return m_settings.defaultLight;
    return m_ofScene || m_sources.IsAny() ? DefaultLight::None : DefaultLight::Studio;
}

void SceneEnvironment::Declare(Renderer& renderer, SceneIds& ids, LightSet& lights) {
    EnvironmentOnDevice* map = m_ofHost ? &*m_ofHost : nullptr;
    const bool hasStudio = ShownDefault() == DefaultLight::Studio;
    if (hasStudio && !m_studio)
        m_uploader.FlushAfter(
            [&] { m_studio = UploadEnvironment(m_device, m_uploader, scene::StudioMap()); });
    if (std::exchange(m_hadStudio, hasStudio) != hasStudio) ++m_version;
    if (hasStudio) map = &*m_studio;
    if (!map && m_settings.usesScene && m_ofScene) map = &*m_ofScene;
    const bool isDark = !map && m_settings.usesScene;
    const glm::vec3 radiance = isDark ? glm::vec3(0.0f) : m_settings.radiance;
    EnvironmentOnDevice& shown = map ? *map : m_blank;
    ids.environment = {.radiance = radiance, .rotation = m_settings.rotation, .hasMap = map ? 1u : 0u};
    ids.environmentVersion = m_version;
    ids.environmentMap = renderer.Import("environmentMap", shown.map, shown.mapState);
    ids.environmentTable = renderer.Import("environmentTable", shown.table, shown.tableState);
    lights.SetEnvironment(radiance * shown.meanRadiance,
                          static_cast<float>(Luminance(radiance * shown.skyIrradiance)), m_settings.rotation,
                          shown.cells);
}

}  // namespace raygraph
