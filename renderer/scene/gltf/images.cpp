#include "renderer/scene/gltf/images.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <exception>
#include <future>
#include <optional>
#include <semaphore>
#include <span>
#include <type_traits>
#include <utility>

#include "base/error.h"
#include "base/printable.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "renderer/image/image.h"
#include "renderer/scene/gltf/container.h"
#include "renderer/scene/model/scene_fields.h"

namespace raygraph::scene {
namespace {

// Returns the name of a format that DecodeImage8 reads.
const char* FormatName(std::span<const std::byte> bytes) {
    switch (image::SniffFormat(bytes)) {
        case image::FileFormat::Png:
            return "PNG";
        case image::FileFormat::Jpeg:
            return "JPEG";
        case image::FileFormat::Webp:
            return "WebP";
        case image::FileFormat::Dds:
            return "DDS";
        default:
            return "KTX2";
    }
}

// Files are read here, one after another, and decoded by tasks, of which so many run at once and twice as
// many are begun, lest one large image stops the others. A task only tries: what it cannot do is done again
// here, in the list's order and within what is left by then, so that every failure is the one that a single
// thread meets.
class ImageDecoder {
  public:
    ImageDecoder(GltfContext& context, const std::vector<ImageSource>& sources, GltfBuffers& buffers)
        : m_context(context),
          m_sources(sources),
          m_buffers(buffers),
          m_threads(context.ThreadCount()),
          m_running(m_threads),
          m_budget(context.options.limits.maxAllImageTexels, TexelsAtOnce(context.options.limits)) {}

    std::vector<ImageData> Decode(const std::vector<ImageChoice>& choices, const std::vector<bool>& isShown) {
        const size_t begunAtOnce = m_threads == 1 ? 1 : size_t{2} * m_threads;
        std::vector<ImageData> decoded;
        for (size_t begun = 0; decoded.size() < choices.size();) {
            while (begun < choices.size() && m_tasks.size() < begunAtOnce) Begin(choices[begun++].front());
            const auto done = static_cast<float>(decoded.size()) / static_cast<float>(choices.size());
            m_context.Progress("images", 0.5f + 0.5f * done);
            const size_t next = decoded.size();
            decoded.push_back(isShown[next] ? Finish(m_tasks.front(), choices[next])
                                            : FinishUnshown(m_tasks.front(), choices[next]));
            m_tasks.pop_front();
        }
        return decoded;
    }

  private:
    struct Picture {
        ImageData data;  // without its name
        std::vector<std::string> warnings;
    };
    struct Attempt {
        std::optional<Picture> picture;  // none: it failed, for whatever reason
        double seconds = 0.0;
    };
    struct Task {
        std::string name;
        std::string path;   // ImageData::file
        std::string label;  // for messages
        std::vector<std::byte> file;
        std::span<const std::byte> bytes;
        std::exception_ptr unread;     // Why there are no bytes.
        std::future<Attempt> attempt;  // Last: it reads the others.
    };

    // Returns how many texels may be decoded at once. The decoders then need, in addition to the texels, at
    // most the memory of one for the largest image, or about half of the memory of all texels.
    static uint64_t TexelsAtOnce(const LoadLimits& limits) {
        return std::max(limits.maxImageTexels, limits.maxAllImageTexels / 4);
    }

    void Begin(uint32_t image) {
        Task& task = m_tasks.emplace_back();
        Read(task, image);
        if (task.unread || m_threads == 1) return;
        // Deferred where there are no more threads to be had: then Finish() runs it
        task.attempt =
            std::async(std::launch::async | std::launch::deferred, [this, &task] { return Try(task); });
    }

    void Read(Task& task, uint32_t image) {
        const ImageSource& source = m_sources[image];
        const Place where = Place("images")[image];
        task.name = source.name;
        try {
            if (source.uri && !IsDataUri(*source.uri)) task.path = PercentDecode(*source.uri);
            if (task.name.empty()) task.name = task.path;
            if (source.uri) task.file = m_context.ReadUri(*source.uri, where["uri"]);
            task.bytes = source.uri ? std::span<const std::byte>(task.file) : m_buffers.View(source.view);
        } catch (...) {
            task.unread = std::current_exception();
            return;
        }
        task.label = Text("{}: {}", m_context.label, where.Path());
        if (!task.name.empty()) task.label += Text(" {}", Quoted(task.name, 60));
    }

    Attempt Try(const Task& task) {
        m_running.acquire();
        Attempt attempt;
        const Stopwatch watch;
        try {
            image::DecodeLimits limits = Limits(m_context.options.limits.maxImageTexels);
            image::PixelBudget::Share share(m_budget);
            limits.share = &share;
            attempt.picture = Decoded(task, limits);
        } catch (...) {
            attempt.picture.reset();
        }
        attempt.seconds = watch.Seconds();
        m_running.release();
        return attempt;
    }

    Picture Decoded(const Task& task, const image::DecodeLimits& limits) const {
        image::Image8 image = image::DecodeImage8(task.bytes, task.label, limits);
        ImageData data{.name = {},
                       .width = image.width,
                       .height = image.height,
                       .rgba = std::move(image.rgba),
                       .blocks = std::move(image.blocks)};
        data.lowestAlpha = LowestAlpha(data);
        return {std::move(data), std::move(image.warnings)};
    }

    ImageData FinishUnshown(Task& task, const ImageChoice& choice) {
        try {
            return Finish(task, choice);
        } catch (const Error& error) {
            if (error.Kind() != ErrorKind::BadInput) throw;
            m_context.warnings.Add("unshown image", Text("{}; no picture shows it, left out", error.what()));
            return {.name = std::move(task.name), .width = 1, .height = 1, .rgba = {255, 255, 255, 255}};
        }
    }

    // Returns the image of the task, or another one of the choice.
    ImageData Finish(Task& task, const ImageChoice& choice) {
        for (size_t next = 1;; ++next) {
            try {
                if (next == 1) return Finish(task);
                Task other;
                Read(other, choice[next - 1]);
                return Finish(other);
            } catch (const Error& error) {
                if (next == 1) task.unread = std::current_exception();
                if (next == choice.size()) std::rethrow_exception(task.unread);
                m_context.warnings.Add("image replaced",
                                       Text("{}; images[{}] takes its place", error.what(), choice[next]));
            }
        }
    }

    ImageData Finish(Task& task) {
        if (task.unread) std::rethrow_exception(task.unread);
        const uint64_t texelsLeft = m_context.options.limits.maxAllImageTexels - m_context.imageTexels;
        Attempt attempt;
        if (task.attempt.valid()) attempt = task.attempt.get();
        std::optional<Picture>& picture = attempt.picture;
        if (!picture || uint64_t{picture->data.width} * picture->data.height > texelsLeft) {
            const Stopwatch watch;
            const uint64_t maxTexels = std::min(m_context.options.limits.maxImageTexels, texelsLeft);
            picture = Decoded(task, Limits(maxTexels));
            attempt.seconds = watch.Seconds();
        }
        for (std::string& warning : picture->warnings)
            m_context.warnings.Add("image file", std::move(warning));
        ImageData& image = picture->data;
        WriteLog(m_context.options.log, LogLevel::Debug, log_category::kScene,
                 "{}: {} x {} {} of {} decoded in {}", task.label, image.width, image.height,
                 FormatName(task.bytes), BytesText(task.bytes.size()), DurationText(attempt.seconds));
        image.name = std::move(task.name);
        image.file = std::move(task.path);
        m_context.imageTexels += uint64_t{image.width} * image.height;
        return std::move(image);
    }

    image::DecodeLimits Limits(uint64_t maxTexels) const {
        const uint32_t extent = m_context.options.limits.maxImageExtent;
        return {.maxWidth = extent, .maxHeight = extent, .maxPixels = maxTexels};
    }

    GltfContext& m_context;
    const std::vector<ImageSource>& m_sources;
    GltfBuffers& m_buffers;
    const unsigned m_threads;
    std::counting_semaphore<> m_running;
    image::PixelBudget m_budget;  // shared by all tasks
    std::deque<Task> m_tasks;     // Last: they are waited for before the others go.
};

}  // namespace

std::vector<ImageData> DecodeImages(GltfContext& context, const std::vector<ImageSource>& sources,
                                    const std::vector<ImageChoice>& choices, const std::vector<bool>& isShown,
                                    GltfBuffers& buffers) {
    return ImageDecoder(context, sources, buffers).Decode(choices, isShown);
}

// --- Normal maps of two channels ---

namespace {

constexpr size_t kBlue = 2, kTexelBytes = 4;

// No normal map with three channels is: all of its normals would point down.
bool HasNoBlue(const ImageData& image) {
    for (size_t i = kBlue; i < image.rgba.size(); i += kTexelBytes)
        if (image.rgba[i] != 0) return false;
    return true;
}

void AddZ(ImageData& image) {
    for (size_t i = 0; i < image.rgba.size(); i += kTexelBytes) {
        const float x = 2.0f * image.rgba[i] / 255.0f - 1.0f, y = 2.0f * image.rgba[i + 1] / 255.0f - 1.0f;
        const float z = std::sqrt(std::max(1.0f - x * x - y * y, 0.0f));
        image.rgba[i + kBlue] = static_cast<uint8_t>(std::lround(255.0f * (0.5f + 0.5f * z)));
    }
    // Shaders give it to what they read from blocks of two channels
    if (image.blocks.coding != image::BlockCoding::Bc5) image.blocks = {};
}

}  // namespace

void CompleteNormalMaps(SceneData& scene) {
    struct Uses {
        bool isNormalMap = false, isOther = false;
    };
    std::vector<Uses> uses(scene.images.size());
    for (const Material& material : scene.materials)
        ForEachMaterialField([&](const auto& field) {
            if constexpr (std::is_same_v<decltype(field.member), TextureRef Material::*>) {
                const TextureRef& reference = material.*field.member;
                if (!reference.IsPresent()) return;
                const bool isNormalMap = field.member == &Material::normalTexture ||
                                         field.member == &Material::clearcoatNormalTexture;
                Uses& image = uses.at(scene.textures.at(static_cast<size_t>(reference.texture)).image);
                (isNormalMap ? image.isNormalMap : image.isOther) = true;
            }
        });
    for (size_t i = 0; i < uses.size(); ++i)
        if (uses[i].isNormalMap && !uses[i].isOther && HasNoBlue(scene.images[i])) AddZ(scene.images[i]);
}

}  // namespace raygraph::scene
